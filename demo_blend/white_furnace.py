# SPDX-License-Identifier: GPL-3.0-or-later
"""Lossless white balls in an even grey world, where what loses or makes no energy cannot be seen.

Above, a clear coat over white, smooth to rough, in the tier analytic; below, the same in the tier of the paper's own
components, whose energy is the paper's.
"""

import bpy

from ..addon.blender.versions import node_tree
from ..reference_py.lobes.methods import AnalyticLobes, PaperLobes
from ..reference_py.material.stack import Stack
from .materials import stack_material
from .set import look, per_object, put, stage
from .shapes import ball

ROUGHNESS = (0.0, 0.25, 0.5, 0.75, 1.0)
RADIUS, STEP = 0.45, 1.05
LEVEL = 0.5


def build(settle: bool = True) -> bpy.types.Scene:
    """Rows of balls; their property `roughness` is the coat's."""
    scene = stage("White Furnace", (0.0, -10.0, 0.0), (0.0, 0.0, 0.0), samples=128)
    for item in [item for item in scene.objects if item.type == "LIGHT" or item.name == "Backdrop"]:
        bpy.data.objects.remove(item)
    bpy.data.orphans_purge(do_recursive=True)
    _even_world(scene)
    look(scene, (0.0, -14.0, 0.0), (0.0, 0.0, 0.0), 82.0)
    scene.view_settings.view_transform = "Standard"
    scene.cycles.max_bounces = 8
    mesh = ball("Ball", RADIUS, 192)
    for lobe_set, row in ((AnalyticLobes, 0.56), (PaperLobes, -0.56)):
        material = _white(lobe_set.name)
        for i, roughness in enumerate(ROUGHNESS):
            item = put(scene, f"{lobe_set.name} {roughness:g}", mesh, material, ((i - 2.0) * STEP, 0.0, row))
            item["roughness"] = roughness
            item.visible_diffuse = item.visible_glossy = False  # no ball sees another
    return scene


def _white(tier: str) -> bpy.types.Material:
    stack = {"layers": [{"kind": "dielectric", "ior": 1.5}], "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]}}
    material = stack_material(f"White, {tier}", Stack.from_dict(stack), tier)
    per_object(material, material.lamina.layers[0], "Roughness", "roughness")
    return material


def _even_world(scene: bpy.types.Scene) -> None:
    scene.world = bpy.data.worlds.new("Furnace")
    tree = node_tree(scene.world)
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1.0, 1.0, 1.0, 1.0), LEVEL
    tree.links.new(background.outputs[0], output.inputs["Surface"])
