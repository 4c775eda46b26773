# SPDX-License-Identifier: GPL-3.0-or-later
"""A turntable of car paint: a form such as paint shops spray to judge colors on, turned once in 120 frames."""

import bpy
import numpy as np
from mathutils import Vector

from ..addon.rendering.settings import add_object
from .materials import plain_material, preset_material
from .set import put, stage
from .shapes import loft, turned

FRAMES = 120
SECTIONS, AROUND = 96, 128


def build(settle: bool = True) -> bpy.types.Scene:
    """The form and its table hang on one empty, which turns."""
    scene = stage("Car Paint Turntable", (0.0, -9.4, 3.1), (0.0, 0.0, 0.5), 80.0)
    scene.frame_start, scene.frame_end, scene.render.fps = 1, FRAMES, 24
    form = put(scene, "Form", speed_form("Form"), preset_material("clear_coat_car_paint", settle), (0.0, 0.0, 0.16))
    table = turned("Table", [(0.0, 0.12), (1.72, 0.12), (1.72, 0.0), (0.0, 0.0)], [0.0, 0.03, 0.01, 0.0], 160)
    disc = put(scene, "Table", table, plain_material("Table", (0.2, 0.2, 0.21), 0.3))
    for place, power in (((-0.9, -1.5, 3.4), 160.0), ((0.4, 0.9, 3.2), 220.0)):
        _tube(scene, place, power)
    turner = bpy.data.objects.new("Turner", None)
    scene.collection.objects.link(turner)
    form.parent = disc.parent = turner
    _turn_once(turner)
    scene.frame_set(1)
    return scene


def speed_form(name: str) -> bpy.types.Mesh:
    """A drop of 3 m with shoulders and a flat belly: superellipses along x, sharper toward the tail."""
    u = np.linspace(-1.0, 1.0, SECTIONS)
    x = 1.5 * np.sin(0.5 * np.pi * u)
    s = (x + 1.5) / 3.0
    width = 0.66 * np.sqrt(np.clip(1.0 - np.square(2.0 * s - 1.0), 0.0, None)) ** 0.75 * (1.12 - 0.24 * s) + 1e-3
    height = (0.3 + 0.42 * np.exp(-np.square((s - 0.47) / 0.25))) * np.sqrt(np.clip(1.0 - np.square(2.0 * s - 1.0), 0.0, None)) ** 0.6 + 1e-3
    phi = 2.0 * np.pi * np.arange(AROUND) / AROUND
    power = 2.0 / (2.0 + 1.1 * np.sin(np.pi * s))[:, None]
    across = np.sign(np.cos(phi)) * np.abs(np.cos(phi)) ** power * width[:, None]
    up = np.abs(np.sin(phi)) ** power
    up = np.where(np.sin(phi) > 0.0, up * height[:, None], -up * 0.22 * np.minimum(height, 0.5)[:, None])
    rings = np.stack(np.broadcast_arrays(x[:, None], across, up + 0.14 + 0.06 * np.square(2.0 * s - 1.0)[:, None]), axis=-1)
    return loft(name, rings)


def _tube(scene: bpy.types.Scene, location: tuple[float, float, float], power: float) -> None:
    """A long lamp such as paint shops hang over a car: its reflection is a line that shows the form."""
    light = bpy.data.lights.new("Tube", "AREA")
    light.shape, light.size, light.size_y, light.energy = "RECTANGLE", 5.0, 0.16, power
    lamp = add_object(scene, "Tube", light)
    lamp.location = location
    lamp.rotation_euler = (Vector(location) - Vector((0.0, 0.0, 0.4))).to_track_quat("Z", "Y").to_euler()


def _turn_once(item: bpy.types.Object) -> None:
    for frame, turns in ((1, 0.0), (FRAMES + 1, 1.0)):
        item.rotation_euler = (0.0, 0.0, 2.0 * np.pi * turns + np.radians(28.0))
        item.keyframe_insert("rotation_euler", index=2, frame=frame)
    for curve in _curves(item):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def _curves(item: bpy.types.Object):
    """The f-curves of an object's action, which Blender 5.0 keeps in channel bags."""
    action = item.animation_data.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return action.layers[0].strips[0].channelbag(item.animation_data.action_slot).fcurves
