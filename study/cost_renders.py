# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of few parts, and what Cycles takes for each: what `calibrate_cost.py` fits to. Needs bpy."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..addon.nodes.backend import OSL
from ..addon.nodes.elements import find_node
from ..addon.nodes.material import apply_stack
from ..addon.pareto.materials import glossy_material, group_material, table_material
from ..addon.pareto.stage import Stage, ball, render_seconds, sun_stage, with_material
from ..reference_py.network import make_network
from ..reference_py.network.cost import PARTS, parts
from ..reference_py.network.table import KNOTS, DiffuseTable, GlossyTable, TableNetwork
from ..reference_py.optics.microfacet import GGX
from ..reference_py.stack import Stack

SIZE, SAMPLES = 128, 16
# (diffuse, mirrors, glossy lobes)
LOBES = (
    (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (0, 0, 2), (1, 1, 1), (1, 0, 2), (0, 0, 3), (0, 1, 2), (1, 0, 3),
    (1, 1, 2), (0, 0, 4), (1, 1, 3),
)  # fmt: skip
LAYERS = (1, 2, 3, 5)
BASES = {"lambert": {"kind": "lambert", "color": [0.5, 0.4, 0.3]}, "copper": {"kind": "conductor", "metal": "copper", "roughness": 0.5}}
_ONES = np.ones((KNOTS, 3))


@dataclass(frozen=True)
class Subject:
    """A material, its parts, and whether OSL runs while it is timed."""

    name: str
    material: bpy.types.Material
    parts: dict[str, int]
    osl: bool


def subjects() -> Iterator[Subject]:
    """Lobes in tables as OSL and as stock nodes; live tiers, their values constant or linked."""
    for diffuse, mirrors, glossy in LOBES:
        network = lobes_of(diffuse, mirrors, glossy)
        name = f"{diffuse} diffuse, {mirrors} mirror, {glossy} glossy"
        yield Subject(f"OSL: {name}", table_material(network, Stack.from_dict({"base": BASES["lambert"]}), f"cost_{diffuse}{mirrors}{glossy}"), parts(network), True)
        yield Subject(f"nodes: {name}", group_material(network), parts(network), False)
    for tier, lives in (("analytic", (False, True)), ("weidlich_wilkie", (False,))):
        for base in BASES:
            for layers in LAYERS:
                for live in lives:
                    stack = coated(layers, base)
                    name = f"{tier}: {layers} over {base}{', linked' if live else ''}"
                    yield Subject(name, _tier_material(name, stack, tier, live), parts(make_network(stack, tier).resolved, live), True)


def lobes_of(diffuse: int, mirrors: int, glossy: int) -> TableNetwork:
    """A network of that many lobes; what they share of the light does not matter, their widths hardly do."""
    tables = [DiffuseTable(0.2 * _ONES)] * diffuse + [GlossyTable(GGX, 0.2 * _ONES, 0.0 * _ONES)] * mirrors
    return TableNetwork((*tables, *(GlossyTable(GGX, 0.2 * _ONES, _ONES * (0.2 + 0.1 * i, 0.2 + 0.1 * i, 0.0)) for i in range(glossy))))


def coated(layers: int, base: str) -> Stack:
    """Rough tinted layers over a base."""
    kinds = [{"kind": "dielectric", "ior": 1.5 + 0.2 * (i % 2), "roughness": 0.3, "tint": [0.9, 0.8, 0.7]} for i in range(layers)]
    return Stack.from_dict({"layers": kinds, "base": BASES[base]})


def _tier_material(name: str, stack: Stack, tier: str, live: bool) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    apply_stack(material, stack, tier, OSL, _link_roughness if live else None)
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
    stood before each), its least and most of single rounds, and milliseconds before the first sample. Removes what it makes."""
    before = {kind: set(getattr(bpy.data, kind)) for kind in ("materials", "meshes", "objects", "texts", "node_groups")}
    try:
        with sun_stage(SIZE) as stage:
            return _rows(stage, list(subjects()), rounds, report)
    finally:
        for kind, present in before.items():
            bpy.data.batch_remove([block for block in getattr(bpy.data, kind) if block not in present])


def _rows(stage: Stage, all_subjects: list[Subject], rounds: int, report: Callable[[str], None]) -> list[tuple[str, ...]]:
    mesh = ball()
    glossy = with_material(mesh, glossy_material(np.full(3, 0.8), 0.3))
    items = [with_material(mesh, subject.material) for subject in all_subjects]

    def seconds(item: bpy.types.Object, osl: bool, whole: bool) -> float:
        stage.show([item])
        stage.settings(SAMPLES if whole else 1, size=None if whole else 8)
        stage.scene.cycles.shading_system = osl
        return render_seconds(stage.scene)

    starts = {osl: min(seconds(glossy, osl, False) for _ in range(4)) for osl in (True, False)}
    own_starts = np.min([[seconds(item, s.osl, False) for item, s in zip(items, all_subjects)] for _ in range(3)], axis=0)
    own, plain = np.zeros((2, rounds, len(items)))
    for turn in range(rounds):
        report(f"round {turn + 1} of {rounds}")
        for i, (item, subject) in enumerate(zip(items, all_subjects)):
            plain[turn, i] = seconds(glossy, subject.osl, True) - starts[subject.osl]
            own[turn, i] = seconds(item, subject.osl, True) - own_starts[i]
    single = own / plain
    least = np.min(own, axis=0) / np.min(plain, axis=0)
    return [
        (s.name, *(str(s.parts.get(part, 0)) for part in PARTS), f"{least[i]:.3f}", f"{single[:, i].min():.3f}", f"{single[:, i].max():.3f}",
         f"{1000.0 * (own_starts[i] - starts[s.osl]):.1f}")
        for i, s in enumerate(all_subjects)
    ]
