# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets that users save: one JSON stack and one picture each, in a folder that updates of Lamina leave alone."""

import re
from collections.abc import Callable
from pathlib import Path

from ...reference_py import presets
from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from ...reference_py.stack import Stack
from ..user_folders import presets_folder

LONGEST = 60
# Names that Windows keeps for devices, with any ending.
_DEVICES = {"con", "prn", "aux", "nul", *(f"{device}{i}" for device in ("com", "lpt") for i in range(10))}


def names() -> list[str]:
    """Names of the user's presets, in alphabetical order; none where there is no folder."""
    return sorted(path.stem for path in presets_folder().glob("*.json"))


def load(name: str) -> Stack:
    """The stack of a user's preset. Raises LaminaError."""
    return Stack.load(_existing(name))


def picture_of(name: str) -> Path:
    """Where the picture of a user's preset is; older or copied ones may have none."""
    return presets_folder() / f"{name}.png"


def free_name(label: str) -> str:
    """The name, also that of the files, that a new preset gets for what its user calls it.

    Raises LaminaError for what is no plain file name, and for one that is taken by another preset.
    """
    text = label.strip()
    if not text:
        raise LaminaError("a preset needs a name")
    if len(text) > LONGEST:
        raise LaminaError(f"preset name {text[:24]}... has {len(text)} letters; choose at most {LONGEST}")
    if wrong := re.search(r"[^\w \-]", text):
        raise LaminaError(f"preset name {text!r}: {wrong.group()!r} cannot be in a file's name; choose letters, digits, spaces, - and _")
    name = re.sub(r"\s+", "_", text.lower())
    if name in _DEVICES:
        raise LaminaError(f"preset name {text!r} is a device's on Windows; choose another")
    if name in presets.names():
        raise LaminaError(f"preset name {text!r} is one of Lamina's own; choose another")
    if name in names():
        raise LaminaError(f"preset name {text!r} is taken by a preset of yours; choose another, or remove that one first")
    return name


def save(label: str, stack: Stack, draw: Callable[[Path], None]) -> str:
    """Keep `stack` as a preset, with the picture that `draw` writes to a path; returns its name.

    Raises LaminaError; then there is neither file.
    """
    name = free_name(label)
    output_folder(presets_folder())
    picture = picture_of(name)
    try:
        draw(picture)
        stack.save(presets_folder() / f"{name}.json")
    except BaseException:
        picture.unlink(missing_ok=True)
        raise
    return name


def remove(name: str) -> None:
    """Delete a user's preset and its picture. Raises LaminaError."""
    path = _existing(name)
    try:
        path.unlink()
        picture_of(name).unlink(missing_ok=True)
    except OSError as error:
        raise LaminaError(f"{path}: cannot delete it: {error.strerror or error}") from None


def _existing(name: str) -> Path:
    if name not in names():  # nothing else is a path below: neither ".." nor an absolute one is the stem of a file here
        raise LaminaError(f"unknown preset {name!r} of yours; choose {', '.join(names()) or 'none, there are none'}")
    return presets_folder() / f"{name}.json"
