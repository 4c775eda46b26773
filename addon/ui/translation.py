# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina's strings in other languages: one JSON file per locale, English to that language, for Blender's translation."""

import json
from pathlib import Path

import bpy

FOLDER = Path(__file__).parents[1] / "translations"
_NAME = "lamina"
# Where Blender looks: "Operator" for what operators are called, "*" for all else.
_CONTEXTS = ("*", "Operator")


def locales() -> list[str]:
    """The locales that there is a file for, such as "de_DE"."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load(locale: str) -> dict[str, str]:
    """The translations of a locale by their English text."""
    return json.loads((FOLDER / f"{locale}.json").read_text(encoding="utf-8"))


def register() -> None:
    tables = {locale: {(c, text): said for text, said in load(locale).items() for c in _CONTEXTS} for locale in locales()}
    bpy.app.translations.register(_NAME, tables)


def unregister() -> None:
    bpy.app.translations.unregister(_NAME)
