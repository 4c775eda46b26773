# SPDX-License-Identifier: GPL-3.0-or-later
"""Crayons with enamel of index 1.3 and mugs with glaze of index 1.6: figure 8a of Weidlich and Wilkie 2007."""

import bpy
import numpy as np

from ..reference_py.lobes.methods import AnalyticLobes
from ..reference_py.material import presets
from .materials import plain_material, stack_material
from .set import link_attribute, per_object, put, stage
from .shapes import tube, turned

RED, ORANGE, YELLOW, GREEN, BLUE, VIOLET = (
    (0.62, 0.03, 0.025),
    (0.8, 0.23, 0.02),
    (0.85, 0.6, 0.03),
    (0.05, 0.36, 0.08),
    (0.02, 0.11, 0.5),
    (0.2, 0.04, 0.32),
)
# length of a crayon and where its wood and enamel begin, below the tip
LENGTH, WOOD, ENAMEL, RADIUS = 1.75, 0.1, 0.34, 0.075
# place of the lower end, and the tips' directions: azimuth and height in degrees
CRAYONS = (
    (ORANGE, (-1.55, -1.05, RADIUS), 8.0, 0.0),
    (GREEN, (-1.35, -1.4, RADIUS), -5.0, 0.0),
    (VIOLET, (0.15, -1.0, RADIUS), 22.0, 0.0),
    (RED, (-0.72, 0.2, 0.1), 165.0, 76.0),
    (BLUE, (-0.6, 0.08, 0.1), 35.0, 78.0),
    (YELLOW, (-0.66, 0.3, 0.1), 80.0, 80.0),
)
MUGS = (("Mug", (-0.66, 0.18, 0.0), (0.035, 0.17, 0.3), 205.0), ("Cream Mug", (0.82, 0.1, 0.0), (0.78, 0.7, 0.52), -32.0))
# radius and height, from the inside's bottom over the lip to the foot
CUP = [(0.0, 0.07), (0.4, 0.07), (0.43, 1.0), (0.49, 1.0), (0.47, 0.0), (0.38, 0.0), (0.36, 0.03), (0.0, 0.03)]


def build(settle: bool = True) -> bpy.types.Scene:
    """One material of enamel and one of glaze; every object gives its own color."""
    scene = stage("Crayons and Mugs", (0.1, -8.8, 3.2), (-0.1, -0.2, 0.72), 74.0, paper=(0.3, 0.27, 0.23))
    enamel, glaze = (_colored(name) for name in ("crayon_paint", "glazed_mug"))
    wood, lead = plain_material("Wood", (0.55, 0.33, 0.16)), plain_material("Lead", (0.8, 0.8, 0.8), 0.75)
    link_attribute(lead.node_tree, next(n for n in lead.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"], "color")
    tip = 0.025
    points = [(0.0, LENGTH), (tip, LENGTH - 0.02), (0.36 * RADIUS, LENGTH - WOOD), (RADIUS, LENGTH - ENAMEL), (RADIUS, 0.0), (0.0, 0.0)]
    crayon = turned("Crayon", points, [0.0, 0.02, 0.0, 0.0, 0.015, 0.0], 48, marks={2: 1, 3: 2})
    for number, (color, place, azimuth, height) in enumerate(CRAYONS):
        item = put(scene, f"Crayon {number + 1}", crayon, [lead, wood, enamel], place, (0.0, 90.0 - height, azimuth))
        item["color"] = color
    cup = turned("Cup", CUP, [0.0, 0.1, 0.03, 0.03, 0.06, 0.02, 0.02, 0.0], 128)
    bend = np.radians(np.linspace(-92.0, 92.0, 32))
    handle = tube("Handle", np.stack([0.465 + 0.28 * np.cos(bend), 0.0 * bend, 0.5 + 0.32 * np.sin(bend)], axis=1), 0.06)
    for name, place, color, turn in MUGS:
        for part, mesh in (("", cup), (" Handle", handle)):
            put(scene, name + part, mesh, glaze, place, (0.0, 0.0, turn))["color"] = color
    return scene


def _colored(preset: str) -> bpy.types.Material:
    material = stack_material(presets.label(preset), presets.load(preset), AnalyticLobes.name)
    per_object(material, material.lamina.base, "Color", "color")
    return material
