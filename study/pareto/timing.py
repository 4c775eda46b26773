# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material costs in Cycles: CPU time against a plain glossy node in the same run, memory, compilation."""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import bpy
import numpy as np

from ...addon.rendering.studio import build_ball_scene
from .bench import Stage, plane, render_seconds, with_material
from .methods import GLOSSY

Samples = dict[str, list[bpy.types.Object]]
_COPIES = 6


@dataclass(frozen=True)
class Cost:
    """CPU time over that of the plain glossy node: median, least and most of the rounds; `start` seconds before sampling."""

    ratio: float
    low: float
    high: float
    start: float


def interleaved(seconds: Callable[[str, bool], float], names: list[str], rounds: int, report: Callable[[str], None]) -> dict[str, Cost]:
    """Cost of each name by `seconds(name, whole)`, the CPU time of a whole render or of one that hardly samples.

    Every method is timed between two plain glossy renders of its round. What a render takes before it samples
    (syncing, compiling after a change of material) is taken off.
    """
    starts = [(seconds(GLOSSY, False), *(seconds(name, False) for name in names)) for _ in range(3)]
    start = dict(zip((GLOSSY, *names), map(min, zip(*starts))))
    ratios: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(rounds):
        report(f"time, round {turn + 1} of {rounds}")
        before = seconds(GLOSSY, True)
        for name in names:
            own, after = seconds(name, True) - start[name], seconds(GLOSSY, True)
            ratios[name].append(own / max(0.5 * (before + after) - start[GLOSSY], 1e-9))
            before = after
    return {name: Cost(median(r), min(r), max(r), start[name]) for name, r in ratios.items()} | {GLOSSY: Cost(1.0, 1.0, 1.0, start[GLOSSY])}


def filling_costs(stage: Stage, samples: Samples, rounds: int, spp: int, report) -> dict[str, Cost]:
    """Costs of samples that fill the frame, rendered with `spp` samples per pixel."""

    def seconds(name: str, whole: bool) -> float:
        stage.show(samples[name])
        return stage.seconds(spp) if whole else stage.seconds(1, 8)

    return interleaved(seconds, [n for n in samples if n != GLOSSY], rounds, report)


def scene_costs(materials: dict[str, bpy.types.Material], rounds: int, size: int, samples: int, report) -> dict[str, Cost]:
    """Costs of a whole demo scene, a ball on its stand before a backdrop, with the material on the ball."""
    studio = build_ball_scene(materials[GLOSSY], size, samples)
    render, cycles = studio.scene.render, studio.scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # or each render would build the scene's acceleration structure anew, which takes longer than to sample it
    render.use_persistent_data = True

    def seconds(name: str, whole: bool) -> float:
        studio.show(materials[name])
        render.resolution_x = render.resolution_y = size if whole else 8
        cycles.samples = samples if whole else 1
        return render_seconds(studio.scene)

    try:
        return interleaved(seconds, [n for n in materials if n != GLOSSY], rounds, report)
    finally:
        studio.remove()


def memory_per_material(stage: Stage, material: Callable[[str], bpy.types.Material], tag: str) -> float:
    """MB that one more material of this kind adds to Cycles' memory in a render, from 1 and 1 + _COPIES materials."""
    made = [material(f"{tag}_{i}") for i in range(1 + _COPIES)]
    items = []
    for i, one in enumerate(made):
        item = with_material(plane(), one)
        item.scale, item.location = (1e-4,) * 3, (0.2 * i - 0.6, 0.0, 1.0)
        items.append(item)
    peaks = []
    for sample in (items[:1], items, items[:1], items):
        stage.show(sample)
        peaks.append(_peak(stage))
    stage.clear()
    for item in items:
        bpy.data.meshes.remove(item.data)
    bpy.data.batch_remove(made)
    return (peaks[3] - peaks[2]) / _COPIES


def _peak(stage: Stage) -> float:
    """Largest resident memory in MB that Cycles' reports saw during a render."""
    peak = 0.0

    def look(*_) -> None:
        nonlocal peak
        peak = max(peak, _resident())

    bpy.app.handlers.render_stats.append(look)
    try:
        stage.seconds(2, 64)
    finally:
        bpy.app.handlers.render_stats.remove(look)
    return max(peak, _resident())


def _resident() -> float:
    """Resident memory of this process in MB; 0 where the system does not tell."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6 if statm.exists() else 0.0


def compiled(material: Callable[[str], bpy.types.Material], tag: str) -> tuple[bpy.types.Material, int, float]:
    """A new material, the bytes of its shader's text (0 for stock nodes) and the CPU time of making it."""
    start = time.process_time()
    made = material(tag)
    spent = time.process_time() - start
    texts = [n.script.as_string() for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeScript" and n.script]
    return made, sum(len(text.encode()) for text in texts), spent


def noise(stage: Stage, sample: list[bpy.types.Object], converged: np.ndarray, inside: np.ndarray, converged_spp: int, spp: int) -> float:
    """Variance at one sample per pixel (mean over pixels and channels) times the CPU time in seconds that it takes."""
    stage.show(sample)
    start = stage.seconds(1, 8)
    before = time.process_time()
    noisy = stage.picture(spp, seed=1)
    spent = time.process_time() - before - start
    variance = np.mean(np.square(noisy - converged)[inside]) / (1.0 / spp + 1.0 / converged_spp)
    return float(variance * spent / spp)
