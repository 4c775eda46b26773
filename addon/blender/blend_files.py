# SPDX-License-Identifier: GPL-3.0-or-later
"""Opening .blend files, and saving them whole or not at all."""

import os
import struct
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy

from ...reference_py.atomic import replacing
from ...reference_py.errors import LaminaError
from .dependencies import named


def open_file(path: str | os.PathLike) -> None:
    """Open a file in place of the present one. Raises LaminaError."""
    try:
        bpy.ops.wm.open_mainfile(filepath=str(Path(path).resolve()), load_ui=False)
    except RuntimeError as error:
        raise LaminaError("{path}: Blender cannot open it: {reason}", path=path, reason=str(error).strip()) from None


def refuse_missing(name: str, missing: Sequence[str], is_allowed: bool, report: Callable[[str], None]) -> None:
    """Raise LaminaError naming what a .blend asks for and that is not there (`dependencies.missing`); where that is allowed, report it."""
    if missing and not is_allowed:
        raise LaminaError("{name}: {missing}; mend that, or give --allow-missing to go on without", name=name, missing=named(missing))
    if missing:
        report(f"{name}: goes on without what is missing: {named(missing)}")


def save_copy(path: str | os.PathLike, remap: bool = True) -> None:
    """Save the open file as a compressed copy. Raises LaminaError; then `path` is as it was before.

    Relative paths are written anew for the copy's place, unless what they name is copied too (`remap`).
    """

    def save(file: str) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=file, copy=True, compress=True, relative_remap=remap)

    _replace(path, save)


def save_material(path: str | os.PathLike, material: bpy.types.Material) -> None:
    """Save a material and what it needs as a file to append from. Raises LaminaError; then `path` is as it was before."""

    def save(file: str) -> None:
        bpy.data.libraries.write(file, {material}, path_remap="RELATIVE_ALL", fake_user=True, compress=True)

    _replace(path, save)


def _replace(path: str | os.PathLike, save) -> None:
    output = Path(path)
    with replacing(output) as temporary:
        temporary.unlink()  # Blender would keep the empty file as a backup, .blend1
        try:
            save(str(temporary.resolve()))
        except RuntimeError as error:
            raise LaminaError("{output}: Blender cannot save it: {reason}", output=output, reason=str(error).strip()) from None
        if not _is_whole(temporary):  # Blender calls it saved even where the disk is full
            raise LaminaError("{output}: Blender could not write all of it; is the disk full?", output=output)


def _is_whole(path: Path) -> bool:
    """Whether a compressed .blend has all the bytes that its table says: zstd frames, then a seek table.

    zstd's seekable format: per frame its compressed and its raw size, then the number of frames, a byte and a magic number.
    """
    data = path.read_bytes()
    if len(data) < 17:
        return False
    count, _, magic = struct.unpack("<IBI", data[-9:])
    table = 8 + 8 * count + 9
    if magic != 0x8F92EAB1 or table > len(data):
        return False
    sizes = struct.unpack(f"<{2 * count}I", data[len(data) - 9 - 8 * count : -9])
    return sum(sizes[::2]) + table == len(data)
