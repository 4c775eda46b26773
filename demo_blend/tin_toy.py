# SPDX-License-Identifier: GPL-3.0-or-later
"""A tin robot that somebody loved: printed and painted steel, chipped to primer and metal, rusted, dusty, on a varnished table.

What is worn is drawn by the masks that ship with Lamina; the print and the wood's grain are textures of the bases.
"""

from functools import partial

import bpy
import numpy as np
from mathutils import Euler, Vector

from ..addon.material.elements import node_of
from ..addon.material.material import refresh
from ..reference_py.material import presets, ready_layers
from ..reference_py.material.stack import Stack
from . import shapes
from .materials import plain_material, stack_material
from .set import put, stage
from .shapes import ball, rounded_box, tube

TEAL, RED, CREAM, MUSTARD = (0.02, 0.155, 0.17), (0.43, 0.024, 0.016), (0.66, 0.53, 0.33), (0.6, 0.27, 0.025)
TABLE = 0.16  # its thickness
# Its many small parts need few vertices.
turned = partial(shapes.turned, steps=4)


def build(settle: bool = True) -> bpy.types.Scene:
    """All of the robot hangs on one empty, turned a little away from the camera."""
    scene = stage("Tin Toy", (0.5, -9.0, 2.5), (0.16, 0.0, 1.16), 67.0, samples=64, paper=(0.055, 0.06, 0.066))
    scene.render.resolution_x, scene.render.resolution_y = 1280, 800
    scene.objects["Backdrop"].location.z = -TABLE
    toy = bpy.data.objects.new("Robot", None)
    scene.collection.objects.link(toy)
    toy.location, toy.rotation_euler = (-0.1, 0.1, 0.0), np.radians((0.0, 0.0, -20.0))
    paint = {
        name: _paint(name, color, settle, band)
        for name, color, band in (("Teal", TEAL, CREAM), ("Red", RED, None), ("Cream", CREAM, RED), ("Mustard", MUSTARD, None))
    }
    steel = stack_material(
        "Tin", Stack.from_dict({"layers": [_layer("dirt")], "base": {"kind": "conductor", "metal": "iron", "roughness": 0.32}}), settle=settle
    )
    brass = stack_material(
        "Brass", Stack.from_dict({"layers": [_layer("dirt")], "base": {"kind": "conductor", "metal": "brass", "roughness": 0.24}}), settle=settle
    )
    before = set(scene.objects)
    _body(scene, paint, steel, brass)
    _head(scene, paint, steel, brass)
    for side in (-1.0, 1.0):
        _limbs(scene, side, paint, steel, brass)
    for item in set(scene.objects) - before:
        item.parent = toy
    put(scene, "Ball", ball("Ball", 0.27, 48), _paint("Ball", MUSTARD, settle, RED), (1.36, -0.62, 0.27), (24.0, 18.0, 0.0))
    _key(scene, brass, (-1.32, -0.78, 0.045), (90.0, 0.0, 28.0))
    put(scene, "Table", rounded_box("Table", (7.4, 4.6, TABLE), 0.03), _table(settle), (0.0, 0.35, -0.5 * TABLE))
    return scene


def _layer(name: str, **values) -> dict:
    """A ready layer as JSON, some of its mask's values replaced."""
    layer = ready_layers.load(name)[2][0].to_dict()
    layer["masks"]["coverage"] |= values
    return layer


def _paint(name: str, color, settle: bool, band=None) -> bpy.types.Material:
    """Gloss paint over tin, worn, with a printed band of another color about its middle."""
    chips = {"scale": 3.2, "width": 0.045, "pull": 3.2}
    layers = [
        _layer("dust", high=0.5),
        _layer("rust_streaks", amount=0.09, scale=7.0, high=0.7),
        _layer("rust", amount=0.05, softness=0.3, **chips),
        _layer("bare_steel", amount=0.085, softness=0.08, **chips),
        {"kind": "dielectric", "name": "Binder", "ior": 1.5, "roughness": 0.22},
    ]
    material = stack_material(f"{name} Tin", Stack.from_dict({"layers": layers, "base": {"kind": "lambert", "color": color}}), settle=False)
    if band is not None:
        _print(material, color, band)
    refresh(material, settle=settle)
    return material


def _print(material, color, band) -> None:
    """Two lines and a band, cut sharply, of the object's own height."""
    tree = material.node_tree
    place, split, ramp = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    stops = ramp.color_ramp
    stops.interpolation = "CONSTANT"
    for position, paint in ((0.3, band), (0.33, color), (0.37, band), (0.63, color), (0.67, band), (0.7, color)):
        stops.elements.new(position).color = (*paint, 1.0)
    stops.elements[0].color = (*color, 1.0)
    stops.elements.remove(stops.elements[-1])
    tree.links.new(place.outputs["Generated"], split.inputs[0])
    tree.links.new(split.outputs["Z"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], node_of(material.lamina.base).inputs["Color"])


def _table(settle: bool) -> bpy.types.Material:
    """Worn varnish over wood, whose grain is noise drawn out along x."""
    stack = presets.load("worn_varnish").to_dict()
    stack["layers"][0]["masks"]["coverage"] |= {"amount": 0.07, "scale": 13.0, "width": 0.008, "softness": 0.5}
    stack["layers"][0]["masks"]["roughness"] |= {"scale": 9.0, "low": 0.1, "high": 0.3}
    material = stack_material("Varnished Wood", Stack.from_dict(stack), settle=False)
    tree = material.node_tree
    place, drawn, noise, ramp = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "Mapping", "TexNoise", "ValToRGB"))
    drawn.inputs["Scale"].default_value = (0.35, 9.0, 9.0)
    noise.inputs["Detail"].default_value, noise.inputs["Roughness"].default_value, noise.inputs["Distortion"].default_value = 6.0, 0.62, 0.6
    for element, position, color in zip(ramp.color_ramp.elements, (0.36, 0.64), ((0.1, 0.035, 0.014, 1.0), (0.56, 0.32, 0.15, 1.0))):
        element.position, element.color = position, color
    tree.links.new(place.outputs["Object"], drawn.inputs[0])
    tree.links.new(drawn.outputs[0], noise.inputs["Vector"])
    tree.links.new(noise.outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], node_of(material.lamina.base).inputs["Color"])
    refresh(material, settle=settle)
    return material


def _body(scene, paint, steel, brass) -> None:
    put(scene, "Chest", rounded_box("Chest", (1.02, 0.66, 0.92), 0.05), paint["Teal"], (0.0, 0.0, 1.07))
    put(scene, "Belt", rounded_box("Belt", (0.9, 0.56, 0.12), 0.03), steel, (0.0, 0.0, 0.58))
    put(scene, "Panel", rounded_box("Panel", (0.62, 0.05, 0.34), 0.02), paint["Red"], (0.0, -0.345, 1.2))
    dial, needle, black = turned("Dial", [(0.0, 0.03), (0.11, 0.03), (0.12, 0.05), (0.145, 0.05), (0.15, 0.0), (0.0, 0.0)], 0.008, 48), rounded_box("Needle", (0.016, 0.012, 0.1), 0.004), plain_material("Black", (0.01, 0.01, 0.012), 0.4)  # fmt: skip
    for x, lean in ((-0.155, 35.0), (0.155, -50.0)):
        put(scene, "Dial", dial, [paint["Cream"]], (x, -0.37, 1.21), (90.0, 0.0, 0.0))
        put(scene, "Needle", needle, black, (x, -0.41, 1.23), (0.0, lean, 0.0))
    button = turned("Button", [(0.0, 0.06), (0.045, 0.055), (0.05, 0.0), (0.0, 0.0)], 0.012, 40)
    for x, name in ((-0.2, "Mustard"), (0.0, "Cream"), (0.2, "Red")):
        put(scene, f"Button {name}", button, brass if name == "Cream" else paint[name], (x, -0.33, 0.86), (90.0, 0.0, 0.0))
    rivet = turned("Rivet", [(0.0, 0.018), (0.02, 0.012), (0.026, 0.0), (0.0, 0.0)], 0.006, 24)
    for x in (-0.45, 0.45):
        for z in (0.7, 0.95, 1.2, 1.45):
            put(scene, "Rivet", rivet, steel, (x, -0.33, z), (90.0, 0.0, 0.0))
    _key(scene, brass, (0.53, 0.06, 1.12), (0.0, 90.0, 0.0))


def _head(scene, paint, steel, brass) -> None:
    put(scene, "Neck", turned("Neck", [(0.0, 0.1), (0.2, 0.1), (0.2, 0.0), (0.0, 0.0)], 0.02, 48), steel, (0.0, 0.0, 1.52))
    put(scene, "Head", rounded_box("Head", (0.72, 0.54, 0.5), 0.06), paint["Mustard"], (0.0, 0.0, 1.86))
    socket = turned("Socket", [(0.0, 0.03), (0.1, 0.03), (0.11, 0.07), (0.14, 0.07), (0.145, 0.0), (0.0, 0.0)], 0.01, 48)
    lens = turned("Lens", [(0.0, 0.085), (0.06, 0.075), (0.1, 0.03), (0.1, 0.0), (0.0, 0.0)], 0.04, 48)
    glass = stack_material(
        "Lens",
        Stack.from_dict(
            {"layers": [{"kind": "dielectric", "ior": 1.5, "tint": [0.9, 0.25, 0.04]}], "base": {"kind": "conductor", "metal": "silver", "roughness": 0.3}}
        ),
    )
    for x in (-0.17, 0.17):
        put(scene, "Socket", socket, steel, (x, -0.265, 1.93), (90.0, 0.0, 0.0))
        put(scene, "Lens", lens, glass, (x, -0.275, 1.93), (90.0, 0.0, 0.0))
    ear = turned("Ear", [(0.0, 0.12), (0.05, 0.11), (0.12, 0.03), (0.13, 0.0), (0.0, 0.0)], 0.02, 48)
    put(scene, "Ear", ear, paint["Red"], (0.36, 0.0, 1.86), (0.0, 90.0, 0.0))
    put(scene, "Mouth", rounded_box("Mouth", (0.4, 0.04, 0.1), 0.015), steel, (0.0, -0.27, 1.71))
    slot, dark = rounded_box("Slot", (0.03, 0.03, 0.07), 0.006), plain_material("Dark", (0.008, 0.008, 0.008), 0.7)
    for i in range(6):
        put(scene, "Slot", slot, dark, (0.06 * (i - 2.5), -0.282, 1.71))
    put(scene, "Aerial", turned("Aerial", [(0.0, 0.34), (0.012, 0.33), (0.014, 0.04), (0.06, 0.02), (0.07, 0.0), (0.0, 0.0)], 0.01, 40), brass, (0.0, 0.0, 2.1))
    put(scene, "Knob", ball("Knob", 0.05, 48), paint["Red"], (0.0, 0.0, 2.46))


def _limbs(scene, side: float, paint, steel, brass) -> None:
    put(scene, "Leg", rounded_box("Leg", (0.34, 0.36, 0.42), 0.035), paint["Teal"], (0.24 * side, 0.02, 0.36))
    put(scene, "Foot", rounded_box("Foot", (0.42, 0.66, 0.2), 0.05), paint["Red"], (0.24 * side, -0.08, 0.1))
    put(
        scene,
        "Shoulder",
        turned("Shoulder", [(0.0, 0.14), (0.1, 0.13), (0.17, 0.04), (0.18, 0.0), (0.0, 0.0)], 0.02, 48),
        paint["Red"],
        (0.5 * side, 0.0, 1.34),
        (0.0, 90.0 * side, 0.0),
    )
    bend = -34.0 if side > 0.0 else -12.0
    shoulder, turn = np.array((0.68 * side, 0.0, 1.32)), Euler(np.radians((bend, 0.0, 0.0))).to_matrix()
    for name, mesh, material, down in (
        ("Arm", rounded_box("Arm", (0.17, 0.22, 0.62), 0.03), paint["Cream"], 0.2),
        ("Wrist", turned("Wrist", [(0.0, 0.12), (0.07, 0.12), (0.07, 0.0), (0.0, 0.0)], 0.015, 48), steel, 0.62),
    ):
        put(scene, name, mesh, material, shoulder + np.array(turn @ _down(down)), (bend, 0.0, 0.0))
    angle = np.radians(np.linspace(130.0, 410.0, 28))
    claw = tube("Claw", np.stack([0.12 * np.cos(angle), 0.0 * angle, 0.12 * np.sin(angle)], axis=1), 0.036, 16)
    put(scene, "Claw", claw, paint["Red"], shoulder + np.array(turn @ _down(0.72)), (bend, 180.0, 0.0))


def _down(length: float) -> Vector:
    return Vector((0.0, 0.0, -length))


def _key(scene, material, place, turn) -> None:
    """A clockwork key: a stem and a bow of two loops, its stem along z."""
    put(scene, "Key Stem", turned("Key Stem", [(0.0, 0.3), (0.035, 0.3), (0.035, 0.0), (0.0, 0.0)], 0.01, 40), material, place, turn)
    angle = np.linspace(0.0, 2.0 * np.pi, 33)
    for side in (-1.0, 1.0):
        bow = tube("Key Bow", np.stack([0.11 * side + 0.1 * np.cos(angle), 0.0 * angle, 0.36 + 0.075 * np.sin(angle)], axis=1), 0.026, 12)
        put(scene, "Key Bow", bow, material, place, turn)
