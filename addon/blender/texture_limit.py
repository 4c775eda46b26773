# SPDX-License-Identifier: GPL-3.0-or-later
"""Simplify's texture limit, which makes Cycles shrink every image that is larger, tables too."""

import bpy

_OFF = "OFF"
_SETTINGS = ("texture_limit", "texture_limit_render")  # of the viewport and of renders


def texture_limit(scene: bpy.types.Scene) -> float:
    """The longest side in pixels that a scene leaves an image in the viewport and in renders; infinite without a limit."""
    limits = [getattr(scene.cycles, name) for name in _SETTINGS] if scene.render.use_simplify and hasattr(scene, "cycles") else []
    return min((float(limit) for limit in limits if limit != _OFF), default=float("inf"))


def allow(scene: bpy.types.Scene, size: int) -> None:
    """Raise the limits of a scene, where they are below, to the least that leaves an image of `size` pixels as it is."""
    for name in _SETTINGS:
        limit = getattr(scene.cycles, name)
        if limit != _OFF and int(limit) < size:
            larger = [item.identifier for item in scene.cycles.bl_rna.properties[name].enum_items if item.identifier != _OFF and int(item.identifier) >= size]
            setattr(scene.cycles, name, min(larger, key=int, default=_OFF))
