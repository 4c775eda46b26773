# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in a material: read back as written, animated where it was animated, changed wholly or not at all."""

import hashlib
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

pytest.importorskip("bpy")

from support.stacks import assert_same

from lamina.addon.blender import environment
from lamina.addon.blender.versions import node_tree
from lamina.addon.material import elements, kind_groups, layers, material, properties, script_node
from lamina.addon.material.hand_over import VALUES
from lamina.addon.material.principled_node import PRINCIPLED
from lamina.addon.material.roles import (
    ROLE,
    node_with,
)
from lamina.addon.material.shader_node import shader_of, surface_of
from lamina.addon.material.state import is_stale
from lamina.addon.rendering.measure import render_furnace
from lamina.addon.shader.inputs import PRIMARIES
from lamina.addon.shader.osl.generate import generate
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import CHOICE, COVERAGE, DIELECTRIC, FLOAT, SCHEMA, Parameter
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding.adding_model import Adding
from lamina.reference_py.optics.colour import artist_index, conductor_rgb
from lamina.study.suite import suite_stack

pytestmark = pytest.mark.blender

TWO_LAYERS = {
    "name": "Two",
    "layers": [
        {"kind": "dielectric", "name": "Coat", "roughness": 0.1},
        {"kind": "dielectric", "name": "Paint", "roughness": 0.6, "distribution": "beckmann", "tint": [0.9, 0.2, 0.1]},
    ],
    "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3},
}


@pytest.fixture
def layered(blender):
    """A material with two layers over gold, on an object, so that the scene evaluates it."""
    mesh = blender.data.meshes.new("mesh")
    item = blender.data.objects.new("object", mesh)
    blender.context.collection.objects.link(item)
    mesh.materials.append(blender.data.materials.new("layered"))
    material.apply_stack(mesh.materials[0], Stack.from_dict(TWO_LAYERS))
    return mesh.materials[0]


def socket(owner, layer, label):
    return owner.node_tree.nodes[layer.node].inputs[label]


def script(owner):
    return shader_of(owner)


def state(owner) -> dict:
    """All that Lamina made in a material, as plain data."""
    tree = owner.node_tree
    lamina = owner.lamina
    return {
        "stack": material.stack_of(owner, hidden=True).to_dict() if lamina.is_layered else None,
        "visible": [(e.node, e.visible) for e in lamina.layers],
        "active": lamina.active_layer,
        "nodes": sorted(n.name for n in tree.nodes),
        "links": sorted((k.from_node.name, k.from_socket.name, k.to_node.name, k.to_socket.name) for k in tree.links),
        "text": script(owner).script.as_string() if lamina.is_layered else None,
    }


def layer_wired_to(owner, osl_name: str) -> str:
    """Name of the layer whose node feeds a shader input."""
    (link,) = script(owner).inputs[osl_name].links
    return link.from_node.label


@pytest.mark.parametrize("name", presets.names())
def test_preset_reads_back_as_written(blender, name):
    stack = presets.load(name)
    new = blender.data.materials.new("new")
    material.apply_stack(new, stack)
    assert_same(material.stack_of(new), stack)
    output = new.node_tree.get_output_node("CYCLES")
    assert output.inputs["Surface"].links[0].from_socket == surface_of(new)
    assert [n[ROLE] for n in new.node_tree.nodes if n.bl_idname == PRINCIPLED] == [VALUES]
    assert {s.name for s in script(new).inputs if not s.is_linked} == set(PRIMARIES)


@pytest.mark.parametrize(
    "base",
    [
        {"kind": "lambert", "color": [0.1, 0.2, 0.3]},
        {"kind": "oren_nayar", "sigma_deg": 33.0},
        {"kind": "conductor", "eta": [0.2, 0.9, 1.1], "k": [3.0, 2.0, 1.0], "distribution": "beckmann"},
        {"kind": "conductor", "reflectance": [0.9, 0.5, 0.25], "edge_color": [1.0, 0.5, 0.0], "note": {"of": ["tomorrow"]}},
    ],
)
def test_every_base_and_unknown_keys_read_back(blender, base):
    stack = Stack.from_dict({"base": base, "author": {"a": [1, None]}, "layers": [{"kind": "dielectric", "name": 5, "x": True}]})
    new = blender.data.materials.new("new")
    material.apply_stack(new, stack)
    read = material.stack_of(new)
    assert read.base == stack.base and read.unknown == stack.unknown
    assert read.layers[0].values == stack.layers[0].values and read.layers[0].unknown["x"] is True


def test_applying_again_leaves_nothing_of_the_former_stack(layered, blender):
    material.apply_stack(layered, presets.load(presets.names()[0]))
    once = len(layered.node_tree.nodes), len(blender.data.texts)
    material.apply_stack(layered, presets.load(presets.names()[0]))
    assert (len(layered.node_tree.nodes), len(blender.data.texts)) == once == (len(layered.lamina.layers) + 12, 1)


def test_add_remove_move_hide(layered):
    layers.add_layer(layered, "dielectric", 0)
    assert [e.name for e in layered.lamina.layers] == ["Dielectric", "Coat", "Paint"]
    assert layered.lamina.active_layer == 0
    assert layer_wired_to(layered, "Layer2Roughness") == "Coat"
    layers.move_layer(layered, 0, 2)
    assert [e.name for e in layered.lamina.layers] == ["Coat", "Paint", "Dielectric"]
    assert layer_wired_to(layered, "Layer3Roughness") == "Dielectric"
    assert [round(layer["roughness"], 6) for layer in material.stack_of(layered).layers] == [0.1, 0.6, 0.0]
    gone = layered.lamina.layers[0].node
    layers.remove_layer(layered, 0)
    assert gone not in layered.node_tree.nodes
    assert layer_wired_to(layered, "Layer1Roughness") == "Paint"
    layered.lamina.layers[0].visible = False
    assert layered.node_tree.nodes[layered.lamina.layers[0].node].mute
    assert len(material.stack_of(layered).layers) == 1
    assert len(material.stack_of(layered, hidden=True).layers) == 2
    assert layer_wired_to(layered, "Layer1Roughness") == "Dielectric"
    layered.lamina.layers[0].visible = True
    assert material.stack_of(layered).layers[0]["roughness"] == 0.6
    assert layer_wired_to(layered, "Layer1Roughness") == "Paint"


def test_last_layer_can_go(layered):
    layers.remove_layer(layered, 1)
    layers.remove_layer(layered, 0)
    assert material.stack_of(layered).layers == ()
    assert layered.lamina.lobe_count == 1
    layers.add_layer(layered, "dielectric", 0)
    assert layered.lamina.lobe_count == 2


def test_keyframes_and_drivers_stay_with_their_layer(layered, blender):
    coat, paint = layered.lamina.layers
    for frame, value in ((1, 0.0), (11, 1.0)):
        socket(layered, paint, "Roughness").default_value = value
        socket(layered, paint, "Roughness").keyframe_insert("default_value", frame=frame)
    socket(layered, coat, "IOR").driver_add("default_value").driver.expression = "1 + frame / 100"
    layers.move_layer(layered, 1, 0)
    layers.add_layer(layered, "dielectric", 1)
    blender.context.scene.frame_set(6)
    stack = material.stack_of(layered)
    assert [layer.unknown.get("name") for layer in stack.layers] == ["Paint", None, "Coat"]
    assert [layer["roughness"] for layer in stack.layers] == pytest.approx([0.5, 0.0, 0.1])
    assert [layer["ior"] for layer in stack.layers] == pytest.approx([1.5, 1.5, 1.06])
    # what animates a removed layer goes with it, and nothing else
    layers.remove_layer(layered, 0)
    assert [d.data_path for d in layered.node_tree.animation_data.drivers] == [socket(layered, layered.lamina.layers[1], "IOR").path_from_id("default_value")]


def test_structure_cannot_be_animated(layered):
    for name in ("visible", "distribution"):
        with pytest.raises(TypeError, match="not animatable"):
            layered.lamina.layers[0].keyframe_insert(name)


def test_a_value_does_not_make_the_shader_again(layered, blender):
    before = script(layered).as_pointer(), script(layered).script.name, script(layered).bytecode_hash
    socket(layered, layered.lamina.layers[0], "Roughness").default_value = 0.7
    socket(layered, layered.lamina.base, "Roughness").default_value = 0.9
    assert material.stack_of(layered).layers[0]["roughness"] == 0.7
    assert (script(layered).as_pointer(), script(layered).script.name, script(layered).bytecode_hash) == before
    assert len(blender.data.texts) == 1


def test_a_choice_makes_the_shader_again_and_drops_the_former_text(layered, blender):
    former = script(layered).script.name
    layered.lamina.layers[0].distribution = "beckmann"
    assert script(layered).script.name != former
    assert [t.name for t in blender.data.texts] == [script(layered).script.name]
    assert material.stack_of(layered).layers[0]["distribution"] == "beckmann"


def test_metal_goes_into_sockets_and_a_changed_index_is_that_metal_no_more(layered):
    base = layered.lamina.base
    base.metal = "copper"
    assert list(socket(layered, base, "IOR").default_value) == pytest.approx(conductor_rgb("copper")[0])
    assert material.stack_of(layered).base["metal"] == "copper"
    socket(layered, base, "Extinction").default_value[1] = 7.0
    read = material.stack_of(layered).base
    assert "metal" not in read and read["k"][1] == 7.0
    base.distribution = "beckmann"
    assert material.stack_of(layered).base["k"] == read["k"]


def test_ways_to_give_a_metal_start_from_each_other(layered):
    base = layered.lamina.base
    base.given = "reflectance+edge_color"
    read = material.stack_of(layered).base
    n, k = artist_index(read["reflectance"], read["edge_color"])
    for value, of_gold in zip((n, k), conductor_rgb("gold")):  # float32 sockets: n of red hangs on 1 - r
        assert value == pytest.approx(of_gold, rel=1e-3)
    base.distribution = "beckmann"
    assert material.stack_of(layered).base["reflectance"] == read["reflectance"]
    socket(layered, base, "Reflectance").default_value = (0.25, 0.25, 0.25, 1.0)
    socket(layered, base, "Edge Color").default_value = (1.0, 1.0, 1.0, 1.0)
    base.given = "eta+k"
    assert material.stack_of(layered).base["eta"] == pytest.approx((0.6, 0.6, 0.6))  # (1 - r) / (1 + r)


def test_base_kind_keeps_what_both_have_and_its_texture(layered):
    tree = layered.node_tree
    material.set_base(layered, "lambert")
    socket(layered, layered.lamina.base, "Color").default_value = (0.1, 0.2, 0.3, 1.0)
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], socket(layered, layered.lamina.base, "Color"))
    material.set_base(layered, "oren_nayar")
    assert tuple(socket(layered, layered.lamina.base, "Color").default_value) == pytest.approx((0.1, 0.2, 0.3, 1.0))
    assert material.stack_of(layered).base["color"] == pytest.approx((0.5, 0.5, 0.5), abs=0.02), "what is linked counts with its mean"
    assert socket(layered, layered.lamina.base, "Color").links[0].from_node == noise
    with pytest.raises(LaminaError, match="unknown base kind 'gld'; choose lambert"):
        material.set_base(layered, "gld")


def test_copy_is_independent(layered):
    other = layered.copy()
    before = state(layered)
    layers.remove_layer(other, 0)
    socket(other, other.lamina.layers[0], "Roughness").default_value = 0.9
    other.lamina.base.distribution = "beckmann"
    assert state(layered) == before
    assert material.stack_of(other).layers[0]["roughness"] == 0.9


def test_what_the_user_wired_around_the_shader_stays(layered):
    tree = layered.node_tree
    mix = tree.nodes.new("ShaderNodeMixShader")
    output = tree.get_output_node("CYCLES")
    tree.links.new(surface_of(layered), mix.inputs[1])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    layers.add_layer(layered, "dielectric", 0)
    material.apply_stack(layered, presets.load(presets.names()[0]))
    assert output.inputs["Surface"].links[0].from_node == mix
    assert mix.inputs[1].links[0].from_socket == surface_of(layered)


def test_a_text_edited_by_hand_is_neither_used_nor_removed(layered, blender):
    script(layered).script.write("// mine\n")
    mine = script(layered).script.name
    material.regenerate(layered)
    assert script(layered).script.name != mine
    assert mine in blender.data.texts
    material.regenerate(layered)
    assert len(blender.data.texts) == 2


def test_deleted_nodes(layered):
    layered.node_tree.nodes.remove(script(layered))
    material.regenerate(layered)
    assert layer_wired_to(layered, "Layer1Roughness") == "Coat"
    layered.node_tree.nodes.remove(layered.node_tree.nodes[layered.lamina.layers[0].node])
    with pytest.raises(LaminaError, match="node of 'Coat' was deleted"):
        material.stack_of(layered)
    layers.remove_layer(layered, 0)
    assert [layer.unknown["name"] for layer in material.stack_of(layered).layers] == ["Paint"]


def broken_shader(lobe_set):
    good = generate(lobe_set)
    body = good.text.replace("BSDF = ", "BSDF = no_such_function() + ").replace(good.name, "@SHADER@")
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return replace(good, name=name, text=body.replace("@SHADER@", name))


CHANGES = {
    "apply": lambda owner: material.apply_stack(owner, presets.load(presets.names()[0])),
    "add": lambda owner: layers.add_layer(owner, "dielectric", 1),
    "remove": lambda owner: layers.remove_layer(owner, 0),
    "move": lambda owner: layers.move_layer(owner, 0, 1),
    "base": lambda owner: material.set_base(owner, "lambert"),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_shader_that_does_not_compile_changes_nothing(layered, blender, monkeypatch, capfd, change):
    before = state(layered)
    monkeypatch.setattr(material, "generate", broken_shader)
    with pytest.raises(LaminaError, match="did not compile"):
        change(layered)
    assert state(layered) == before
    assert len(blender.data.texts) == 1


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_backend_osl_without_osl_changes_nothing(layered, monkeypatch, change):
    layered.lamina.backend = "osl"
    before = state(layered)
    monkeypatch.setattr(environment, "osl_available", lambda: (False, "this Blender was built without OSL"))
    with pytest.raises(LaminaError, match="backend osl needs Cycles with OSL, and this Blender was built without OSL"):
        change(layered)
    assert state(layered) == before


def test_a_choice_that_fails_is_kept_with_the_reason(layered, monkeypatch, capfd):
    text = script(layered).script.name
    with monkeypatch.context() as patch:
        patch.setattr(material, "generate", broken_shader)
        layered.lamina.layers[0].distribution = "beckmann"
    assert "did not compile" in layered.lamina.problem
    assert script(layered).script.name == text
    material.regenerate(layered)
    assert layered.lamina.problem == layered.lamina.packed_problem == "" and script(layered).script.name != text


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_linked_material_is_not_touched(layered, blender, tmp_path, change):
    path = str(tmp_path / "library.blend")
    blender.data.libraries.write(path, {layered}, fake_user=True)
    blender.ops.wm.read_factory_settings(use_empty=True)
    with blender.data.libraries.load(path, link=True) as (_, wanted):
        wanted.materials = ["layered"]
    linked = blender.data.materials["layered"]
    # from Blender 5.3 on a linked material that nothing uses cannot be overridden
    user = blender.data.objects.new("user", blender.data.meshes.new("user"))
    user.data.materials.append(linked)
    blender.context.scene.collection.objects.link(user)
    before = state(linked)
    with pytest.raises(LaminaError, match=r"material layered is linked from .*library\.blend; make it local"):
        change(linked)
    assert state(linked) == before
    override = linked.override_create()
    with pytest.raises(LaminaError, match="is a library override"):
        change(override)


def test_unlayered_material_has_a_clear_message(blender):
    new = blender.data.materials.new("plain")
    for call in (material.stack_of, material.regenerate, lambda m: layers.add_layer(m, "dielectric", 0)):
        with pytest.raises(LaminaError, match="material plain has no Lamina stack; pick a preset first"):
            call(new)
    with pytest.raises(LaminaError, match="unknown quality 'best'; choose weidlich_wilkie"):
        material.apply_stack(new, Stack.from_dict(TWO_LAYERS), "best")
    assert not new.lamina.is_layered


def test_socket_out_of_range_is_named(layered):
    # Blender keeps the interface's range in the panel, but not from Python, drivers or old files
    socket(layered, layered.lamina.base, "Roughness").default_value = 1.5
    with pytest.raises(LaminaError, match="material layered: base: roughness is 1.5; choose 0 to 1"):
        material.stack_of(layered)


def test_a_parameter_added_to_the_schema_appears_everywhere(blender):
    haze = Parameter("surface_haze", FLOAT, 0.25, "Haze", "Made up for this test", maximum=2.0)
    finish = Parameter("finish", CHOICE, "matte", "Finish", "Made up for this test", choices=("matte", "satin"))
    kind_groups.group_of(DIELECTRIC)  # an older file's group gets the new socket at its end
    kind = replace(DIELECTRIC, parameters=(*DIELECTRIC.parameters, haze, finish))
    schema = replace(SCHEMA, layers=MappingProxyType({**SCHEMA.layers, kind.name: kind}))

    stack = Stack.from_dict({"layers": [{"kind": "dielectric"}], "base": {"kind": "lambert"}}, schema=schema)
    assert (stack.layers[0]["surface_haze"], stack.layers[0]["finish"]) == (0.25, "matte")
    assert stack.to_dict()["layers"][0]["surface_haze"] == 0.25
    with pytest.raises(LaminaError, match="surface_haze is 3; choose 0 to 2"):
        Stack.from_dict({"layers": [{"kind": "dielectric", "surface_haze": 3.0}], "base": {"kind": "lambert"}}, schema=schema)

    added = set(properties.structure_annotations(schema)) - set(properties.structure_annotations(SCHEMA))
    assert added == {"finish"}

    interface = kind_groups.group_of(kind).interface.items_tree
    assert [item.name for item in interface if item.in_out == "INPUT"][-1] == "Haze"
    item = next(item for item in interface if item.name == "Haze" and item.in_out == "INPUT")
    assert (item.default_value, item.max_value, item.description) == (0.25, 2.0, haze.help)

    assert {"Haze", "Finish"} <= {p.label for p in kind.given_by("")}

    node = node_tree(blender.data.materials.new("new")).nodes.new("ShaderNodeScript")
    shader = generate(make_lobe_set(stack, "weidlich_wilkie"), schema=schema)
    script_node.set_script(node, shader)
    assert node.inputs["Layer1SurfaceHaze"].default_value == 0.25


def test_register_twice_leaves_nothing_behind(registered_lamina, blender):
    registered_lamina.unregister()
    try:
        assert not hasattr(blender.types.Material, "lamina")
        assert not [name for name in dir(blender.types) if name.lower().startswith("lamina")]
        assert "lamina" not in {name.split(".")[0] for name in dir(blender.ops)} or not dir(blender.ops.lamina)
        registered_lamina.register()
        registered_lamina.unregister()
        assert not [name for name in dir(blender.types) if name.lower().startswith("lamina")]
    finally:
        registered_lamina.register()


def test_structure_survives_a_session_without_lamina(layered, registered_lamina):
    stack = material.stack_of(layered)
    registered_lamina.unregister()
    registered_lamina.register()
    assert material.stack_of(layered) == stack


def test_what_cannot_be_made_for_a_save_is_said_once(layered, blender, tmp_path, capsys):
    elements.node_of(layered.lamina.layers[0]).inputs["IOR"].default_value = float("nan")
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "odd.blend"))
    said = [line for line in capsys.readouterr().out.splitlines() if "old shader" in line]
    assert said == [f"Lamina: {layered.name} keeps its old shader: material {layered.name}: layer 0: ior is nan; choose 1 to 4"]


def test_a_render_of_old_values_is_announced_until_they_are_refreshed(blender, capsys):
    baked = blender.data.materials.new("baked")
    material.apply_stack(baked, suite_stack("plastic_grey_0"), "baked")
    material.refresh(baked, settle=True)
    elements.node_of(baked.lamina.base).inputs["Color"].default_value = (0.9, 0.9, 0.9, 1.0)
    assert is_stale(baked)
    render_furnace(baked, (0.0,), samples=1, size=8)
    assert "baked: renders old values" in capsys.readouterr().out
    material.refresh(baked, settle=True)
    measured, _ = render_furnace(baked, (0.0,), samples=64, size=16)
    assert not is_stale(baked) and "old values" not in capsys.readouterr().out
    truth = Adding(material.stack_of(baked)).albedo(np.array([0.0, 0.0, 1.0]))
    assert measured[0] == pytest.approx(truth, rel=0.01)


def test_a_render_without_the_shader_node_is_announced(layered, capsys):
    for role in ("osl", "nodes"):
        layered.node_tree.nodes.remove(node_with(layered, role))
    render_furnace(layered, (0.0,), samples=1, size=8)
    assert f"{layered.name}: its shader node is gone" in capsys.readouterr().out
    material.regenerate(layered)
    render_furnace(layered, (0.0,), samples=1, size=8)
    assert "gone" not in capsys.readouterr().out


def test_a_save_refreshes_what_is_stale_and_leaves_the_rest(blender, tmp_path, capsys):
    baked, live = blender.data.materials.new("baked"), blender.data.materials.new("live")
    material.apply_stack(baked, suite_stack("lambert_grey"), "baked")
    material.apply_stack(live, suite_stack("lambert_grey"), "analytic")
    for each in (baked, live):
        elements.node_of(each.lamina.base).inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    before = shader_of(live).script.as_string()
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "stale.blend"))
    assert not is_stale(baked) and not is_stale(live)
    assert shader_of(live).script.as_string() == before
    assert "baked: its shader is made" in capsys.readouterr().out


def test_a_feature_is_structure_that_costs_nothing_while_off(layered, blender):
    layer = layered.lamina.layers[0]
    plain = script(layered).script.as_string()
    socket(layered, layer, "Coverage").default_value = 0.25
    assert not material.stack_of(layered).layers[0].has(COVERAGE)
    layer.use_coverage = True
    assert layered.lamina.problem == ""
    assert material.stack_of(layered).layers[0]["coverage"] == 0.25
    assert layer_wired_to(layered, "Layer1Coverage") == "Coat"
    layer.use_coverage = False
    assert script(layered).script.as_string() == plain


def test_a_file_from_before_the_features_gets_their_sockets_at_the_end(layered):
    layer = layered.lamina.layers[0]
    tree = elements.node_of(layer).node_tree
    new = {p.label for feature in DIELECTRIC.features for p in feature.parameters}
    for item in [item for item in tree.interface.items_tree if item.name in new]:
        tree.interface.remove(item)
    layered.lamina.schema_version = 1
    before = [s.identifier for s in elements.node_of(layer).inputs]
    stack, text = material.stack_of(layered), script(layered).script.as_string()
    material.regenerate(layered)
    assert material.stack_of(layered) == stack and script(layered).script.as_string() == text
    assert [s.identifier for s in elements.node_of(layer).inputs][: len(before)] == before
    layer.use_anisotropy = True
    assert layered.lamina.problem == "" and layer_wired_to(layered, "Layer1Anisotropy") == "Coat"
    assert script(layered).inputs["Tangent"].links[0].from_node.bl_idname == "ShaderNodeTangent"
    assert material.stack_of(layered).layers[0]["anisotropy"] == 0.0
