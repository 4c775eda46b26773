# SPDX-License-Identifier: GPL-3.0-or-later
"""Measurements that become stacks: the fit runs beside Blender's window, in a process, and is applied when it is done."""

from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.fit import fit_process, forward, metric
from ...reference_py.material.stack import Stack
from ..blender.translation import data_, rpt_
from ..material import chosen, replaced
from ..material import material as materials
from .process import Process, worker

TICK = 0.5


class Fit(Process):
    """One fit in the making, for a material or for an object that has none."""

    def __init__(self, target: bpy.types.ID, file: str, layers: int | str, base: str, cloudy: bool):
        super().__init__(Sentence("a fit"), worker(fit_process.MODULE), [fit_process.request(file, layers, base, forward.DEFAULT_MODEL, cloudy)])
        self.target, self.file = target.session_uid, file
        self.is_object = isinstance(target, bpy.types.Object)

    def apply(self, scene: bpy.types.Scene) -> list[str]:
        """Give the target the fitted stack; what to tell the user. Raises LaminaError where there is none."""
        if self.error:
            raise LaminaError(self.error)
        owner = _with_uid(bpy.data.objects if self.is_object else bpy.data.materials, self.target)
        if owner is None:
            if self.is_object:
                raise LaminaError("{file} is fitted, but the object that it was for is gone", file=Path(self.file).name)
            raise LaminaError("{file} is fitted, but the material that it was for is gone", file=Path(self.file).name)
        told = {name: [Sentence.unpacked(sentence).told(rpt_) for sentence in self.result[name]] for name in fit_process.SENTENCES}
        result = self.result | told
        stack = Stack.from_dict(self.result["stack"], Path(self.file).name)
        material = bpy.data.materials.new(Path(self.file).stem) if self.is_object else owner
        lost = replaced.lost_with_layers(material)
        try:
            materials.apply_stack(material, stack, *chosen.for_new(material))
        except LaminaError:
            if self.is_object:
                bpy.data.materials.remove(material)
            raise
        if self.is_object:
            owner.active_material = material
        summary = _summary(self.file, result, _noted(self.file, result))
        return [f"{summary}; {lost.told(rpt_)}" if lost else summary, *materials.make_renderable(material, scene)]


def _with_uid(collection, uid: int) -> bpy.types.ID | None:
    return next((item for item in collection if item.session_uid == uid), None)


def _noted(file: str, result: dict) -> str:
    """The name of a text in which all is said of the fit."""
    text = bpy.data.texts.new(data_("Fit of {file}").format(file=Path(file).name))
    text.write("\n".join([file, *result["found"], *result["warnings"], "", *result["lines"]]) + "\n")
    return text.name


def _summary(file: str, result: dict, noted: str) -> str:
    stack, error = Stack.from_dict(result["stack"]).name, metric.percent(result["error"]).told(rpt_)
    parts = [rpt_("fitted to {file}: {stack}, error {error}").format(file=Path(file).name, stack=stack, error=error)]
    if not result["explains"]:
        parts.append(rpt_("no stack that was tried explains it"))
    parts += result["warnings"]
    if unknown := result["not_determined"]:
        parts.append(rpt_("the data do not determine {count} of {all} values").format(count=len(unknown), all=len(result["parameters"])))
    return "; ".join([*parts, rpt_("more in the text {name}").format(name=noted)])


# The fit that runs, and by target what the last one said.
_running: Fit | None = None
_last: dict[int, str] = {}


def running() -> Fit | None:
    """The fit that runs."""
    return _running


def last_summary(owner: bpy.types.ID | None) -> str:
    """What the last fit for a material or an object said; empty if there was none."""
    return _last.get(owner.session_uid, "") if owner is not None else ""


def start(target: bpy.types.ID, file: str, layers: int | str, base: str, cloudy: bool = False) -> Fit:
    """Begin a fit; `cloudy` tries a medium that scatters above the base too. Raises LaminaError when one runs already, or it cannot start."""
    global _running
    if _running is not None:
        raise LaminaError("{file} is being fitted; wait for it, or cancel it", file=Path(_running.file).name)
    _last.pop(target.session_uid, None)
    _running = Fit(target, file, layers, base, cloudy)
    return _running


def cancel() -> None:
    """Stop the fit that runs; the material stays as it is."""
    global _running
    if _running is not None:
        _running.cancel()
        _running = None


def tick() -> float | None:
    """Look after the fit; apply it when it is done. Returns the seconds to the next look."""
    global _running
    if _running is None:
        return None
    if not _running.is_done or bpy.app.is_job_running("RENDER"):
        _redraw()
        return TICK
    fit, _running = _running, None
    try:
        sentences = fit.apply(bpy.context.scene)
        bpy.ops.ed.undo_push(message="Fit Measurement")
    except LaminaError as error:
        sentences = [rpt_("fit failed: {reason}").format(reason=error.told(rpt_))]
    # the panel has notes of its own on how the material is made
    _last[fit.target] = sentences[0]
    for sentence in sentences:
        print(f"Lamina: {sentence}")
    _redraw()
    return None


def finish(scene: bpy.types.Scene) -> list[str]:
    """Wait for the fit that runs and apply it; what to tell the user. Raises LaminaError where there is none."""
    global _running
    fit, _running = _running, None
    fit.wait()
    return fit.apply(scene)


def stop() -> None:
    """End the timer and the fit."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    cancel()


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
