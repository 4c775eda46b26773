# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values, or that stand in for a bake, are made anew before a save; a render of them is announced."""

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ...reference_py.errors import LaminaError
from ..background.ahead import bake_ahead
from ..rendering import environment
from .backend import OSL
from .hand_over import is_handed_over
from .material import Wanted, hand_over, is_settled, is_stale, refresh, stack_of, wanted_network
from .shader_node import backend_of, has_shader


@persistent
def make_ready(*_) -> None:
    """Make every material of this file what its tier stands for, and what exporters find. With a window, bakes are left to `bakes`."""
    if bpy.app.background:
        wanted: list[Wanted] = []
        _for_each(_is_unready, lambda material: wanted.append(wanted_network(material)))
        bake_ahead(wanted, lambda told: print(f"Lamina: {told}"))
    _for_each(_is_unready, _make_ready)
    _for_each(_is_behind, lambda material: hand_over(material, settle=bpy.app.background))


def _is_unready(material) -> bool:
    return is_stale(material) or not is_settled(material)


def _make_ready(material) -> None:
    if bpy.app.background:
        print(f"Lamina: {material.name}: its shader is made for the present values")
    refresh(material, settle=bpy.app.background)


def _is_behind(material) -> bool:
    return not is_handed_over(material, stack_of(material))


@persistent
def announce(*_) -> None:
    """Name what a render shows with old values or provisionally. Blender 5.2 crashes when nodes change once a render has begun."""
    _for_each(lambda material: not has_shader(material), lambda material: print(f"Lamina: {material.name}: its shader node is gone: press Update in its panel, or call bpy.ops.lamina.regenerate()"))
    if not environment.renders_osl():
        _for_each(
            lambda material: has_shader(material) and backend_of(material) == OSL,
            lambda material: print(f"Lamina: {material.name}: renders wrong: its shader is an OSL script, and this Blender has no OSL; choose the backend Stock Nodes"),
        )
    _for_each(is_stale, lambda material: print(f"Lamina: {material.name}: renders old values: save the file, press Update in its panel, or call bpy.ops.lamina.regenerate()"))
    _for_each(
        lambda material: not is_stale(material) and not is_settled(material),
        lambda material: print(f"Lamina: {material.name}: renders with the tier analytic, as its bake is not done; a save without a window makes it"),
    )


def _for_each(concerns: Callable[[bpy.types.Material], bool], act: Callable[[bpy.types.Material], None]) -> None:
    """Handlers cannot report, so what is done, or cannot be, is said on the console."""
    for material in bpy.data.materials:
        if material.library is not None or not material.lamina.is_layered:
            continue
        try:
            if concerns(material):
                act(material)
        except LaminaError as error:
            print(f"Lamina: {material.name} keeps its old shader: {error}")


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    return [(bpy.app.handlers.save_pre, make_ready), (bpy.app.handlers.render_init, announce)]
