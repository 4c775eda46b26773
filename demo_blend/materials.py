# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the demo scenes: Lamina stacks, baked, and plain Principled ones for what stands around."""

import bpy

from ..addon.blender.versions import node_tree
from ..addon.material.material import apply_stack
from ..reference_py.lobes.methods import DEFAULT_METHOD
from ..reference_py.material import presets
from ..reference_py.material.stack import Stack


def stack_material(name: str, stack: Stack, tier: str = DEFAULT_METHOD, settle: bool = True) -> bpy.types.Material:
    """New material with a stack; what its tier bakes is done when this returns, unless told not to `settle`."""
    material = bpy.data.materials.new(name)
    apply_stack(material, stack, tier, settle=settle)
    return material


def preset_material(name: str, settle: bool = True) -> bpy.types.Material:
    """New material with a preset, named by its label."""
    return stack_material(presets.label(name), presets.load(name), settle=settle)


def plain_material(name: str, color: tuple[float, float, float], roughness: float = 0.6) -> bpy.types.Material:
    """New Principled material of a linear color."""
    material = bpy.data.materials.new(name)
    shader = next(node for node in node_tree(material).nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material
