# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that run beside Blender's window, one at a time, and shaders that follow values which they hold.

A timer looks at the materials after something changed: a shader of old values is replaced at once by one that reads
them (tier analytic), the means of their textures are measured once they rest, and what the next click on the active one may need is compiled, and when the values have rested for one tick, a process starts to compute the lobe set that the
material's tier stands for. Without a window nothing of this runs: `material.refresh(settle=True)` waits instead.
"""

from dataclasses import dataclass, field

import bpy
from bpy.app.handlers import persistent

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.lobes.cache import stack_key
from ...reference_py.material.schema import SCHEMA_VERSION
from ..material import first_click, osl_setting, pasted, reading, record, shader_node, state
from ..material import material as materials
from ..material.marks import concern_us
from . import conversions
from .process import Process, worker

TICK = 0.4


class Bake(Process):
    """One lobe set in the making, in a process of its own."""

    def __init__(self, wanted: "state.Wanted"):
        from ...reference_py.lobes.methods import bake_process  # that package is imported with the first bake

        super().__init__(Sentence("a bake"), worker(bake_process.MODULE), [wanted.request()])
        self.wanted, self.key = wanted, wanted.key


@dataclass
class _State:
    bake: Bake | None = None
    debounced: dict[str, str] = field(default_factory=dict)
    failed: dict[str, tuple[str, Sentence]] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)  # why values of materials could not be followed
    touched: set[str] = field(default_factory=set)  # materials that changed since the last tick
    unmeasured: set[str] = field(default_factory=set)  # and before that


_state = _State()


def bake_of(material: bpy.types.Material) -> Bake | None:
    """The bake that runs for this material's present values."""
    return _state.bake if _state.bake is not None and _state.debounced.get(material.name_full) == _state.bake.key else None


def failed(material: bpy.types.Material) -> Sentence | None:
    """Why there is no bake of a material's values, if it failed or was cancelled; None otherwise."""
    key, reason = _state.failed.get(material.name_full, (None, None))
    return reason if key is not None and key == _state.debounced.get(material.name_full) else None


def cancel(material: bpy.types.Material) -> None:
    """Stop the material's bake; its shader stays that of the tier analytic until a value changes."""
    bake = bake_of(material)
    if bake is None:
        return
    bake.cancel()
    _state.bake = None
    _state.failed[material.name_full] = bake.key, Sentence("cancelled")


def retry(material: bpy.types.Material) -> None:
    """Bake again after a cancel or a failure; without a window, wait for it. Raises LaminaError for a material of another file."""
    reading.require_editable(material)
    _state.failed.pop(material.name_full, None)
    if bpy.app.background:
        materials.refresh(material, settle=True)
    wake()


def tick() -> float | None:
    """One look at all materials. Returns the seconds to the next, or None when there is nothing left to do."""
    if bpy.app.is_job_running("RENDER"):
        return TICK  # nodes must not change under a render
    _collect()
    left = conversions.collect()
    resting, _state.unmeasured, _state.touched = _state.unmeasured - _state.touched, _state.touched, set()
    left |= bool(_state.unmeasured)
    for material in bpy.data.materials:
        pasted.adopt_pasted(material)
        if reading.is_own(material) and material.lamina.is_layered:
            try:
                if material.name_full in resting:
                    reading.measure_means(material)
                    if material == getattr(bpy.context.view_layer.objects.active, "active_material", None):
                        first_click.compile_next(material)
                has_more = _follow(material)
                left |= has_more | conversions.follow(material)
                if not has_more and _state.refused.pop(material.name_full, None) == material.lamina.problem:
                    material.lamina.keep_problem(None)
            except LaminaError as error:
                _fail(material, error)
    _redraw()
    return TICK if left or _state.bake is not None else None


def _follow(material: bpy.types.Material) -> bool:
    """Bring one material nearer to what its tier stands for; whether there is more to do."""
    if state.is_stale(material):
        materials.refresh(material)
    if state.is_settled(material):
        is_older = state.lacks_branch(material) and material.lamina.schema_version < SCHEMA_VERSION
        if is_older or not state.lags(material):  # opening a file changes nothing: an older one gets both branches at an edit or a save
            _state.debounced.pop(material.name_full, None)
            if not is_older:
                record.keep_record(material)
            return False
        wanted = state.wanted_stock(material)
        if wanted is None:
            return _follow_with_stock(material)
    else:
        wanted = state.wanted_lobes(material)
    is_debounced = _state.debounced.get(material.name_full) == wanted.key
    _state.debounced[material.name_full] = wanted.key
    if wanted.is_cached():
        materials.refresh(material)
        return False
    if failed(material):
        return False
    if is_debounced and _state.bake is None:
        _state.bake = Bake(wanted)
    return True


def _follow_with_stock(material: bpy.types.Material) -> bool:
    """Let the stock nodes beside a script that reads its values follow: when these rest, or at once where no script shows."""
    key = stack_key(reading.stack_of(material))
    is_debounced = _state.debounced.get(material.name_full) == key
    if is_debounced or state.lacks_branch(material) or not any(osl_setting.shows_osl(w.scene) for w in bpy.context.window_manager.windows):
        _state.debounced.pop(material.name_full, None)
        (materials.refresh if state.lacks_branch(material) else materials.refresh_stock)(material)
        return False
    _state.debounced[material.name_full] = key
    return True


def _collect() -> None:
    bake = _state.bake
    if bake is None:
        return
    if bake.key not in _state.debounced.values():
        bake.cancel()  # nobody wants it any more
    if not bake.is_done:
        return
    _state.bake = None
    if bake.result is not None:
        bake.wanted.put(bake.result)
        return
    for name, key in _state.debounced.items():
        if key == bake.key:
            _state.failed[name] = key, bake.error
            print(f"Lamina: {name}: computing the final look failed: {bake.error}; it stays a preview")


def _fail(material, error: LaminaError) -> None:
    _state.refused[material.name_full] = str(error)
    if material.lamina.problem != str(error):
        material.lamina.keep_problem(error)
        print(f"Lamina: {material.name}: {error}")


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def wake() -> None:
    """Let the timer look at the materials soon."""
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=TICK, persistent=True)


@persistent
def wake_after_change(_scene, depsgraph) -> None:
    if not concern_us():
        return
    if bpy.app.background:
        for material in bpy.data.materials:  # of one on no object Blender tells no change
            pasted.adopt_pasted(material)
    elif depsgraph.id_type_updated("MATERIAL") or depsgraph.id_type_updated("NODETREE"):
        _state.touched |= {update.id.original.name_full for update in depsgraph.updates if isinstance(update.id, bpy.types.Material)}
        wake()


@persistent
def wake_after_load(*_) -> None:
    if concern_us():
        wake()


@persistent
def mend_after_undo(*_) -> None:
    """Undo brings a removed node group back, but not always into its node (seen in 4.5.15 and 5.3.0): that branch is made anew."""
    if not concern_us():
        return
    for material in bpy.data.materials:
        if reading.is_own(material) and material.lamina.is_layered and shader_node.lost_group(material):
            try:
                materials.refresh(material)
            except LaminaError as error:
                _fail(material, error)
    wake()


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    lists = bpy.app.handlers
    return [(lists.depsgraph_update_post, wake_after_change), (lists.load_post, wake_after_load), (lists.undo_post, mend_after_undo)]


def stop() -> None:
    """End the timer and what is baking."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    conversions.stop()
    if _state.bake is not None:
        _state.bake.cancel()
        _state.bake = None
