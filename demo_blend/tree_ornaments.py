# SPDX-License-Identifier: GPL-3.0-or-later
"""Tree ornaments of metal foil and of frosted metal: figure 8b of Weidlich and Wilkie 2007."""

import bpy
import numpy as np

from ..reference_py.material import presets
from ..reference_py.material.stack import Stack
from .materials import plain_material, preset_material, stack_material
from .set import put, stage
from .shapes import ball, needles, tube, turned

AMBER = (0.86, 0.5, 0.1)


def build(settle: bool = True) -> bpy.types.Scene:
    """The foil's orb behind, two frosted ones in front, one in the paper's tint and one in amber."""
    scene = stage("Tree Ornaments", (0.0, -9.0, 2.5), (0.0, 0.2, 0.66), 86.0)
    gold = stack_material("Cap", Stack.from_dict({"base": {"kind": "conductor", "metal": "brass", "roughness": 0.35}}), settle=settle)
    amber = presets.load("frosted_metal").to_dict()
    amber["layers"][0]["tint"] = list(AMBER)
    orbs = (
        ("Foil", preset_material("metal_foil", settle), 0.66, (0.1, 0.95), (12.0, 8.0, 0.0)),
        ("Frosted", preset_material("frosted_metal", settle), 0.52, (-0.72, -0.35), (-20.0, -28.0, 0.0)),
        ("Frosted Amber", stack_material("Frosted Amber", Stack.from_dict(amber), settle=settle), 0.46, (0.72, -0.55), (-24.0, 34.0, 0.0)),
    )
    orb = ball("Orb", 1.0, 112)
    for name, material, radius, (x, y), turn in orbs:
        place = (x, y, radius)
        put(scene, name, orb, material, place, turn, radius)
        _cap(scene, name, radius, gold, place, turn)
    _twigs(scene)
    return scene


def _cap(scene, name: str, radius: float, material, place, turn) -> None:
    """The metal cap with its ring, which turns with the orb."""
    top, wide = radius * 0.985, 0.2 * radius
    points = [(0.0, top + 0.22 * radius), (wide, top + 0.22 * radius), (wide, top - 0.03 * radius), (0.9 * wide, top - 0.03 * radius)]
    put(scene, f"{name} Cap", turned(f"{name} Cap", points, 0.02, 64), material, place, turn)
    bend = np.linspace(0.0, 2.0 * np.pi, 49)
    path = np.stack([0.09 * np.cos(bend), 0.0 * bend, top + 0.22 * radius + 0.085 + 0.09 * np.sin(bend)], axis=1)
    put(scene, f"{name} Ring", tube(f"{name} Ring", path, 0.012, 12), material, place, turn)


def _twigs(scene) -> None:
    green = plain_material("Fir", (0.035, 0.14, 0.04), 0.4)
    twig = needles("Twig", 800, 1.7, 0.008, seed=3)
    for number, (place, turn) in enumerate((((-2.0, 0.5, 0.4), (0.0, 6.0, 12.0)), ((2.1, 0.6, 0.45), (30.0, 8.0, 172.0)), ((1.9, -0.3, 0.25), (70.0, 3.0, 140.0)),
                                            ((-1.8, 1.2, 0.75), (120.0, 4.0, 20.0)), ((-1.75, -0.6, 0.22), (200.0, 3.0, 50.0)))):  # fmt: skip
        put(scene, f"Twig {number + 1}", twig, green, place, turn)
