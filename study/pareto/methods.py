# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways to render a layered material that are compared."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import bpy

from ...addon.blender.versions import DIFFUSE_POWER, HAS_DIELECTRIC
from ...addon.material.backend import OSL
from ...addon.material.material import apply_stack
from ...reference_py.lobes.baked import MAX_GLOSSY, Baker
from ...reference_py.lobes.methods import make_lobe_set
from ...reference_py.lobes.tabulate import tabulate
from ...reference_py.lobes.view_table import TableLobes
from ...reference_py.material.stack import Stack
from ...reference_py.registry import make_model
from .compared_materials import glossy_material, group_material, layer_text, principled_material, script_material, table_material
from .reflectance import LobeReflectance, ModelReflectance, Reflectance, belcour_lobes, glossy_lobes, plain_glossy

GLOSSY, SLAB, NODES = "glossy", "slab", "nodes"
_LABELS = {"weidlich_wilkie": "Weidlich-Wilkie", "analytic": "analytic"}
# Glossy lobes of the bake that stock nodes show.
_NODES_GLOSSY = 2


@dataclass(frozen=True)
class Method:
    """`material(tag)` makes a new material, its shader named after `tag`; of the slab, which has none, the rest is None."""

    name: str
    label: str
    reflectance: Reflectance | None
    material: Callable[[str], bpy.types.Material] | None
    closures: int | None = None
    bake_seconds: float | None = None


def methods(stack: Stack, truth, report: Callable[[str], None]) -> list[Method]:
    """All methods for a stack, the plain glossy node first. `bake_seconds` is CPU time with the truth's."""
    color, alpha = plain_glossy(stack, truth)
    principled, layer, belcour = (make_model(name, stack) for name in ("principled_coat", "cycles_layer", "belcour"))
    result = [
        Method(GLOSSY, "plain glossy", LobeReflectance(glossy_lobes(color, alpha)), lambda tag: glossy_material(color, alpha), 1),
        Method("principled", "Principled", ModelReflectance(principled), lambda tag: principled_material(principled)),
        Method("layer", "OSL layer()", ModelReflectance(layer), lambda tag: script_material(tag, layer_text(stack, tag))),
        _tables(stack, "belcour", "Belcour 2018", belcour_lobes(belcour)),
    ]
    for method in _LABELS:
        lobe_set = make_lobe_set(stack, method)
        result.append(Method(method, _LABELS[method], LobeReflectance(lobe_set), _live(stack, method), lobe_set.lobe_count))
    start = time.process_time()
    baker = Baker(stack, truth)
    for glossy in range(1, MAX_GLOSSY + 1):
        report(f"bake {glossy} glossy")
        lobe_set = baker.bake(glossy).lobe_set
        spent = time.process_time() - start
        if glossy == _NODES_GLOSSY:
            result.append(_nodes(lobe_set, spent))
        result.append(_tables(stack, f"baked_{glossy}", f"baked, {glossy}", lobe_set, spent))
    if stack.layers:
        result.append(Method(SLAB, "slab geometry", None, None))
    return result


def _tables(stack: Stack, name: str, label: str, lobe_set: TableLobes, spent: float | None = None) -> Method:
    def material(tag: str) -> bpy.types.Material:
        return table_material(lobe_set, stack, tag)

    return Method(name, label, LobeReflectance(lobe_set), material, lobe_set.lobe_count, spent)


def _nodes(lobe_set: TableLobes, spent: float) -> Method:
    stock = tabulate(lobe_set, HAS_DIELECTRIC, DIFFUSE_POWER)
    return Method(NODES, f"stock nodes, {_NODES_GLOSSY}", LobeReflectance(stock), lambda tag: group_material(stock), stock.lobe_count, spent)


def _live(stack: Stack, method: str) -> Callable[[str], bpy.types.Material]:
    def material(tag: str) -> bpy.types.Material:
        made = bpy.data.materials.new(tag)
        apply_stack(made, stack, method, OSL)
        return made

    return material
