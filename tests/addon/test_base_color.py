# SPDX-License-Identifier: GPL-3.0-or-later
"""A texture on the base's color: baked materials follow it in the script and in stock nodes, as if each color were baked by itself."""

import numpy as np
import pytest
from support.coats import TWO_COATS
from support.sunlit_ball import AGREE, picture, stage

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import environment
from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import node_with
from lamina.addon.material.state import is_settled, is_stale, lags
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

SATIN = {"kind": "dielectric", "name": "Varnish", "roughness": 0.35, "tint": [0.9, 0.75, 0.5]}
LAYERS = {
    "varnish": [SATIN],
    "bare": [],
    "masked": [{**SATIN, "coverage": 0.5}],
    "under glass": [{"kind": "dielectric", "name": "Glass"}, SATIN],
    "two coats": TWO_COATS,
}
COLORS = ((0.05, 0.3, 0.8), (0.9, 0.9, 0.9), (0.0, 0.5, 0.02))


def stack_of(name: str, color) -> Stack:
    return Stack.from_dict({"layers": LAYERS[name], "base": {"kind": "lambert", "color": list(color)}})


def textured(name: str, tier: str) -> tuple:
    """A material whose base's color comes from another node, and that node's socket."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, stack_of(name, (0.8, 0.8, 0.8)), tier)
    texture = owner.node_tree.nodes.new("ShaderNodeRGB")
    owner.node_tree.links.new(texture.outputs[0], node_of(owner.lamina.base).inputs["Color"])
    materials.refresh(owner, settle=True)
    return owner, texture.outputs[0]


def in_white_world(owner, folder) -> None:
    """The scene of `stage` in a white world alone, which sees energies."""
    stage(owner, folder)
    bpy.data.objects.remove(bpy.data.objects["sun"])
    world = bpy.data.worlds.new("white")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)
    bpy.context.scene.world = world


# what auto takes is a bake here, too: of masks it is one for each patch
@pytest.mark.parametrize("name, tier", [*((name, "baked") for name in ("varnish", "bare", "masked", "under glass")), ("masked", "auto")])
def test_every_color_is_right_with_osl_and_without(blender, tmp_path, name, tier):
    owner, socket = textured(name, tier)
    in_white_world(owner, tmp_path)
    assert is_settled(owner) and not is_stale(owner) and not lags(owner)
    told = [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]
    assert "texture_ignored" not in told
    for color in COLORS:
        socket.default_value = (*color, 1.0)
        on, off = picture(tmp_path, True), picture(tmp_path, False)
        plain = bpy.data.materials.new("plain")
        materials.apply_stack(plain, stack_of(name, color), tier)
        bpy.data.objects["ball"].data.materials[0] = plain
        expected = picture(tmp_path, True)
        bpy.data.objects["ball"].data.materials[0] = owner
        assert not is_stale(owner) and not lags(owner), "a texture changes nothing that is held"
        for seen in (on, off):
            assert seen == pytest.approx(expected, rel=AGREE), color


def test_a_blender_without_osl_makes_it_too(blender, tmp_path, monkeypatch):
    monkeypatch.setattr(environment, "osl_available", lambda: (False, environment.NO_OSL))
    monkeypatch.setattr(environment, "renders_osl", lambda: False)
    owner, socket = textured("varnish", "baked")
    in_white_world(owner, tmp_path)
    assert node_with(owner, "osl") is None and is_settled(owner)
    seen = []
    for color in COLORS[:2]:
        socket.default_value = (*color, 1.0)
        seen.append(picture(tmp_path, False))
    monkeypatch.undo()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    owner, socket = textured("varnish", "baked")
    in_white_world(owner, tmp_path)
    for color, was in zip(COLORS, seen):
        socket.default_value = (*color, 1.0)
        assert picture(tmp_path, True) == pytest.approx(was, rel=AGREE)


def test_colors_that_no_surface_has_are_bounded(blender, tmp_path):
    """What a texture says beyond 0 and 1 counts as these: finite, and no more than is received."""
    owner, socket = textured("varnish", "baked")
    stage(owner, tmp_path)
    bounded = []
    for color in ((1.0, 1.0, 0.0), (40.0, 1.0, -3.0)):
        socket.default_value = (*color, 1.0)
        bounded.append((picture(tmp_path, True), picture(tmp_path, False)))
    assert np.array(bounded[0]) == pytest.approx(np.array(bounded[1]), rel=1e-6)


def give(owner, element, label: str, value: float) -> bpy.types.NodeSocket:
    """Link an element's value to another node's; that node's socket."""
    node = owner.node_tree.nodes.new("ShaderNodeValue")
    node.outputs[0].default_value = value
    owner.node_tree.links.new(node.outputs[0], node_of(element).inputs[label])
    return node.outputs[0]


def test_with_a_roughness_and_a_thickness(blender, tmp_path):
    """The wooden table under two coats: both branches follow all three."""
    owner, color = textured("two coats", "baked")
    sockets = give(owner, owner.lamina.layers[0], "Roughness", 0.5), give(owner, owner.lamina.layers[1], "Thickness", 0.4)
    materials.refresh(owner, settle=True)
    in_white_world(owner, tmp_path)
    assert is_settled(owner) and not is_stale(owner) and not lags(owner)
    codes = [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]
    assert "texture_ignored" not in codes
    for rgb, roughness, thickness in (((0.05, 0.3, 0.8), 0.5, 0.4), ((0.7, 0.5, 0.3), 0.2, 1.5)):
        color.default_value = (*rgb, 1.0)
        sockets[0].default_value, sockets[1].default_value = roughness, thickness
        on, off = picture(tmp_path, True), picture(tmp_path, False)
        plain = bpy.data.materials.new("plain")
        coats = [TWO_COATS[0] | {"roughness": roughness}, TWO_COATS[1] | {"thickness": thickness}]
        materials.apply_stack(plain, Stack.from_dict({"layers": coats, "base": {"kind": "lambert", "color": list(rgb)}}), "baked")
        bpy.data.objects["ball"].data.materials[0] = plain
        expected = picture(tmp_path, True)
        for seen in (on, off):
            assert seen == pytest.approx(expected, rel=0.015)
        bpy.data.objects["ball"].data.materials[0] = owner
