# SPDX-License-Identifier: GPL-3.0-or-later
"""Two copper vases, one clean, one with patina by a mask: figure 8c of Weidlich and Wilkie 2007."""

import bpy

from ..addon.material.elements import node_of
from ..addon.material.material import refresh
from ..reference_py.material import presets
from ..reference_py.material.schema import COVERAGE
from ..reference_py.material.stack import Stack
from .materials import preset_material, stack_material
from .set import put, stage
from .shapes import turned

# radius and height, from the inside's bottom over the lip to the foot
PROFILE = [
    (0.0, 0.2),
    (0.3, 0.22),
    (0.5, 0.75),
    (0.42, 1.2),
    (0.17, 1.62),
    (0.2, 1.9),
    (0.35, 2.1),
    (0.38, 2.1),
    (0.24, 1.92),
    (0.21, 1.62),
    (0.46, 1.22),
    (0.56, 0.76),
    (0.36, 0.22),
    (0.24, 0.12),
    (0.34, 0.05),
    (0.34, 0.0),
    (0.0, 0.0),
]


def build(settle: bool = True) -> bpy.types.Scene:
    """The patina is a layer whose coverage a texture gives: 0 is bare copper."""
    scene = stage("Copper Vases", (0.0, -9.4, 2.8), (0.0, 0.1, 1.06), 80.0, paper=(0.12, 0.1, 0.085))
    vase = turned("Vase", PROFILE, 0.22, 112, steps=7)
    put(scene, "Clean Vase", vase, preset_material("clean_copper", settle), (-0.72, 0.55, 0.0))
    put(scene, "Weathered Vase", vase, weathered_copper(settle), (0.62, -0.35, 0.0), (0.0, 0.0, 40.0))
    return scene


def weathered_copper(settle: bool) -> bpy.types.Material:
    """The preset of patina, on the part of the surface that a mask of noise and height gives."""
    data = presets.load("patina_copper").to_dict()
    data["layers"][0][COVERAGE.name] = 1.0
    material = stack_material("Weathered Copper", Stack.from_dict({**data, "schema_version": 2}), settle=False)
    _mask(material.node_tree, node_of(material.lamina.layers[0]).inputs["Coverage"])
    refresh(material, settle=settle)
    return material


def _mask(tree: bpy.types.NodeTree, coverage: bpy.types.NodeSocket) -> None:
    place, noise = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value, noise.inputs["Roughness"].default_value = 2.2, 9.0, 0.62
    split, height = tree.nodes.new("ShaderNodeSeparateXYZ"), tree.nodes.new("ShaderNodeMath")
    height.operation, height.inputs[1].default_value = "MULTIPLY_ADD", -0.11
    edge = tree.nodes.new("ShaderNodeMapRange")
    edge.interpolation_type = "SMOOTHSTEP"
    edge.inputs["From Min"].default_value, edge.inputs["From Max"].default_value = 0.33, 0.47
    tree.links.new(place.outputs["Object"], noise.inputs["Vector"])
    tree.links.new(place.outputs["Object"], split.inputs[0])
    tree.links.new(split.outputs["Z"], height.inputs[0])
    tree.links.new(noise.outputs[0], height.inputs[2])
    tree.links.new(height.outputs[0], edge.inputs["Value"])
    tree.links.new(edge.outputs["Result"], coverage)
    for column, node in enumerate((place, split, noise, height, edge)):
        node.location = (-1500 + 200 * column, 0)
