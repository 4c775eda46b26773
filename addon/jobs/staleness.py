# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values, or that stand in for a bake, are made anew before a save; a render of them is announced."""

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.methods import holds_values
from ..material import state
from ..material.backend import NODES
from ..material.elements import kind_of
from ..material.hand_over import is_handed_over
from ..material.live_values import what_moves
from ..material.material import hand_over, refresh, refresh_stock
from ..material.osl_setting import shows_osl
from ..material.pasted import adopt_pasted
from ..material.reading import is_own, measure_means, stack_of
from ..material.record import changed_values, keep_record
from ..material.roles import node_with
from ..material.shader_node import shader_of
from .prefetch import prefetch

_STALE = "renders old values: save the file, press Update in its panel, or call bpy.ops.lamina.regenerate()"
_STOCK_BEHIND = "renders old values: its stock nodes are behind; save the file, or press Update in its panel"


@persistent
def make_ready(*_) -> None:
    """Make every material of this file what its tier stands for, and what exporters find. With a window, bakes are left to `bakes`."""
    for material in bpy.data.materials:
        adopt_pasted(material)
    _for_each(lambda material: True, measure_means)
    if bpy.app.background:
        wanted: list[state.Wanted] = []
        _for_each(_needs_bake, lambda material: wanted.extend(filter(None, (state.wanted_lobes(material), state.wanted_stock(material)))))
        prefetch(wanted, lambda message: print(f"Lamina: {message}"))
    _for_each(_is_unready, _make_ready)
    _for_each(_is_not_handed_over, lambda material: hand_over(material, settle=bpy.app.background))
    _for_each(lambda material: not state.lags(material), keep_record)


def _is_unready(material) -> bool:
    return _is_behind(material) or state.lags(material)


def _needs_bake(material) -> bool:
    return holds_values(material.lamina.tier) and _is_unready(material)


def _is_behind(material) -> bool:
    return state.is_stale(material) or not state.is_settled(material)


def _make_ready(material) -> None:
    alone = not _is_behind(material) and not state.lacks_branch(material)
    if bpy.app.background:
        sentence = "its stock nodes are made for the present values" if alone else "its shader is made for the present values"
        print(f"Lamina: {material.name}: {sentence}")
    (refresh_stock if alone else refresh)(material, settle=bpy.app.background)


def _is_not_handed_over(material) -> bool:
    return not is_handed_over(material, stack_of(material))


@persistent
def announce(scene=None, *_) -> None:
    """Name what a render shows wrong, with old values or provisionally. Blender 5.2 crashes when nodes change once a render has begun."""
    scene = scene if isinstance(scene, bpy.types.Scene) else bpy.context.scene
    if not shows_osl(scene, bpy.context.preferences):
        _for_each(
            _is_script_alone,
            lambda m: print(f"Lamina: {m.name}: renders black: it is an OSL script alone, and {scene.name} shows none; {_advice(m)}"),
            linked=True,
        )
        _for_each(state.lags, lambda m: print(f"Lamina: {m.name}: {_stands_still(m) or _STOCK_BEHIND}"))
    _for_each(lambda m: m.override_library is not None and (state.is_stale(m) or state.lags(m)), _say_override, linked=True)
    _for_each(
        lambda m: shader_of(m) is None,
        lambda m: print(f"Lamina: {m.name}: its shader node is gone: press Update in its panel, or call bpy.ops.lamina.regenerate()"),
    )
    _for_each(state.is_stale, lambda m: print(f"Lamina: {m.name}: {_stands_still(m) or _STALE}"))
    _for_each(
        lambda m: not state.is_stale(m) and not state.is_settled(m),
        lambda m: print(f"Lamina: {m.name}: renders with the tier analytic, as its bake is not done; a save without a window makes it"),
    )


def _say_override(material) -> None:
    print(f"Lamina: {material.name}: renders old values: it is a library override, of which Blender keeps no values of nodes; make it local to edit it")


def _is_script_alone(material) -> bool:
    return shader_of(material) is not None and node_with(material, NODES) is None


def _stands_still(material) -> str:
    """What to say where nothing but animation changed values since stock nodes were made: a save helps for one frame alone."""
    lamina = material.lamina
    moving = {f"{e.name}: {p.label}" for e in (*lamina.shown_layers, lamina.base) for p in kind_of(e).sockets if what_moves(e).get(p.name) == "animation"}
    changed = set(changed_values(material))
    if node_with(material, NODES) is None or not changed or changed - moving:
        return ""
    return "its animation stands still, as stock nodes cannot follow it; Cycles with OSL does, in the backend Automatic"


def _advice(material) -> str:
    if material.library is not None:
        return f"open {material.library.filepath} in this version of Lamina and save it"
    return "choose the backend Automatic" if material.lamina.backend == "osl" else "save the file"


def _for_each(concerns: Callable[[bpy.types.Material], bool], act: Callable[[bpy.types.Material], None], linked: bool = False) -> None:
    """Handlers cannot report, so what is done, or cannot be, is said on the console."""
    for material in bpy.data.materials:
        if not material.lamina.is_layered or not (linked or is_own(material)):
            continue
        try:
            if concerns(material):
                act(material)
        except LaminaError as error:
            print(f"Lamina: {material.name} keeps its old shader: {error}")


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    return [(bpy.app.handlers.save_pre, make_ready), (bpy.app.handlers.render_init, announce)]
