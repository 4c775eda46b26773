# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values are made anew before a save, and a render of old values is announced."""

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ..reference_py.errors import LaminaError
from .material import is_stale, refresh


@persistent
def refresh_stale(*_) -> None:
    """Refresh every stale material of this file."""
    _for_each_stale(refresh, "values changed, its shader is made anew")


@persistent
def announce_stale(*_) -> None:
    """Name what a render shows with old values. Blender 5.2 crashes when nodes change once a render has begun."""
    _for_each_stale(lambda material: None, "renders old values: save the file, or press Update in its panel")


def _for_each_stale(act: Callable[[bpy.types.Material], None], words: str) -> None:
    """Handlers cannot report, so what is done, or cannot be, is said on the console."""
    for material in bpy.data.materials:
        if material.library is not None or not material.lamina.is_layered:
            continue
        try:
            if is_stale(material):
                print(f"Lamina: {material.name}: {words}")
                act(material)
        except LaminaError as error:
            print(f"Lamina: {material.name} keeps its old shader: {error}")


def _handlers() -> list[tuple]:
    return [(bpy.app.handlers.save_pre, refresh_stale), (bpy.app.handlers.render_init, announce_stale)]


def register() -> None:
    for handlers, handler in _handlers():
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in _handlers():
        handlers.remove(handler)
