# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that are duplicated, copied between materials, soloed and named: what belongs to them comes along."""

import json
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from support.layouts import Recorder

from lamina.addon.material import layers, material
from lamina.addon.material.elements import node_of
from lamina.addon.operators import layer_operators
from lamina.addon.operators.layer_operators import LAMINA_OT_layer_drag, LAMINA_OT_layer_move, carried_in
from lamina.addon.ui import keys, panel_layers
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets, ready_layers
from lamina.reference_py.material.schema import SCATTERING
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "name": "Coat", "roughness": 0.1}, {"kind": "dielectric", "name": "Paint", "roughness": 0.5}],
        "base": {"kind": "lambert"},
    }
)


def made(name: str, stack: Stack = STACK, tier: str = "analytic"):
    """A material on an object of its own, so that the scene evaluates it. Stock nodes are quick to make."""
    new = bpy.data.materials.new(name)
    material.apply_stack(new, stack, tier, "nodes")
    item = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    item.data.materials.append(new)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return new


def dress(layer):
    """A texture, a driver and keyframes on a layer. Returns the texture's ramp."""
    node, tree = node_of(layer), layer.id_data.node_tree
    noise, ramp = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeValToRGB")
    noise.inputs["Scale"].default_value = 7.0
    noise.noise_dimensions = "2D"
    ramp.color_ramp.elements.new(0.25).color = (1.0, 0.0, 0.0, 1.0)
    ramp.color_ramp.interpolation = "CONSTANT"
    tree.links.new(noise.outputs[0], ramp.inputs["Fac"] if "Fac" in ramp.inputs else ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], node.inputs["Tint"])
    noise.inputs["Scale"].keyframe_insert("default_value", frame=3)
    node.inputs["IOR"].driver_add("default_value").driver.expression = "1 + frame / 100"
    for frame, value in ((1, 0.0), (11, 1.0)):
        node.inputs["Roughness"].default_value = value
        node.inputs["Roughness"].keyframe_insert("default_value", frame=frame)
    return ramp


def at(frame: int, owner, index: int) -> tuple[float, float]:
    """IOR and roughness of a layer at a frame."""
    bpy.context.scene.frame_set(frame)
    inputs = node_of(owner.lamina.layers[index]).inputs
    return inputs["IOR"].default_value, inputs["Roughness"].default_value


def test_a_duplicate_has_everything_and_is_independent(blender):
    owner = made("owner")
    ramp = dress(owner.lamina.layers[1])
    layers.duplicate_layer(owner, 1)
    assert [e.name for e in owner.lamina.layers] == ["Coat", "Paint 2", "Paint"] and owner.lamina.active_layer == 1
    twin = node_of(owner.lamina.layers[1])
    assert twin.inputs["Tint"].links[0].from_node == ramp
    assert at(6, owner, 1) == pytest.approx((1.06, 0.5)) == at(6, owner, 2)
    layers.remove_layer(owner, 1)
    assert at(11, owner, 1) == pytest.approx((1.11, 1.0))
    assert len(owner.node_tree.animation_data.drivers) == 1


def test_pasting_into_another_material_copies_the_textures(blender):
    owner, other = made("owner"), made("other")
    ramp = dress(owner.lamina.layers[0])
    assert layers.paste_layers(other, layers.copied_text(owner, [0, 1]), 1) == []
    assert [e.name for e in other.lamina.layers] == ["Coat", "Coat 2", "Paint 2", "Paint"]
    copy = node_of(other.lamina.layers[1]).inputs["Tint"].links[0].from_node
    assert copy != ramp and copy.id_data == other.node_tree and copy.color_ramp.interpolation == "CONSTANT"
    assert [(e.position, tuple(e.color)) for e in copy.color_ramp.elements] == [(e.position, tuple(e.color)) for e in ramp.color_ramp.elements]
    noise = copy.inputs[0].links[0].from_node
    assert noise.inputs["Scale"].default_value == 7.0 and noise.noise_dimensions == "2D"
    assert at(6, other, 1) == pytest.approx((1.06, 0.5))
    paths = {curve.data_path for strip in other.node_tree.animation_data.action.layers[0].strips for bag in strip.channelbags for curve in bag.fcurves}
    assert noise.inputs["Scale"].path_from_id("default_value") in paths
    owner.node_tree.nodes.remove(ramp)
    assert other.node_tree.nodes[copy.name].inputs[0].is_linked


def test_a_copy_from_another_file_brings_values(blender):
    owner = made("owner")
    dress(owner.lamina.layers[0])
    text = layers.copied_text(owner, [0])
    bpy.data.materials.remove(owner)
    other = made("other")
    assert layers.paste_layers(other, text, 0) == []
    first = node_of(other.lamina.layers[0])
    assert not first.inputs["Tint"].is_linked and other.lamina.layers[0].name == "Coat 2"
    assert material.stack_of(other).layers[0]["roughness"] == json.loads(text)["lamina_layers"][0]["roughness"]
    assert "from" not in material.stack_of(other).layers[0].unknown


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        "not json",
        '{"lamina_layers": 3}',
        '{"lamina_layers": [{"kind": "no"}]}',
        '{"schema_version": 99, "lamina_layers": [{"kind": "dielectric"}]}',
    ],
)
def test_pasting_what_is_no_layer_changes_nothing(blender, text):
    owner = made("owner")
    before = [n.name for n in owner.node_tree.nodes], material.stack_of(owner)
    with pytest.raises(LaminaError, match="no layers were copied|unknown layer kind 'no'|newer than this Lamina"):
        layers.paste_layers(owner, text, 0)
    assert before == ([n.name for n in owner.node_tree.nodes], material.stack_of(owner))


def test_solo_shows_one_layer_and_gives_all_back(blender):
    owner = made("owner")
    owner.lamina.layers[0].visible = False
    stack = material.stack_of(owner)
    layers.solo_layer(owner, 0)
    assert [e.unknown["name"] for e in material.stack_of(owner).layers] == ["Coat"]
    assert node_of(owner.lamina.layers[1]).mute and not node_of(owner.lamina.layers[0]).mute
    layers.solo_layer(owner, 1)
    assert material.stack_of(owner) == stack and owner.lamina.solo
    layers.solo_layer(owner, 1)
    assert material.stack_of(owner) == stack and not owner.lamina.solo and not owner.lamina.layers[0].visible
    layers.solo_layer(owner, 0)
    layers.remove_layer(owner, 0)
    assert not owner.lamina.solo and material.stack_of(owner) == stack


def test_default_names_tell_layers_apart_and_are_not_written(blender):
    plain = Stack.from_dict({"layers": [{"kind": "dielectric"}, {"kind": "dielectric", "roughness": 0.2}], "base": {"kind": "lambert"}})
    owner = made("owner", plain)
    layers.add_layer(owner, "dielectric", 2)
    assert [e.name for e in owner.lamina.layers] == ["Dielectric", "Dielectric 2", "Dielectric 3"]
    assert all("name" not in layer.unknown for layer in material.stack_of(owner).layers)
    layers.remove_layer(owner, 2)
    assert material.stack_of(owner) == plain


@pytest.mark.parametrize("name", ready_layers.names())
def test_a_ready_layer_goes_on_every_preset(blender, name):
    label, source, added = ready_layers.load(name)
    assert len(source) > 20 and label == ready_layers.load(name)[0]
    owner = made("owner", tier="auto" if any(layer.has(SCATTERING) for layer in added) else "analytic")  # bakes alone know cloudy media
    layers.add_layers(owner, added, 0)
    layers.add_layers(owner, added, 0)
    names = [e.name for e in owner.lamina.layers]
    assert len(set(names)) == len(names) == 2 + 2 * len(added)
    assert names[len(added)] == added[0].unknown["name"] == names[0].removesuffix(" 2")
    for layer, wanted in zip(material.stack_of(owner).layers, added):
        # of what a mask gives, the mask is what it was, and the value its mean
        assert {k: v for k, v in layer.values.items() if k not in wanted.masks} == {k: v for k, v in wanted.values.items() if k not in wanted.masks}
        assert layer.masks == wanted.masks


def test_a_material_is_named_for_its_preset_until_it_has_a_name_of_its_own(blender):
    owner = made("plain")
    first, second = presets.names()[:2]
    with blender.context.temp_override(material=owner):
        bpy.ops.lamina.apply_preset(preset=first)
        assert owner.name == "plain"
        owner.name = presets.load(first).name
        bpy.ops.lamina.apply_preset(preset=second)
        assert owner.name == presets.load(second).name
        other = owner.copy()
        with blender.context.temp_override(material=other):
            bpy.ops.lamina.apply_preset(preset=first)
        assert other.name == presets.load(first).name and owner.name == presets.load(second).name


def test_a_layer_is_carried_by_rows_of_the_list(blender):
    """Past the last layer and past the first it stays at the end; the material follows when it is dropped, and not before."""
    owner = made("owner")
    layers.add_layer(owner, "dielectric", 0)
    window = SimpleNamespace(
        preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
        area=None,
        material=owner,
        window=SimpleNamespace(cursor_modal_set=lambda _: None, cursor_modal_restore=lambda: None),
        workspace=SimpleNamespace(status_text_set=lambda _: None),
        window_manager=SimpleNamespace(modal_handler_add=lambda _: None),
    )
    carried = SimpleNamespace(index=0, report=None, require_row=lambda _: None)
    carried.cancel = lambda context: LAMINA_OT_layer_drag.cancel(carried, context)
    carried._drop = lambda *arguments: LAMINA_OT_layer_drag._drop(carried, *arguments)
    LAMINA_OT_layer_drag.invoke(carried, window, SimpleNamespace(mouse_y=500))
    for mouse_y, to in ((495, 0), (482, 1), (300, 2), (462, 2), (505, 0), (900, 0), (455, 2)):
        LAMINA_OT_layer_drag.modal(carried, window, SimpleNamespace(type="MOUSEMOVE", value="NOTHING", mouse_y=mouse_y))
        assert carried_in(owner) == (0, to)
        assert "".join(layer.name[0] for layer in owner.lamina.layers) == "DCP"
    assert LAMINA_OT_layer_drag.modal(carried, window, SimpleNamespace(type="LEFTMOUSE", value="PRESS")) == {"FINISHED"}
    assert "".join(layer.name[0] for layer in owner.lamina.layers) == "CPD" and owner.lamina.active_layer == 2 and carried_in(owner) is None


def test_a_bar_is_where_a_carried_layer_would_be_dropped(blender, monkeypatch):
    owner = made("owner")
    context = SimpleNamespace(region=SimpleNamespace(width=400), preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)))

    def drawn(index: int) -> list[str]:
        """The bars of a row, which has as many parts with one as without."""
        layout = Recorder()
        panel_layers.LAMINA_UL_layers.draw_item(None, context, layout, owner.lamina, owner.lamina.layers[index], 0, None, "active_layer", index)
        parts.add(len(layout.words))
        return [icon for icon in layout.icons if "BAR" in icon]

    parts: set[int] = set()
    assert drawn(0) == drawn(1) == []
    monkeypatch.setitem(layer_operators._carried, owner.name_full, (1, 0))
    assert drawn(0) == ["TRIA_UP_BAR"] and drawn(1) == []
    monkeypatch.setitem(layer_operators._carried, owner.name_full, (0, 1))
    assert drawn(0) == [] and drawn(1) == ["TRIA_DOWN_BAR"] and len(parts) == 1


def test_who_carries_a_layer_is_told_how_to_drop_it(blender):
    owner, said = made("owner"), []
    window = SimpleNamespace(cursor_modal_set=lambda shape: said.append(shape), cursor_modal_restore=lambda: said.append("restored"))
    context = SimpleNamespace(
        material=owner,
        window=window,
        workspace=SimpleNamespace(status_text_set=lambda text: said.append(text)),
        area=None,
        window_manager=SimpleNamespace(modal_handler_add=lambda _: None),
    )
    carried = SimpleNamespace(index=1, require_row=lambda _: None, report=None)
    carried.cancel = lambda context: LAMINA_OT_layer_drag.cancel(carried, context)
    carried._drop = lambda *arguments: LAMINA_OT_layer_drag._drop(carried, *arguments)
    assert LAMINA_OT_layer_drag.invoke(carried, context, SimpleNamespace(mouse_y=0)) == {"RUNNING_MODAL"}
    assert said[0] == "SCROLL_Y" and owner.lamina.layers[1].name in said[1] and "Escape" in said[1]
    for event in ({"type": "ESC", "value": "PRESS"}, {"type": "LEFTMOUSE", "value": "PRESS"}):
        LAMINA_OT_layer_drag.invoke(carried, context, SimpleNamespace(mouse_y=0))
        said.clear()
        assert LAMINA_OT_layer_drag.modal(carried, context, SimpleNamespace(**event)) == {"CANCELLED"}
        assert said == ["restored", None]


def test_ctrl_and_arrows_move_the_selected_layer(blender, monkeypatch):
    items = []

    class Items(list):
        def new(self, operator, key, value, ctrl):
            self.append(SimpleNamespace(operator=operator, key=key, value=value, ctrl=ctrl, properties=SimpleNamespace()))
            return self[-1]

    keymap = SimpleNamespace(keymap_items=Items())
    config = SimpleNamespace(keymaps=SimpleNamespace(new=lambda name, space_type: items.append((name, space_type)) or keymap))
    monkeypatch.setattr(keys, "bpy", SimpleNamespace(context=SimpleNamespace(window_manager=SimpleNamespace(keyconfigs=SimpleNamespace(addon=config)))))
    keys.register()
    assert items == [("Property Editor", "PROPERTIES")]
    assert [(i.operator, i.key, i.ctrl, i.properties.direction) for i in keymap.keymap_items] == [
        ("lamina.layer_move", "UP_ARROW", True, "UP"),
        ("lamina.layer_move", "DOWN_ARROW", True, "DOWN"),
    ]
    keys.unregister()
    assert not keymap.keymap_items
    for tab, is_allowed in (("MATERIAL", True), ("MODIFIER", False)):
        space = SimpleNamespace(type="PROPERTIES", context=tab)
        owner = made(tab)
        assert LAMINA_OT_layer_move.poll(SimpleNamespace(space_data=space, material=owner)) is is_allowed
