# SPDX-License-Identifier: GPL-3.0-or-later
"""The same yellow varnish in six thicknesses over white, as in figure 5 of Weidlich and Wilkie 2007."""

import bpy

from ..reference_py.material import presets
from .materials import stack_material
from .set import per_object, put, stage
from .shapes import ball

THICKNESS = (0.1, 0.4, 0.8, 1.6, 3.2, 6.4)
RADIUS, STEP = 0.44, 0.98
HEIGHT = 360  # of the picture in pixels: the balls fill it


def build(settle: bool = True) -> bpy.types.Scene:
    """One material for all balls: each gives its own thickness."""
    scene = stage("Thickness Series", (0.0, -9.6, 2.6), (0.0, 0.0, 0.42), 57.0)
    scene.render.resolution_y = HEIGHT
    material = stack_material("Tinted Glaze", presets.load("tinted_glaze"), "analytic")
    per_object(material, material.lamina.layers[0], "Thickness", "thickness")
    mesh = ball("Ball", RADIUS)
    for i, thickness in enumerate(THICKNESS):
        item = put(scene, f"Thickness {thickness:g}", mesh, material, ((i - 2.5) * STEP, 0.0, RADIUS))
        item["thickness"] = thickness
    return scene
