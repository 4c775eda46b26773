# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures on media that scatter, with values that no medium has: the picture is that of the nearest value that one has, or a line says why not."""

import bpy
import numpy as np
import pytest
from support.stacks import stack
from support.sunlit_ball import picture, stage

from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.live_values import live_values
from lamina.reference_py.errors import LaminaError

pytestmark = pytest.mark.blender

MILKY = {"kind": "dielectric", "roughness": 0.2, "scatter_color": [0.8, 0.5, 0.3], "density": 2.0, "scatter_g": 0.2}
SHOWN = stack(MILKY, base={"kind": "lambert", "color": [0.1, 0.2, 0.4]})


def textured(label: str, value: float):
    """A material whose medium has a value by nodes that give this number everywhere."""
    made = bpy.data.materials.new("milky")
    materials.apply_stack(made, SHOWN, "auto")
    tree = made.node_tree
    noise, number = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMath")
    number.operation = "MULTIPLY_ADD"
    number.inputs[1].default_value, number.inputs[2].default_value = 0.0, value
    tree.links.new(noise.outputs[0], number.inputs[0])
    tree.links.new(number.outputs[0], node_of(made.lamina.layers[0]).inputs[label])
    return made


def shown(made, folder) -> list[np.ndarray]:
    """Means of its pictures with OSL and without; nothing is wrong with it."""
    materials.refresh(made, settle=True)
    assert live_values(made) and all(finding.is_note for finding in check.find(made, bpy.context.scene, bpy.context.preferences))
    stage(made, folder)
    return [picture(folder, True), picture(folder, False)]


@pytest.mark.parametrize(
    ("label", "given", "nearest"), [("Density", -5.0, 0.0), ("Density", 1e5, 1000.0), ("Scatter Color", -2.0, 0.0), ("Scatter Color", 3.0, 1.0)]
)
def test_the_nearest_value_of_a_medium_shows(blender, tmp_path, label, given, nearest):
    found, wanted = [], []
    for value, pictures in ((given, found), (nearest, wanted)):
        blender.ops.wm.read_factory_settings(use_empty=True)
        pictures += shown(textured(label, value), tmp_path)
    assert np.all(np.isfinite(found)) and found == pytest.approx(np.array(wanted), rel=1e-5)


def test_no_density_is_a_clear_layer(blender, tmp_path):
    found = shown(textured("Density", -5.0), tmp_path)
    blender.ops.wm.read_factory_settings(use_empty=True)
    clear = bpy.data.materials.new("clear")
    materials.apply_stack(clear, stack({"kind": "dielectric", "roughness": 0.2}, base=SHOWN.base.to_dict()), "baked")
    materials.refresh(clear, settle=True)
    stage(clear, tmp_path)
    assert found[0] == pytest.approx(picture(tmp_path, True), rel=0.01)


def test_a_forwardness_that_varies_is_refused_in_one_line(blender):
    made = textured("Forwardness", 5.0)
    with pytest.raises(LaminaError, match="no quality follows the scatter g of Dielectric where a medium scatters; take its texture or animation away"):
        materials.refresh(made, settle=True)
