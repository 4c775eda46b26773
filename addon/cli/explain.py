# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina explain`: what the tier auto tries for a stack and chooses, judged over a ball or over what a camera sees."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.baked import MAX_GLOSSY, is_brushed
from ...reference_py.lobes.bare_base import is_bare_brushed
from ...reference_py.lobes.brushing import has_brushing, without_idle
from ...reference_py.lobes.error_estimate import SOFT_LIGHT_DEG
from ...reference_py.lobes.made import DEFAULT_TOLERANCE, Options
from ...reference_py.lobes.methods import MAX_CLOSURES, glossy_of_each, require_bake_follows
from ...reference_py.lobes.methods.auto import COMPUTED, Choice, choose, choose_brushed, with_anisotropy
from ...reference_py.lobes.methods.not_bakeable import bakeable, not_bakeable
from ...reference_py.lobes.truth import truth_of
from ...reference_py.material.coverage import Patch, patches
from ...reference_py.material.stack import Stack
from ..material.backend import OSL
from ..material.limits import require_shader
from ..session import blender, say, tenths
from .print_values import load_stack


def explain(options) -> None:
    """Print every candidate's closures, cost and errors, and which is chosen, and why."""
    stack = load_stack(options.stack)
    require_shader(stack, OSL)
    report = say(options.command)
    if bool(options.blend) != bool(options.object):
        raise LaminaError("--blend FILE and --object NAME go together")
    sight = None
    if options.blend:
        with blender(report):
            sight = _sight(options.blend, options.object)
    tolerance = DEFAULT_TOLERANCE if options.tolerance is None else 0.01 * options.tolerance
    parts = patches(stack)
    for patch in parts:
        require_bake_follows(without_idle(patch.stack)[0])
    glossy = min(MAX_GLOSSY, glossy_of_each(len(parts)))
    bakes_all = len(parts) >= MAX_CLOSURES
    choices = [(patch, _choice(without_idle(patch.stack)[0], tolerance, glossy, sight, tenths(report))) for patch in parts]
    if options.json:
        rows = [{**_where_json(patch), **_json(choice)} for patch, choice in choices]
        seen = None if sight is None else {"theta_deg": np.degrees(np.arccos(sight.cosines)).tolist(), "pixels": sight.pixels}
        print(json.dumps({**(rows[0] if len(rows) == 1 else {"patches": rows, "all_baked": bakes_all}), "sight": seen}))
        return
    if sight is not None:
        low, high = np.degrees(np.arccos([sight.cosines.max(), sight.cosines.min()]))
        print(f"{options.object} shows views of {low:.0f} to {high:.0f} degrees on {sight.pixels:.0f} pixels")
    for patch, choice in choices:
        _print(patch, choice)
    if bakes_all:
        print(f"all {len(parts)} patches are baked, whatever is chosen for each, as only lobes of bakes share closures")
    print(
        "cost: CPU time over a plain glossy node, estimated. albedo: worst view. soft light and shape (L1 of f): mean over the pixels. The larger of albedo and soft light counts."
    )


def _choice(stack: Stack, tolerance: float, glossy: int, sight, progress) -> Choice:
    """What auto chooses for one patch; anisotropy that no bake holds leaves the live tiers, judged with it."""
    if is_brushed(stack):
        options = Options((), tolerance, glossy, progress)
        choice = COMPUTED.result(stack, options) if sight is None else choose_brushed(stack, options, sight.cosines, sight.light_deg(SOFT_LIGHT_DEG))
        if not is_bare_brushed(stack):
            return choice
    else:
        choice = _choice_of_plain(bakeable(stack), Options(not_bakeable(stack), tolerance, glossy, progress), sight)
    return with_anisotropy(choice, stack, tolerance, None if sight is None else sight.cosines) if has_brushing(stack) else choice


def _choice_of_plain(plain: Stack, options: Options, sight) -> Choice:
    if sight is None:
        return COMPUTED.result(plain, options)
    return choose(plain, truth_of(plain), options, sight.cosines, sight.light_deg(SOFT_LIGHT_DEG))


def _sight(file: str, name: str):
    import bpy

    from ..rendering.sight import sight_of

    if not Path(file).is_file():
        raise LaminaError(f"{file}: there is no such .blend file")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(Path(file).resolve()), load_ui=False)
    except RuntimeError as error:
        raise LaminaError(f"{file}: Blender cannot open it: {str(error).strip()}") from None
    target = bpy.data.objects.get(name)
    if target is None:
        choices = sorted(o.name for o in bpy.data.objects if o.type == "MESH")
        raise LaminaError(f"{file}: no object {name!r}; choose {', '.join(choices) or 'none'}")
    return sight_of(target, bpy.context.scene)


def _where_json(patch: Patch) -> dict:
    return {"layers": list(patch.layers), "base": patch.base} if patch.covered else {}


def _json(choice: Choice) -> dict:
    return {"chosen": choice.chosen.label, "stock": choice.stock.label, "reason": choice.reason, "tried": [asdict(candidate) for candidate in choice.tried]}


def _print(patch: Patch, choice: Choice) -> None:
    if patch.covered:
        print("where " + " and ".join(f"layer {i} is {'there' if there else 'not there'}" for i, there in patch.covered) + ":")
    print(f"{'tried':18} {'closures':>8} {'cost':>6} {'albedo':>9} {'soft light':>11} {'shape':>8}")
    for c in choice.tried:
        print(f"{c.label:18} {c.closures:8d} {c.cost:5.2f}x {100 * c.albedo:7.2f} % {100 * c.soft_light:9.2f} % {100 * c.shape:6.2f} %")
    print(f"chosen: {choice.chosen.label}, {choice.reason}")
