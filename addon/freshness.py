# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values are made anew before a render or a save shows old ones."""

import bpy
from bpy.app.handlers import persistent

from ..reference_py.errors import LaminaError
from .material import is_stale, refresh


@persistent
def refresh_stale(*_) -> None:
    """Refresh every stale material of this file; one that cannot be is named, as handlers cannot report otherwise."""
    for material in bpy.data.materials:
        if material.library is None and material.lamina.is_layered:
            try:
                if is_stale(material):
                    print(f"Lamina: {material.name}: values changed, its shader is made anew")
                    refresh(material)
            except LaminaError as error:
                print(f"Lamina: {material.name} keeps its old shader: {error}")


def _handlers() -> list[list]:
    return [bpy.app.handlers.render_init, bpy.app.handlers.save_pre]


def register() -> None:
    for handlers in _handlers():
        handlers.append(refresh_stale)


def unregister() -> None:
    for handlers in _handlers():
        handlers.remove(refresh_stale)
