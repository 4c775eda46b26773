# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets that users save: a JSON stack, a .blend with its textures and a picture each, in a folder that updates of Lamina leave alone."""

import re
from collections.abc import Callable
from pathlib import Path

from ...reference_py.atomic import output_folder, write_text
from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material import presets
from ...reference_py.material.json_input import read_text
from ...reference_py.material.stack import Stack
from ..blender.translation import rpt_
from ..blender.user_folders import presets_folder
from .preset_catalogues import CATALOGUE_FILE, OWN, catalogue_head, catalogue_id, catalogue_line

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
    """Where the picture of a user's preset is; some have none."""
    return presets_folder() / f"{name}.png"


def asset_of(name: str) -> Path:
    """Where the material asset of a user's preset is, which has its textures; older or copied ones may have none."""
    return presets_folder() / f"{name}.blend"


def free_name(label: str) -> str:
    """The name, also that of the files, that a new preset gets for what its user calls it.

    Raises LaminaError for what is no plain file name, and for one that is taken by another preset.
    """
    text = label.strip()
    if not text:
        raise LaminaError("a preset needs a name")
    if len(text) > LONGEST:
        raise LaminaError("preset name {start}... has {count} letters; choose at most {most}", start=text[:24], count=len(text), most=LONGEST)
    if wrong := re.search(r"[^\w \-]", text):
        raise LaminaError(
            "preset name {text!r}: {letter!r} cannot be in a file's name; choose letters, digits, spaces, - and _", text=text, letter=wrong.group()
        )
    name = re.sub(r"\s+", "_", text.lower())
    if name in _DEVICES:
        raise LaminaError("preset name {text!r} is a device's on Windows; choose another", text=text)
    if name in presets.names():
        raise LaminaError("preset name {text!r} is one of Lamina's own; choose another", text=text)
    if name in names():
        raise LaminaError("preset name {text!r} is taken by a preset of yours; choose another, or remove that one first", text=text)
    return name


def save(label: str, stack: Stack, draw: Callable[[Path], None], keep: Callable[[Path], None]) -> tuple[str, str]:
    """Keep `stack` as a preset, with the picture that `draw` and the asset that `keep` writes to a path, in this order.

    Returns its name, and why there is no picture, empty if there is one. Raises LaminaError; then no file is left.
    """
    name, why = free_name(label), ""
    output_folder(presets_folder())
    _add_catalogue()
    files = picture_of(name), asset_of(name)
    try:
        try:
            draw(files[0])
        except LaminaError as error:
            files[0].unlink(missing_ok=True)
            why = error.told(rpt_)
        keep(files[1])
        stack.save(presets_folder() / f"{name}.json")
    except BaseException:
        for file in files:
            file.unlink(missing_ok=True)
        raise
    return name, why


def _add_catalogue() -> None:
    """Name the catalogue of own presets in the folder's list; what the user made of the list stays."""
    path = presets_folder() / CATALOGUE_FILE.name
    text = read_text(path, "asset catalogues") if path.exists() else catalogue_head("Asset catalogues of your presets")
    if catalogue_id(OWN) not in text:
        write_text(path, text.rstrip("\n") + f"\n{catalogue_line(f'Lamina/{OWN}')}\n")


def remove(name: str) -> None:
    """Delete a user's preset, its picture and its asset. Raises LaminaError."""
    path = _existing(name)
    try:
        path.unlink()
        picture_of(name).unlink(missing_ok=True)
        asset_of(name).unlink(missing_ok=True)
    except OSError as error:
        raise LaminaError("{path}: cannot delete it: {reason}", path=path, reason=error.strerror or error) from None


def _existing(name: str) -> Path:
    if name not in names():  # nothing else is a path below: neither ".." nor an absolute one is the stem of a file here
        choices = ", ".join(names()) or Sentence("none, there are none")
        raise LaminaError("unknown preset {name!r} of yours; choose {choices}", name=name, choices=choices)
    return presets_folder() / f"{name}.json"
