# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel as an artist meets it: nothing moves under the mouse, rows at any width, plain words, notes beside values."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from support import translatable
from support.layouts import Recorder
from support.stacks import on_a_plane

from lamina.addon.blender.versions import node_tree
from lamina.addon.jobs import bakes, fitting
from lamina.addon.material import kind_groups, seen_color
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.mask_groups import BAKED, USE_BAKED
from lamina.addon.ui import panel, panel_feedback, panel_layers, swatch_icons, value_notes
from lamina.reference_py.material import presets, ready_layers
from lamina.reference_py.material.schema import COLOR, FLOAT, SCHEMA
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "name": "Coat", "ior": 1.5, "roughness": 0.3}, {"kind": "dielectric", "name": "Paint", "ior": 1.6}],
        "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3},
    }
)
DEFAULT_WIDTH = 213  # pixels of the Properties editor's region in a new file of Blender 5.2, 1280 and more wide
# What the field says and an artist need not.
FIELD = re.compile(r"\b(truths?|tiers?|analytic|baked|albedos?|lobes?|closures?|told)\b", re.IGNORECASE)


@pytest.fixture
def material(blender):
    return on_a_plane(blender, STACK)


def window(width: float):
    context = bpy.context
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0), addons=context.preferences.addons)
    return SimpleNamespace(
        scene=context.scene, object=context.object, region=SimpleNamespace(width=width), preferences=preferences, window_manager=context.window_manager
    )


def drawn(width: float = DEFAULT_WIDTH) -> Recorder:
    layout = Recorder()
    panel.LAMINA_PT_material.draw(SimpleNamespace(layout=layout, bl_label="Lamina"), window(width))
    return layout


def places(layout: Recorder) -> dict[str, int]:
    """The line at which each sub-panel, and the list, begins."""
    found, line = {}, 0
    for part in layout.parts:
        found |= {name: line for what, name in part.words if what in ("panel", "list")}
        line += part.height
        if not part.is_row:  # the body of the panel: its parts below each other
            inner = line - part.height
            for each in part.parts:
                found |= {name: inner for what, name in each.words if what in ("panel", "list")}
                inner += each.height
    return found


def _mute(material, _monkeypatch) -> None:
    for layer in material.lamina.layers:
        node_of(layer).mute = True


STATES = {
    "a layer is soloed": lambda material, _: setattr(material.lamina, "solo", material.lamina.layers[0].node),
    "three things are wrong": lambda material, patch: [
        _mute(material, patch),
        setattr(node_of(material.lamina.base).inputs["Roughness"], "default_value", 2.0),
    ],
    "a bake runs": lambda _, patch: patch.setattr(bakes, "bake_of", lambda _: SimpleNamespace(share=0.5)),
    "a fit runs": lambda _, patch: patch.setattr(fitting, "running", lambda: SimpleNamespace(share=0.5)),
    "a fit failed": lambda _, patch: patch.setattr(fitting, "last_summary", lambda _: "It did not fit. " * 20),
    "a problem": lambda material, _: setattr(material.lamina, "problem", "a long sentence of what went wrong " * 6),
    "no OSL": lambda material, _: setattr(material.lamina, "backend", "nodes"),
    "a texture": lambda material, _: material.node_tree.links.new(
        material.node_tree.nodes.new("ShaderNodeTexNoise").outputs[0], node_of(material.lamina.layers[0]).inputs["Roughness"]
    ),
}


@pytest.mark.parametrize("state", STATES)
def test_what_comes_and_goes_moves_nothing(material, monkeypatch, state):
    before = drawn()
    words = [word for word in before.words if word[0] in ("panel", "list", "operator_menu_enum")]
    STATES[state](material, monkeypatch)
    after = drawn()
    assert places(after) == places(before) and len(places(before)) == 5
    assert [word for word in after.words if word[0] in ("panel", "list", "operator_menu_enum")] == words
    assert after.height == before.height


def test_the_list_is_the_first_thing(material):
    assert [word for word in drawn().words if word[0] != "menu"][:3] == [("panel", "lamina"), ("label", "Lamina"), ("list", "LAMINA_UL_layers")]


def row_at(material, width: float) -> Recorder:
    row = Recorder(is_row=True)
    panel_layers.LAMINA_UL_layers.draw_item(None, window(width), row, material.lamina, material.lamina.layers[0], 0, None, "active_layer", 0)
    return row


def test_rows_drop_from_the_right_and_never_the_name(material):
    wide = [word for word in row_at(material, 600).words if word[1]]
    assert [name for _, name in wide] == [
        "name",
        "visible",
        "default_value",
        "8.0\N{DEGREE SIGN}",
        "\N{MULTIPLICATION SIGN}1",
        "lamina.layer_solo",
        "lamina.layer_drag",
    ]
    counts = []
    for width in range(60, 600, 10):
        words = [word for word in row_at(material, width).words if word[1]]
        assert words == wide[: len(words)] and words
        counts.append(len(words))
    assert counts == sorted(counts) and counts[0] == 1
    assert [name for _, name in row_at(material, DEFAULT_WIDTH).words] == ["name", "visible", "default_value"]


def test_plain_words_in_all_that_is_shown(material):
    # what a conversion measured or a fit found is told in the terms of its report, and a mask is baked as Blender says it
    shown = {*(translatable.strings() - translatable.of_reports() - {BAKED, USE_BAKED}), *(text for text in drawn().texts())}
    popover = Recorder()
    material.lamina.tier = "auto"
    _mute(material, None)
    panel_feedback.draw_findings(popover, window(DEFAULT_WIDTH), material)
    shown |= {*popover.texts(), *drawn().texts()}
    assert not [text for text in shown if FIELD.search(text)]
    assert {"Preview", "Final look", "Cost", "Quality"} <= shown


@pytest.mark.parametrize("kind", [*SCHEMA.layers.values(), *SCHEMA.bases.values()], ids=lambda kind: kind.label)
def test_every_slider_says_what_it_does_to_the_look(kind):
    for parameter in kind.all_parameters:
        assert parameter.look and parameter.look != parameter.help and len(parameter.look) < 110, parameter.name


def note(material, index: int, name: str):
    element = material.lamina.layers[index] if index >= 0 else material.lamina.base
    parameter = next(p for p in (SCHEMA.layers[element.kind] if index >= 0 else SCHEMA.bases[element.kind]).sockets if p.name == name)
    return value_notes.note_of(element, node_of(element), parameter)


def test_an_interface_that_vanishes_is_said_at_its_layer(material):
    assert note(material, 0, "ior") is note(material, 1, "ior") is None
    node_of(material.lamina.layers[1]).inputs["IOR"].default_value = 1.5
    assert note(material, 0, "ior") is None
    said = note(material, 1, "ior")
    assert said.is_warning and said.text.startswith("Coat above has the same IOR")
    assert said.text in drawn_of(material, 1).texts()
    material.lamina.layers[0].visible = False
    assert note(material, 1, "ior") is None
    node_of(material.lamina.layers[1]).inputs["IOR"].default_value = 1.0
    assert note(material, 1, "ior").text.startswith("Air above")


def drawn_of(material, index: int) -> Recorder:
    material.lamina.active_layer = index
    return drawn()


def test_notes_are_tooltips_and_lines_stay_where_they_are(material):
    assert note(material, -1, "roughness").text == "Mean slope 8.0\N{DEGREE SIGN}"  # tan(8.0 deg) = .3^2 pi/2
    before = drawn().height
    tree, node = material.node_tree, node_of(material.lamina.layers[0])
    ramp = tree.nodes.new("ShaderNodeValue")
    ramp.outputs[0].default_value = 0.25
    tree.links.new(ramp.outputs[0], node.inputs["Roughness"])
    bpy.ops.lamina.check()
    assert note(material, 0, "roughness").text == "Mean of Value: 0.25"
    assert drawn().height == before
    material.lamina.layers[0].use_thin_film = True
    assert note(material, 0, "film_thickness").text.startswith("In nanometers")


@pytest.mark.parametrize("kind", [*SCHEMA.layers.values(), *SCHEMA.bases.values()], ids=lambda kind: kind.label)
def test_sliders_end_where_looks_end_and_take_more(blender, kind):
    node = node_tree(blender.data.materials.new("one")).nodes.new("ShaderNodeGroup")
    node.node_tree = kind_groups.group_of(kind)
    ranges = {item.name: item for item in node.node_tree.interface.items_tree if item.in_out == "INPUT"}
    for parameter in kind.sockets:
        assert ranges[parameter.label].description == parameter.tooltip
        if parameter.type == COLOR:
            continue
        assert ranges[parameter.label].max_value == np.float32(parameter.slider_maximum) and parameter.slider_maximum <= parameter.maximum
        if parameter.type == FLOAT:
            node.inputs[parameter.label].default_value = parameter.maximum
            assert node.inputs[parameter.label].default_value == np.float32(parameter.maximum)


def test_a_group_of_an_older_file_gets_ranges_and_names_and_keeps_values(material, tmp_path):
    node = node_of(material.lamina.layers[0])
    for item in node.node_tree.interface.items_tree:
        if item.name == "Thickness" and item.in_out == "INPUT":
            item.max_value, item.description = 1000.0, "older"
        if item.name == "Scattered Share":
            item.name = "Scatter Albedo"
    node.inputs["Thickness"].default_value = 44.0
    node.inputs["Scatter Albedo"].default_value = (0.1, 0.2, 0.3, 1.0)
    source = material.node_tree.nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(source.outputs["Color"], node.inputs["Scatter Albedo"])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "older.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "older.blend"))
    material = bpy.data.materials["coated"]
    node = node_of(material.lamina.layers[0])
    thickness = next(i for i in node.node_tree.interface.items_tree if i.name == "Thickness" and i.in_out == "INPUT")
    assert thickness.max_value == 2.0 and thickness.description == SCHEMA.layers["dielectric"].parameter("thickness").tooltip
    assert node.inputs["Thickness"].default_value == 44.0
    assert tuple(node.inputs["Scattered Share"].default_value[:3]) == pytest.approx((0.1, 0.2, 0.3)) and node.inputs["Scattered Share"].is_linked
    assert materials.stack_of(material).layers[0]["thickness"] == 44.0


def test_color_as_seen_is_two_crossings_and_sets_the_tint(material):
    layer = material.lamina.layers[0]
    node = node_of(layer)
    node.inputs["Tint"].default_value, node.inputs["Thickness"].default_value = (0.25, 0.81, 1.0, 1.0), 0.5
    assert tuple(node.lamina_seen) == pytest.approx((0.25, 0.81, 1.0), rel=1e-6)
    node.inputs["Thickness"].default_value = 1.0
    assert tuple(node.lamina_seen) == pytest.approx((0.0625, 0.6561, 1.0), rel=1e-5)
    node.lamina_seen = (0.25, 0.5, 0.0)
    assert tuple(node.inputs["Tint"].default_value[:3]) == pytest.approx((0.5, 0.5**0.5, 0.0), rel=1e-6)
    assert "lamina_seen" in [name for _, name in drawn().words] and seen_color.is_settable(layer)
    node.inputs["Thickness"].default_value = 0.0
    assert not seen_color.is_settable(layer)
    node.inputs["Thickness"].default_value = 2.0
    for label in ("Tint", "Thickness"):
        link = material.node_tree.links.new(material.node_tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], node.inputs[label])
        assert not seen_color.is_settable(layer)
        material.node_tree.links.remove(link)
    node.inputs["Tint"].keyframe_insert("default_value", frame=1)
    assert not seen_color.is_settable(layer)


def test_every_ready_layer_is_offered_in_its_group_with_a_picture(blender, monkeypatch):
    pictures = {}
    monkeypatch.setattr(swatch_icons, "_icon", lambda look: pictures.setdefault(look, 1 + len(pictures)))
    menu = Recorder()
    panel_layers.LAMINA_MT_add_layer.draw(SimpleNamespace(layout=menu), None)
    assert [properties.ready for _, properties in menu.operators if hasattr(properties, "ready")] == [
        name for group in ready_layers.GROUPS for name in ready_layers.names() if ready_layers.group_of(name) == group
    ]
    assert [properties.kind for _, properties in menu.operators if hasattr(properties, "kind")] == list(SCHEMA.layers)
    assert all(properties.icon for _, properties in menu.operators) and len(pictures) > 15
    titles = [name for what, name in menu.words if what == "label"]
    assert titles == ["Plain", "Coats", "Glazes", "Metals", "Dirt", "Wear"]
    for title in titles[1:]:
        assert title.lower() in {ready_layers.group_of(name) for name in ready_layers.names()}


def test_a_new_material_is_a_base_and_takes_the_place_of_none(material):
    item, undone = bpy.context.object, material.name
    assert bpy.ops.lamina.new_material("EXEC_DEFAULT", True) == {"FINISHED"}
    made = item.active_material
    assert made != material and made.name == "Lamina Material" and len(made.lamina.layers) == 0 and made.lamina.is_layered
    assert len(material.lamina.layers) == 2 and len(item.material_slots) == 1
    assert bpy.ops.lamina.layer_add_ready(ready="dust") == {"FINISHED"} and [e.name for e in made.lamina.layers] == ["Dust"]
    bpy.ops.mesh.primitive_plane_add()
    layout = Recorder()
    panel.LAMINA_PT_material.draw(SimpleNamespace(layout=layout, bl_label="Lamina"), window(DEFAULT_WIDTH))
    assert "lamina.new_material" in [name for name, _ in layout.operators]
    assert bpy.ops.lamina.new_material() == {"FINISHED"} and bpy.context.object.active_material.name == "Lamina Material.001"
    assert undone in bpy.data.materials


@pytest.mark.parametrize("name", presets.names())
def test_layers_of_presets_have_names_of_their_own(name):
    labels = {kind.label for kind in SCHEMA.layers.values()}
    names = [layer.unknown.get("name") for layer in presets.load(name).layers]
    assert all(names) and not labels & set(names) and len(set(names)) == len(names)


def test_the_buttons_of_a_mask_stand_above_what_it_unfolds(material):
    """Blender draws the nodes that feed a value below it, as many lines as they take."""
    material.lamina.layers[0].use_coverage = True
    bpy.ops.lamina.mask_image(size="512")
    bpy.ops.lamina.mask_ramp()
    words = drawn().words
    assert words.index(("menu", "LAMINA_MT_mask")) + 2 == words.index(("socket", "Coverage"))
    assert words[words.index(("socket", "Coverage")) - 1] == ("operator", "lamina.mask_paint")


def test_preferences_have_the_manual_and_what_is_kept(material, tmp_path, monkeypatch):
    from lamina.addon.ui import preferences

    monkeypatch.setenv("LAMINA_CACHE", str(tmp_path / "bakes"))
    monkeypatch.setenv("LAMINA_PRESETS", str(tmp_path / "none"))
    (tmp_path / "bakes").mkdir()
    (tmp_path / "bakes" / ("0" * 64 + ".json")).write_bytes(b" " * 2_500_000)
    monkeypatch.setattr(preferences, "_known", (-preferences._KNOWN_FOR, 0.0))
    layout = Recorder()
    preferences.draw_preferences(layout, SimpleNamespace())
    assert "New Materials" in layout.texts()
    assert "Final looks that are kept: 2.5 MB" in layout.texts() and f"Own presets: {tmp_path / 'none'}" in layout.texts()
    manual = dict(layout.operators)["wm.url_open"].url
    assert manual.startswith("file://") and manual.endswith("/manual/index.html")
    assert bpy.ops.lamina.clear_cache("EXEC_DEFAULT") == {"FINISHED"}
    assert list((tmp_path / "bakes").iterdir()) == []
