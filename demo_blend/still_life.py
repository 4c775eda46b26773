# SPDX-License-Identifier: GPL-3.0-or-later
"""An exhibit of aluminium coated in several ways, in the manner of figure 1 of Weidlich and Wilkie 2007: a concertina.

Apart from the bellows all is aluminium; its own color shows on the buttons.
"""

import bpy
import numpy as np

from ..reference_py.material.stack import Stack
from .materials import plain_material, preset_material, stack_material
from .set import put, stage
from .shapes import ball, loft, polygon_ring, turned

FOLDS = 11
HEAD, RIM = 0.8, 0.86


def build(settle: bool = True) -> bpy.types.Scene:
    """A concertina on its side, a flask and two balls."""
    scene = stage("Still Life", (0.4, -9.0, 2.9), (0.05, 0.0, 0.72), 76.0)
    aluminium = stack_material("Aluminium", Stack.from_dict({"base": {"kind": "conductor", "metal": "aluminium", "roughness": 0.3}}), settle=settle)
    paint, dyed, varnished = (preset_material(name, settle) for name in ("clear_coat_car_paint", "anodised_aluminium", "metallic_car_paint"))
    _concertina(scene, paint, dyed, aluminium)
    _flask(scene, varnished, aluminium)
    put(scene, "Ball", ball("Ball", 0.26), dyed, (-1.35, -1.0, 0.26))
    put(scene, "Small Ball", ball("Small Ball", 0.17), aluminium, (-0.86, -1.3, 0.17))
    return scene


def _concertina(scene, heads, rims, buttons) -> None:
    """Its axis is x; it stands on one of its six sides."""
    turn, low = np.array([0.0, 0.0, -16.0]), RIM * np.cos(np.pi / 6.0)
    holder = bpy.data.objects.new("Concertina", None)
    scene.collection.objects.link(holder)
    holder.location, holder.rotation_euler = (-0.15, 0.1, low), np.radians(turn)
    leather = plain_material("Bellows", (0.05, 0.012, 0.01), 0.55)
    ring = polygon_ring(6, 1.0)
    folds = np.repeat(np.linspace(-0.62, 0.62, 2 * FOLDS + 1), 1)
    reach = np.where(np.arange(len(folds)) % 2 == 0, 0.62, 0.78)
    parts = [("Bellows", leather, list(zip(folds, reach)), False)]
    for side, name in ((-1.0, "Left"), (1.0, "Right")):
        rim = [(side * x, r) for x, r in ((0.6, RIM - 0.02), (0.62, RIM), (0.76, RIM), (0.78, RIM - 0.02))]
        head = [(side * x, r) for x, r in ((0.78, HEAD), (0.98, HEAD), (1.01, HEAD - 0.03))]
        parts += [(f"{name} Rim", rims, rim[:: int(side)], False), (f"{name} Head", heads, head[:: int(side)], False)]
    for name, material, stations, smooth in parts:
        rings = np.stack([np.concatenate([np.full((len(ring), 1), x), r * ring], axis=1) for x, r in stations])
        put(scene, name, loft(name, rings, smooth), material).parent = holder
    button = turned("Button", [(0.0, 0.09), (0.055, 0.085), (0.06, 0.0)], [0.0, 0.03, 0.0], 48)
    for row, (count, height) in enumerate(((4, 0.2), (5, 0.0), (4, -0.2))):
        for i in range(count):
            item = put(scene, f"Button {row + 1}.{i + 1}", button, buttons, (1.0, (i - (count - 1) / 2) * 0.19, height), (0.0, 90.0, 0.0))
            item.parent = holder


def _flask(scene, body, stopper) -> None:
    points = [(0.0, 1.5), (0.12, 1.5), (0.13, 1.22), (0.42, 0.82), (0.46, 0.1), (0.4, 0.0), (0.0, 0.0)]
    put(scene, "Flask", turned("Flask", points, [0.0, 0.03, 0.2, 0.2, 0.1, 0.05, 0.0], 128), body, (1.42, 0.35, 0.0))
    put(scene, "Stopper", turned("Stopper", [(0.0, 0.3), (0.16, 0.26), (0.17, 0.1), (0.08, 0.0), (0.0, 0.0)], 0.05, 96), stopper, (1.42, 0.35, 1.47))
