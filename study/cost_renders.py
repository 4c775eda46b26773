# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of few parts, and what Cycles takes for each: what `calibrate_cost.py` fits to. Needs bpy."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..addon.blender.interrupt import interruptible
from ..addon.material.backend import OSL
from ..addon.material.elements import find_node
from ..addon.material.material import apply_stack
from ..reference_py.errors import LaminaError
from ..reference_py.lobes.methods import make_lobe_set
from ..reference_py.lobes.methods.cost import PARTS, parts
from ..reference_py.lobes.view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes
from ..reference_py.material.stack import Stack
from ..reference_py.optics.microfacet import GGX
from .pareto.bench import Stage, ball, sun_stage, with_material
from .pareto.compared_materials import glossy_material, group_material, table_material

SIZE, SAMPLES = 128, 16
# (diffuse, mirrors, glossy lobes)
LOBES = (
    (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (0, 0, 2), (1, 1, 1), (1, 0, 2), (0, 0, 3), (0, 1, 2), (1, 0, 3),
    (1, 1, 2), (0, 0, 4), (1, 1, 3),
)  # fmt: skip
# (method, whether roughnesses are linked, counts of layers)
LIVE_METHODS = (("analytic", False, (1, 2, 3)), ("analytic", True, (1, 3)), ("weidlich_wilkie", False, (1, 3)))
BASES = {"lambert": {"kind": "lambert", "color": [0.5, 0.4, 0.3]}, "copper": {"kind": "conductor", "metal": "copper", "roughness": 0.5}}
_ONES = np.ones((KNOTS, 3))


@dataclass(frozen=True)
class Sample:
    """A material, its parts, and whether OSL runs while it is timed."""

    name: str
    material: bpy.types.Material
    parts: dict[str, int]
    osl: bool


def samples() -> Iterator[Sample]:
    """Lobes in tables as OSL and as stock nodes; live methods, their values constant or linked."""
    for diffuse, mirrors, glossy in LOBES:
        lobe_set = lobes_of(diffuse, mirrors, glossy)
        name = f"{diffuse} diffuse, {mirrors} mirror, {glossy} glossy"
        yield Sample(
            f"OSL: {name}", table_material(lobe_set, Stack.from_dict({"base": BASES["lambert"]}), f"cost_{diffuse}{mirrors}{glossy}"), parts(lobe_set), True
        )
        yield Sample(f"nodes: {name}", group_material(lobe_set), parts(lobe_set), False)
    for method, live, counts in LIVE_METHODS:
        for base in BASES:
            for layers in counts:
                stack = coated(layers, base)
                name = f"{method}: {layers} over {base}{', linked' if live else ''}"
                yield Sample(name, _live_material(name, stack, method, live), parts(make_lobe_set(stack, method).lobe_set, live), True)


def lobes_of(diffuse: int, mirrors: int, glossy: int) -> TableLobes:
    """A lobe set of that many lobes; what they share of the light does not matter, their widths hardly do."""
    tables = [DiffuseTable(0.2 * _ONES)] * diffuse + [GlossyTable(GGX, 0.2 * _ONES, 0.0 * _ONES)] * mirrors
    return TableLobes((*tables, *(GlossyTable(GGX, 0.2 * _ONES, _ONES * (0.2 + 0.1 * i, 0.2 + 0.1 * i, 0.0)) for i in range(glossy))))


def coated(layers: int, base: str) -> Stack:
    """Rough tinted layers over a base."""
    kinds = [{"kind": "dielectric", "ior": 1.5 + 0.2 * (i % 2), "roughness": 0.3, "tint": [0.9, 0.8, 0.7]} for i in range(layers)]
    return Stack.from_dict({"layers": kinds, "base": BASES[base]})


def _live_material(name: str, stack: Stack, method: str, live: bool) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    apply_stack(material, stack, method, OSL, _link_roughness if live else None)
    return material


def _link_roughness(material: bpy.types.Material) -> None:
    """Give all layers a roughness that is no constant to OSL: .3 in front, more behind."""
    tree = material.node_tree
    side, value = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMath")
    value.operation, value.inputs[1].default_value = "ADD", 0.3
    tree.links.new(side.outputs["Backfacing"], value.inputs[0])
    for layer in material.lamina.layers:
        tree.links.new(value.outputs[0], find_node(layer).inputs["Roughness"])


def measured(rounds: int, report: Callable[[str], None]) -> list[tuple[str, ...]]:
    """Rows of the table: material, counts of PARTS, cost (least CPU time of the rounds over the least of the plain glossy node's that
    stood before each), its least and most of single rounds, and least milliseconds before the first sample. Removes what it makes."""
    before = {kind: set(getattr(bpy.data, kind)) for kind in ("materials", "meshes", "objects", "texts", "node_groups")}
    try:
        with sun_stage(SIZE) as stage:
            return _rows(stage, list(samples()), rounds, report)
    finally:
        for kind, present in before.items():
            bpy.data.batch_remove([block for block in getattr(bpy.data, kind) if block not in present])


def _rows(stage: Stage, all_samples: list[Sample], rounds: int, report: Callable[[str], None]) -> list[tuple[str, ...]]:
    mesh = ball()
    glossy = with_material(mesh, glossy_material(np.full(3, 0.8), 0.3))
    items = [with_material(mesh, sample.material) for sample in all_samples]
    # (start, sampling) of the glossy node before each, and of each
    plain, own = np.zeros((2, rounds, len(items), 2))
    for turn in range(rounds):
        for i, (item, sample) in enumerate(zip(items, all_samples)):
            report(f"round {turn + 1} of {rounds}: {sample.name}")
            plain[turn, i], own[turn, i] = _seconds(stage, glossy, sample.osl), _seconds(stage, item, sample.osl)
    single = own[..., 1] / plain[..., 1]
    least, start = np.min(own, axis=0)[:, 1] / np.min(plain, axis=0)[:, 1], 1000.0 * (np.min(own, axis=0) - np.min(plain, axis=0))[:, 0]
    return [
        (s.name, *(str(s.parts.get(part, 0)) for part in PARTS), *(f"{v:.3f}" for v in (least[i], single[:, i].min(), single[:, i].max())), f"{start[i]:.0f}")
        for i, s in enumerate(all_samples)
    ]


def _seconds(stage: Stage, item: bpy.types.Object, osl: bool) -> tuple[float, float]:
    """CPU time of a render before its first sample, and of its samples."""
    stage.show([item])
    stage.settings(SAMPLES)
    stage.scene.cycles.shading_system = osl
    at: dict[str, float] = {}

    def listen(*arguments) -> None:
        text = next((a for a in arguments if isinstance(a, str)), "")
        if "Sample " in text:
            at[text[text.rindex("Sample ") :].split()[1]] = time.process_time()

    begin = time.process_time()
    bpy.app.handlers.render_stats.append(listen)
    try:
        with interruptible():
            bpy.ops.render.render(scene=stage.scene.name)
    finally:
        bpy.app.handlers.render_stats.remove(listen)
    first, last = f"0/{SAMPLES}", f"{SAMPLES}/{SAMPLES}"
    if first not in at or last not in at:
        raise LaminaError(f"Blender {bpy.app.version_string} does not tell when it samples: cannot time {item.active_material.name}")
    return at[first] - begin, at[last] - at[first]
