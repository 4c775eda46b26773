# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that hold values, or that stand in for a bake, are made anew before a save; a render of them is announced."""

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ...reference_py.errors import LaminaError
from ..blender import environment
from ..material import elements, hand_over, live_values, osl_setting, pasted, reading, record, roles, shader_node, state
from ..material import material as materials
from ..material.backend import NODES, OSL
from ..material.marks import concern_us
from . import prefetch

_STALE = "renders old values: save the file, press Update in its panel, or call bpy.ops.lamina.regenerate()"
_OVERRIDE = "renders old values: it is a library override, of which Blender keeps no values of nodes; make it local to edit it"
_STOCK_BEHIND = "renders old values: its stock nodes are behind; save the file, or press Update in its panel"


@persistent
def make_ready(*_) -> None:
    """Make every material of this file what its tier stands for, and what exporters find. With a window, bakes are left to `bakes`."""
    if not concern_us():
        return
    for material in bpy.data.materials:
        pasted.adopt_pasted(material)
    each = _Rounds().each
    each(lambda material: True, reading.measure_means)
    if bpy.app.background:
        wanted: list[state.Wanted] = []
        hand_overs: list[hand_over.WantedHandOver] = []

        def want(material: bpy.types.Material) -> None:
            wanted.extend(state.to_compute(material))
            hand_overs.append(hand_over.WantedHandOver.of(material))

        each(_is_unready, want)
        prefetch.prefetch(wanted, hand_overs, lambda message: print(f"Lamina: {message}"))
    each(_is_unready, _make_ready)
    each(_is_not_handed_over, lambda material: materials.hand_over(material, settle=bpy.app.background))
    each(lambda material: not state.lags(material), record.keep_record)


def _is_unready(material) -> bool:
    return _is_behind(material) or state.lags(material)


def _is_behind(material) -> bool:
    return state.is_stale(material) or not state.is_settled(material)


def _make_ready(material) -> None:
    alone = not _is_behind(material) and not state.lacks_branch(material)
    if bpy.app.background:
        sentence = "its stock nodes are made for the present values" if alone else "its shader is made for the present values"
        print(f"Lamina: {material.name}: {sentence}")
    (materials.refresh_stock if alone else materials.refresh)(material, settle=bpy.app.background)


def _is_not_handed_over(material) -> bool:
    return not hand_over.is_handed_over(material, reading.stack_of(material))


@persistent
def announce(scene=None, *_) -> None:
    """Name what a render shows wrong, with old values or provisionally. Blender 5.2 crashes when nodes change once a render has begun."""
    if not concern_us():
        return
    for sentence in shown_wrong(scene if isinstance(scene, bpy.types.Scene) else bpy.context.scene):
        print(f"Lamina: {sentence}")


def shown_wrong(scene: bpy.types.Scene) -> list[str]:
    """One sentence for each material that a render of the scene shows with old values, provisionally, black or without its animation."""
    said: list[str] = []
    each = _Rounds().each
    shows = osl_setting.shows_osl(scene, bpy.context.preferences)

    def say(what: str) -> Callable[[bpy.types.Material], None]:
        return lambda material: said.append(f"{material.name}: {what}")

    if not shows:
        each(
            _is_script_alone,
            lambda m: say(f"renders black: it is an OSL script alone, and {scene.name} shows none; {_advice(m)}")(m),
            linked=True,
        )
        each(lambda m: state.lags(m) and not _only_animation_moved(m), say(_STOCK_BEHIND))
    each(
        lambda m: bool(_standing(m)) and not (shows and roles.node_with(m, OSL)),
        lambda m: say(f"its animation stands still, as stock nodes cannot follow {', '.join(_standing(m))}; {_remedy(m, scene)}")(m),
        linked=True,
    )
    each(lambda m: m.override_library is not None and (state.is_stale(m) or state.lags(m)), say(_OVERRIDE), linked=True)
    each(lambda m: shader_node.shader_of(m) is None, say("its shader node is gone: press Update in its panel, or call bpy.ops.lamina.regenerate()"))
    each(lambda m: state.is_stale(m) and not _only_animation_moved(m), say(_STALE))
    each(
        lambda m: not state.is_stale(m) and not state.is_settled(m),
        say("renders as a preview, as its final look is not computed; a save without a window computes it"),
    )
    return said


def _is_script_alone(material) -> bool:
    return shader_node.shader_of(material) is not None and roles.node_with(material, NODES) is None


def _standing(material) -> list[str]:
    """Animated values that stock nodes cannot follow, with their layer."""
    if roles.node_with(material, NODES) is None:
        return []
    followed, names = live_values.live_in_nodes(material, reading.stack_of(material)), []
    for place in live_values.live_values(material):
        element = material.lamina.base if place.layer is None else material.lamina.shown_layers[place.layer]
        if place not in followed and live_values.what_moves(element).get(place.name) == "animation":
            names.append(f"{element.name}: {elements.kind_of(element).parameter(place.name).label}")
    return names


def _only_animation_moved(material) -> bool:
    """Whether nothing but animation changed values since stock nodes were made: a save helps for one frame alone."""
    changed = set(record.changed_values(material))
    return bool(changed) and roles.node_with(material, NODES) is not None and changed <= set(_standing(material))


def _remedy(material, scene) -> str:
    """What lets the animation be followed."""
    available, reason = environment.osl_available()
    if not available:
        return f"{reason}: render it with CPU or OptiX in a Blender from blender.org"
    if roles.node_with(material, OSL) is None:
        return "Cycles with OSL does, in the backend Automatic"
    return f"Cycles with OSL does: {osl_setting.why_stock_nodes(scene, bpy.context.preferences)} in {scene.name}"


def _advice(material) -> str:
    if material.library is not None:
        return f"open {material.library.filepath} in this version of Lamina and save it"
    return "choose the backend Automatic" if material.lamina.backend == "osl" else "save the file"


class _Rounds:
    """Rounds through the materials of this file. Handlers cannot report, so what is done, or cannot be, is said on the console, and once."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def each(self, concerns: Callable[[bpy.types.Material], bool], act: Callable[[bpy.types.Material], None], linked: bool = False) -> None:
        """Act on each material that it concerns."""
        for material in bpy.data.materials:
            if not material.lamina.is_layered or not (linked or reading.is_own(material)):
                continue
            try:
                if concerns(material):
                    act(material)
            except LaminaError as error:
                self._say(f"Lamina: {material.name} keeps its old shader: {error}")

    def _say(self, sentence: str) -> None:
        if sentence not in self._said:
            self._said.add(sentence)
            print(sentence)


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    return [(bpy.app.handlers.save_pre, make_ready), (bpy.app.handlers.render_init, announce)]
