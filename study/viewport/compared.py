# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport's chart compares: every preset in both backends, Blender's own shaders as a reference, and the light."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import bpy

from ...addon.material.backend import NODES, OSL
from ...addon.material.material import apply_stack, refresh
from ...addon.rendering.settings import add_object
from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ..pareto.ball_picture import Surroundings
from ..pareto.bench import Stage, studio_stage
from ..pareto.compared_materials import node_material
from ..pareto.surface_types import load_surface

_LAMP_WATTS, _LAMP_SIZE, _LAMP_PLACE = 60.0, 1.5, (2.2, 1.6, 2.6)
# The references: what Blender's own nodes show tells how far EEVEE and Cycles agree at all.
_PLAIN = {
    "Diffuse": ("ShaderNodeBsdfDiffuse", {"Color": (0.5, 0.3, 0.2, 1.0)}),
    "Glossy": ("ShaderNodeBsdfAnisotropic", {"Color": (0.9, 0.7, 0.4, 1.0), "Roughness": 0.4}),
    "Principled": ("ShaderNodeBsdfPrincipled", {"Base Color": (0.5, 0.3, 0.2, 1.0), "Roughness": 0.5}),
    "Principled with a coat": ("ShaderNodeBsdfPrincipled", {
        "Base Color": (0.5, 0.1, 0.05, 1.0), "Metallic": 1.0, "Roughness": 0.4, "Coat Weight": 1.0, "Coat Roughness": 0.05}),
}  # fmt: skip


class Sample(NamedTuple):
    """One material as stock nodes and as an OSL shader; of a reference both are the same, and `closures` is None."""

    label: str
    nodes: bpy.types.Material
    osl: bpy.types.Material
    closures: int | None


def samples(names: Sequence[str], report: Callable[[str], None]) -> list[Sample]:
    """The references, and presets or stacks of the suite, baked as the tier auto chooses."""
    made = [Sample(label, material, material, None) for label, material in ((n, _plain(*row)) for n, row in _PLAIN.items())]
    for name in names:
        report(f"bake {name}")
        nodes, osl = (_lamina(load_surface(name), backend) for backend in (NODES, OSL))
        made.append(Sample(presets.label(name) if name in presets.names() else name, nodes, osl, nodes.lamina.lobe_count))
    return made


def _plain(kind: str, values: dict) -> bpy.types.Material:
    material, node, _ = node_material(kind)
    for name, value in values.items():
        node.inputs[name].default_value = value
    return material


def _lamina(stack: Stack, backend: str) -> bpy.types.Material:
    material = bpy.data.materials.new(f"{stack.name} {backend}")
    apply_stack(material, stack, backend=backend)
    refresh(material, settle=True)
    return material


@contextmanager
def lit_stage(size: int, surroundings: Surroundings, item: bpy.types.Object) -> Iterator[Stage]:
    """An object in a picture of a studio all around, as in the material preview, and by a square lamp."""
    with studio_stage(size, surroundings) as stage:
        light = bpy.data.lights.new("Lamp", "AREA")
        light.energy, light.size = _LAMP_WATTS, _LAMP_SIZE
        lamp = add_object(stage.scene, "Lamp", light)
        lamp.location = _LAMP_PLACE
        lamp.rotation_euler = lamp.location.to_track_quat("Z", "Y").to_euler()
        stage.settings(1)
        stage.show([item])
        yield stage
