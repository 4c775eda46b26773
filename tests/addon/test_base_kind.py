# SPDX-License-Identifier: GPL-3.0-or-later
"""A base that becomes one of another kind, or is described in another way: textures and animation that can stay do stay."""

import json

import pytest

bpy = pytest.importorskip("bpy")

from support.animation import at_frame, curves_of, driven, keyed, strip

from lamina.addon.check import check
from lamina.addon.material import layers, material
from lamina.addon.material.elements import kind_of, node_of
from lamina.addon.material.live_values import live_values
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.schema import SCHEMA
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

GOLD = {"kind": "conductor", "metal": "gold", "roughness": 0.3, "distribution": "beckmann", "anisotropy": 0.2, "normal": [0, 0, 0]}


def made(name: str, base: dict, backend: str = "nodes"):
    """A material on the active object, so that the scene evaluates it. Stock nodes are quick to make."""
    new = bpy.data.materials.new(name)
    material.apply_stack(new, Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.1}], "base": base}), "analytic", backend)
    item = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    item.data.materials.append(new)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return new


def base_inputs(owner):
    return node_of(owner.lamina.base).inputs


def texture_into(owner, label: str):
    noise = owner.node_tree.nodes.new("ShaderNodeTexNoise")
    owner.node_tree.links.new(noise.outputs["Color"], base_inputs(owner)[label])
    return noise


@pytest.mark.parametrize("kind", SCHEMA.bases)
def test_the_same_kind_again_changes_nothing(blender, kind):
    owner = made("owner", {"kind": kind} if kind != "conductor" else GOLD)
    given = owner.lamina.base.given
    for socket in base_inputs(owner):
        driven(socket, "frame / 100")
    node, count = owner.lamina.base.node, len(base_inputs(owner))
    assert bpy.ops.lamina.set_base(kind=kind) == {"FINISHED"}
    assert owner.lamina.base.node == node and len(curves_of(owner.node_tree)) >= count
    assert owner.lamina.base.given == given and (kind != "conductor" or owner.lamina.base.metal == "gold")


@pytest.mark.parametrize("there", SCHEMA.bases)
@pytest.mark.parametrize("here", SCHEMA.bases)
def test_what_both_kinds_have_stays_animated(blender, here, there):
    """Sockets of one name have different places in different kinds; keyframes and drivers follow the name."""
    shared = [p for p in SCHEMA.bases[here].sockets if p in SCHEMA.bases[there].sockets and p.type in ("float", "color")]
    owner = made("owner", {"kind": here})
    keyed_ones = {p.label: (base_inputs(owner)[p.label], p.type) for p in shared}
    for socket, kind in keyed_ones.values():
        keyed(socket, {1: 0.1, 11: 0.5}, index=0 if kind == "color" else -1)
    count = len(curves_of(owner.node_tree))
    bpy.ops.lamina.set_base(kind=there)
    assert len(curves_of(owner.node_tree)) == count
    for label, (_, kind) in keyed_ones.items():
        socket = base_inputs(owner)[label]
        assert at_frame(6, socket, 0 if kind == "color" else -1) == pytest.approx(0.3), label


def test_keyframes_drivers_and_strips_move_and_only_those_of_this_material(blender):
    owner = made("owner", {"kind": "lambert", "color": [0.1, 0.2, 0.3]})
    strip(owner.node_tree, lambda: keyed(base_inputs(owner)["Color"], {1: 0.0, 11: 1.0}, index=1))
    keyed(base_inputs(owner)["Color"], {1: 0.2, 11: 0.4}, index=0)
    driven(base_inputs(owner)["Normal"], "frame / 1000", 2)
    noise = texture_into(owner, "Normal")
    # a copy has nodes of the same names and may share the action, in a slot of its own
    copy = owner.copy()
    action = owner.node_tree.animation_data.action
    copy.node_tree.animation_data.action = action
    slot = action.slots.new("NODETREE", "copy")
    copy.node_tree.animation_data.action_slot = slot
    bag = action.layers[0].strips[0].channelbag(slot, ensure=True)
    bag.fcurves.new(base_inputs(copy)["Color"].path_from_id("default_value"), index=2)
    before = [(c.data_path, c.array_index) for c in bag.fcurves]
    bpy.ops.lamina.set_base(kind="oren_nayar")
    assert [(c.data_path, c.array_index) for c in bag.fcurves] == before
    color = base_inputs(owner)["Color"]
    assert [round(at_frame(6, color, i), 3) for i in (0, 1)] == [0.3, 0.5]
    assert base_inputs(owner)["Normal"].links[0].from_node == noise and owner.node_tree.animation_data.drivers[0].is_valid
    assert owner.node_tree.nodes[owner.lamina.base.node].inputs["Normal"].path_from_id("default_value") in {c for c, _ in curves_of(owner.node_tree)}


def test_features_choices_and_names_stay(blender):
    owner = made("owner", {**GOLD, "name": "Core", "note": 3})
    noise = texture_into(owner, "Normal")
    assert material.set_base(owner, "lambert")
    assert owner.lamina.base.use_normal and base_inputs(owner)["Normal"].links[0].from_node == noise
    assert owner.lamina.base.name == "Core" and material.stack_of(owner).base.unknown["note"] == 3
    assert material.set_base(owner, "oren_nayar") == []  # it has all that Lambert has


def test_what_is_lost_is_named(blender, capfd):
    owner = made("owner", GOLD)
    keyed(base_inputs(owner)["Anisotropy"], {1: 0.1, 11: 0.5})
    texture_into(owner, "Roughness")
    texture_into(owner, "Edge Color")  # it rests, as a metal's name gives the base
    lost = material.set_base(owner, "lambert")
    assert dict(lost) == {"Metal": "", "Roughness": "texture", "Distribution": "", "Anisotropy": "animation", "Rotation": "", "Edge Color": "texture"}
    owner = made("other", GOLD)
    texture_into(owner, "Roughness")
    bpy.ops.lamina.set_base(kind="lambert")
    assert "Lambert has no Roughness (texture), Metal, Distribution, Anisotropy, Rotation: that is gone" in capfd.readouterr().out


def test_a_change_that_fails_leaves_animation_as_it_was(blender, monkeypatch):
    owner = made("owner", {"kind": "lambert"})
    strip(owner.node_tree, lambda: keyed(base_inputs(owner)["Color"], {1: 0.0, 11: 1.0}, index=1))
    keyed(base_inputs(owner)["Color"], {1: 0.2, 11: 0.4}, index=0)
    before = curves_of(owner.node_tree)

    def fail(*_):
        raise RuntimeError("no")

    monkeypatch.setattr(material, "refresh", fail)
    with pytest.raises(RuntimeError):
        material.set_base(owner, "oren_nayar")
    assert curves_of(owner.node_tree) == before and kind_of(owner.lamina.base).name == "lambert"


def test_undo_gives_the_animation_back(blender):
    owner = made("owner", {"kind": "lambert"})
    keyed(base_inputs(owner)["Color"], {1: 0.2, 11: 0.4}, index=0)
    bpy.ops.ed.undo_push(message="before")
    before = curves_of(owner.node_tree)
    bpy.ops.lamina.set_base("EXEC_DEFAULT", True, kind="conductor")
    assert curves_of(bpy.data.materials["owner"].node_tree) == []
    bpy.ops.ed.undo()
    assert curves_of(bpy.data.materials["owner"].node_tree) == before


def test_a_texture_of_another_alternative_rests_and_comes_back(blender):
    """It hinders no bake, Check names it, and choosing its alternative again shows it."""
    owner = made("owner", GOLD)
    noise = texture_into(owner, "Reflectance")
    keyed(base_inputs(owner)["Edge Color"], {1: 0.1, 11: 0.5}, index=0)
    assert live_values(owner) == ()
    resting = [f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code == "value_rests"]
    assert [f.label for f in resting] == ["Reflectance", "Edge Color"] and "given by Metal" in resting[0].text()
    owner.lamina.base.given = "reflectance+edge_color"
    assert live_values(owner) == (Place(None, "reflectance"), Place(None, "edge_color"))
    assert base_inputs(owner)["Reflectance"].links[0].from_node == noise
    assert at_frame(6, base_inputs(owner)["Edge Color"], 0) == pytest.approx(0.3)


def test_mending_a_broken_group_keeps_the_animation_of_each_value(blender):
    owner = made("owner", GOLD)
    keyed(base_inputs(owner)["Roughness"], {1: 0.1, 11: 0.5})
    tree = node_of(owner.lamina.base).node_tree
    items = tree.interface.items_tree
    count = len(curves_of(owner.node_tree))
    tree.interface.remove(next(item for item in items if item.name == "IOR" and item.in_out == "INPUT"))
    # Blender 5.2 does this by itself
    curve = owner.node_tree.animation_data.action.layers[0].strips[0].channelbags[0].fcurves[0]
    curve.data_path = base_inputs(owner)["Roughness"].path_from_id("default_value")
    finding = next(f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code == "group_broken")
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert len(curves_of(owner.node_tree)) == count
    assert at_frame(6, base_inputs(owner)["Roughness"]) == pytest.approx(0.3)


def test_strips_of_a_layer_that_is_pasted_elsewhere_are_named(blender):
    owner, other = made("owner", GOLD), made("other", GOLD)
    socket = node_of(owner.lamina.layers[0]).inputs["Roughness"]
    strip(owner.node_tree, lambda: keyed(socket, {1: 0.0, 11: 1.0}))
    strip(owner.node_tree, lambda: keyed(socket, {1: 0.0, 11: 0.5}))
    assert layers.paste_layers(other, layers.copied_text(owner, [0]), 0) == ["Dielectric: its NLA strips stay behind"]
    assert json.loads(layers.copied_text(other, [0]))["lamina_layers"]


def test_another_preset_names_the_textures_and_animation_that_go(blender, capfd):
    owner = made("owner", {"kind": "lambert"})
    texture_into(owner, "Color")
    coat = node_of(owner.lamina.layers[0]).inputs
    keyed(coat["Roughness"], {1: 0.1, 11: 0.5})
    driven(coat["Thickness"], "frame")
    before = curves_of(owner.node_tree)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lamina.apply_preset("EXEC_DEFAULT", True, preset="worn_varnish")
    named = "Roughness of Dielectric (animation), Thickness of Dielectric (animation), Color of Lambert (texture): that is gone with the former layers"
    assert f"Warning: Lamina: {named}" in capfd.readouterr().out
    bpy.ops.ed.undo()
    owner = bpy.data.materials["owner"]
    assert curves_of(owner.node_tree) == before and base_inputs(owner)["Color"].is_linked


def test_values_and_masks_of_a_preset_go_without_a_word(blender, capfd):
    owner = made("owner", {"kind": "lambert"})
    for _ in range(2):
        bpy.ops.lamina.apply_preset(preset="worn_varnish")
    assert any(socket.is_linked for layer in owner.lamina.layers for socket in node_of(layer).inputs)
    assert "gone" not in capfd.readouterr().out
