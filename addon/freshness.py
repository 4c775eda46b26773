# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values are made anew before a save, and a render of old values is announced."""

import bpy
from bpy.app.handlers import persistent

from ..reference_py.errors import LaminaError
from .material import is_stale, refresh


@persistent
def refresh_stale(*_) -> None:
    """Refresh every stale material of this file; one that cannot be is named, as handlers cannot report otherwise."""
    for material in _layered():
        try:
            if is_stale(material):
                print(f"Lamina: {material.name}: values changed, its shader is made anew")
                refresh(material)
        except LaminaError as error:
            print(f"Lamina: {material.name} keeps its old shader: {error}")


@persistent
def announce_stale(*_) -> None:
    """Name what a render shows with old values. Blender 5.2 crashes when nodes change once a render has begun."""
    for material in _layered():
        try:
            if is_stale(material):
                print(f"Lamina: {material.name} renders old values: save the file, or press Update in its panel")
        except LaminaError as error:
            print(f"Lamina: {material.name} keeps its old shader: {error}")


def _layered() -> list[bpy.types.Material]:
    return [m for m in bpy.data.materials if m.library is None and m.lamina.is_layered]


def _handlers() -> list[tuple]:
    return [(bpy.app.handlers.save_pre, refresh_stale), (bpy.app.handlers.render_init, announce_stale)]


def register() -> None:
    for handlers, handler in _handlers():
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in _handlers():
        handlers.remove(handler)
