# SPDX-License-Identifier: GPL-3.0-or-later
"""Saving .blend files whole or not at all."""

import os
from pathlib import Path

import bpy

from ..reference_py.atomic import replacing
from ..reference_py.errors import LaminaError


def save_copy(path: str | os.PathLike) -> None:
    """Save the open file as a compressed copy. Raises LaminaError; then `path` is as it was before."""
    output = Path(path)
    with replacing(output) as temporary:
        temporary.unlink()  # Blender would keep the empty file as a backup, .blend1
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(temporary.resolve()), copy=True, compress=True, relative_remap=True)
        except RuntimeError as error:
            raise LaminaError(f"{output}: Blender cannot save it: {str(error).strip()}") from None
