# SPDX-License-Identifier: GPL-3.0-or-later
"""All columns of the chart for one surface: errors, costs, noise against the slab, memory, size."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ...reference_py.material.stack import Stack
from ...reference_py.models.adding.adding_model import Adding
from ...reference_py.optics.optical_stack import rough_surfaces
from .ball_picture import Surroundings, ball_picture, difference
from .bench import ball, furnace_stage, plane, studio_stage, sun_stage, with_material
from .explicit_slab import slab_objects
from .methods import GLOSSY, SLAB, Method, methods
from .quality import Quality
from .reflectance import Errors, Reference, TruthReflectance
from .slab_truth import slab_errors
from .timing import Cost, compiled, filling_costs, memory_per_material, noise, scene_costs


@dataclass(frozen=True)
class Result:
    """One way to render one surface. None where there is nothing to measure.

    `delta_e` mean CIEDE2000 between the truth's picture of a ball in a studio and numpy's of the method, which has no noise;
    `delta_e_render` that of the method's render, with its noise; `scene` cost in a whole demo scene; `over_slab` how many times less
    CPU time than the slab's an equally noisy picture takes; `compile_seconds` making the shader and its start in Cycles.
    """

    method: Method
    errors: Errors
    delta_e: float
    delta_e_render: float
    cost: Cost
    scene: Cost | None
    over_slab: float | None
    memory_mb: float | None
    shader_bytes: int | None
    compile_seconds: float | None
    picture: np.ndarray


def measure(name: str, stack: Stack, quality: Quality, report: Callable[[str], None]) -> tuple[list[Result], np.ndarray]:
    """A result for each method, and the truth's picture, radiance (size, size, 3). Removes what it makes."""
    before = {kind: set(getattr(bpy.data, kind)) for kind in ("materials", "meshes", "objects", "texts", "node_groups")}
    try:
        return _measure(name, stack, quality, report)
    finally:
        for kind, present in before.items():
            bpy.data.batch_remove([block for block in getattr(bpy.data, kind) if block not in present])


def _measure(name, stack, quality, report):
    truth = Adding(stack)
    ways = {method.name: method for method in methods(stack, truth, report)}
    made = {way: compiled(m.material, f"{name}_{way}") for way, m in ways.items() if m.material}
    surface = ball()
    samples = {way: [with_material(surface, material)] for way, (material, _, _) in made.items()}
    if SLAB in ways:
        samples[SLAB] = slab_objects(stack, ball)
    with sun_stage(quality.time_size) as stage:
        costs = filling_costs(stage, samples, quality.rounds, quality.time_samples, report)
        report("memory")
        memory = {w: memory_per_material(stage, ways[w].material, f"{name}_{w}_copy") for w in made if w != GLOSSY} if quality.memory else {}
    report("demo scene")
    scenes = scene_costs({way: material for way, (material, _, _) in made.items()}, quality.rounds, quality.scene_size, quality.scene_samples, report)
    report("pictures")
    surroundings, widths = Surroundings(), widths_of(stack)
    exact = ball_picture(TruthReflectance(truth), widths, quality.picture_size, surroundings)
    pictures, spent = _pictures(samples, exact, surroundings, quality)
    reference = Reference(stack, truth)
    results = []
    for way, method in ways.items():
        if method.reflectance:
            errors = reference.errors(method.reflectance)
            picture = ball_picture(method.reflectance, widths, quality.picture_size, surroundings)
        else:
            report("where the slab's paths go")
            with furnace_stage(256) as stage:
                errors = slab_errors(stage, slab_objects(stack, plane), stack, truth, quality.slab_renders)
            picture = pictures[way]
        _, size, seconds = made.get(way, (None, None, None))
        results.append(Result(
            method, errors, difference(picture, exact, surroundings), difference(pictures[way], exact, surroundings), costs[way], scenes.get(way),
            spent[SLAB] / spent[way] if SLAB in spent and way != SLAB else None,
            memory.get(way), size, None if seconds is None else seconds + costs[way].start - costs[GLOSSY].start, pictures[way],
        ))  # fmt: skip
    return results, exact


def _pictures(samples, exact, surroundings, quality):
    """Renders of all samples, and their variance times CPU time over the pixels that `exact` has."""
    inside = np.isfinite(exact[..., 0])
    pictures, spent = {}, {}
    with studio_stage(quality.picture_size, surroundings) as stage:
        for way, sample in samples.items():
            spp = quality.slab_samples if way == SLAB else quality.picture_samples
            stage.show(sample)
            pictures[way] = stage.picture(spp)
            spent[way] = noise(stage, sample, pictures[way], inside, spp, quality.noise_samples)
    return pictures, spent


def widths_of(stack: Stack) -> list[float]:
    """Alphas to spread directions by: the surfaces' own and what they blur to together."""
    alphas = sorted({alpha for _, alpha in rough_surfaces(stack)})
    return alphas + ([min(1.0, float(np.sqrt(np.sum(np.square(alphas)))))] if len(alphas) > 1 else [])
