# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: one JSON stack per file, named by its file."""

import os
from pathlib import Path

from ...errors import LaminaError
from ..stack import Stack

FOLDER = Path(__file__).parent

# The surface types of Weidlich and Wilkie 2007, sections 6.1 and 6.2, which the measured charts are about.
PAPER = (
    "blue_wall_paint",
    "clean_copper",
    "crayon_paint",
    "frosted_metal",
    "frosted_paint",
    "glazed_mug",
    "metal_foil",
    "metallic_car_paint",
    "patina_copper",
    "tinted_glaze",
)


def names() -> list[str]:
    """Names of all presets, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def label(name: str) -> str:
    """How a preset's name reads in a menu."""
    return name.replace("_", " ").title()


def load(name_or_path: str | os.PathLike) -> Stack:
    """The stack of a preset's name or of a JSON file. Raises LaminaError; a name that is no preset lists them."""
    text = os.fspath(name_or_path)
    if text.isidentifier() and (FOLDER / f"{text}.json").is_file():
        return Stack.load(FOLDER / f"{text}.json")
    path = Path(text)
    if path.suffix == ".json" or path.parent != Path(".") or path.exists():
        return Stack.load(path)
    raise LaminaError("unknown preset {text!r}; choose {choices}, or give a JSON file", text=text, choices=", ".join(names()))
