# SPDX-License-Identifier: GPL-3.0-or-later
"""A preset over the user's own nodes: what is mixed with the body stays, one thing gives way and is named, outputs are never removed."""

import json

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import addon_utils

from lamina.addon.blender.images import read_exr
from lamina.addon.blender.versions import node_tree
from lamina.addon.check import check
from lamina.addon.exchange import conversion
from lamina.addon.material import layers, material, osl_setting
from lamina.addon.material.elements import node_of
from lamina.addon.material.entry import surface_output
from lamina.addon.material.roles import EEVEE_OUTPUT, ROLE, node_with
from lamina.addon.material.shader_node import surface_of
from lamina.addon.operators.material_operators import what_gives_way
from lamina.addon.rendering.geometry import sphere_mesh
from lamina.addon.rendering.settings import measurement_settings, render_to
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.3}], "base": {"kind": "lambert", "color": [0.2, 0.2, 0.2]}})
# Each: [nodes as name=(type, mute)], [links from -> to.input]; then where Lamina is to be, and what is said.
MIXES = {
    "glow": ("a=A e=E p=P", "e>a.0 p>a.1 a>o", ["a.1"], "p gives way; what it is mixed with stays"),
    "cutout": ("m=M t=T p=P", "t>m.1 p>m.2 m>o", ["m.2"], "p gives way; what it is mixed with stays"),
    "nested": ("a=A m=M t=T e=E p=P", "t>m.1 p>m.2 m>a.0 e>a.1 a>o", ["m.2"], "p gives way; what it is mixed with stays"),
    "two": ("m=M p=P q=P", "p>m.1 q>m.2 m>o", ["m.1"], "p, one of 2 surfaces that are mixed, gives way; the others stay"),
    "glass first": ("m=M g=G p=P", "g>m.1 p>m.2 m>o", ["m.2"], "p, one of 2 surfaces that are mixed, gives way; the others stay"),
    "one twice": ("m=M a=A e=E p=P", "p>m.1 p>a.0 e>a.1 a>m.2 m>o", ["m.1", "a.0"], "p gives way; what it is mixed with stays"),
    "reroutes": ("r=R a=A s=R e=E p=P", "p>s.0 s>a.0 e>a.1 a>r.0 r>o", ["s.0"], "p gives way; what it is mixed with stays"),
    "muted mix": ("m=M! p=P q=P", "p>m.1 q>m.2 m>o", ["m.1"], "p gives way; what it is mixed with stays"),
    "free": ("a=A e=E", "e>a.0 a>o", ["a.1"], ""),
    "other": ("a=A e=E g=G", "e>a.0 g>a.1 a>o", ["a.1"], "g gives way; what it is mixed with stays"),
    "effects": ("m=M e=E t=T", "t>m.1 e>m.2 m>o", ["o"], "m gives way as a whole; it stays in the node tree without a link"),
    "group": ("a=A e=E x=X", "e>a.0 x>a.1 a>o", ["a.1"], "x gives way; what it is mixed with stays"),
    "group alone": ("x=X", "x>o", ["o"], "x gives way as a whole; it stays in the node tree without a link"),
    "glass": ("g=G", "g>o", ["o"], "g gives way as a whole; it stays in the node tree without a link"),
    "principled": ("p=P", "p>o", ["o"], ""),
}  # fmt: skip
_TYPES = {"P": "BsdfPrincipled", "E": "Emission", "T": "BsdfTransparent", "G": "BsdfGlass", "M": "MixShader", "A": "AddShader", "X": "Group"}


@pytest.fixture
def owner(blender):
    osl_setting.enable_osl(bpy.context.scene)
    new = bpy.data.materials.new("owner")
    node_tree(new).nodes.clear()
    return new


def output_of(owner, target: str = "ALL"):
    """The material's output for a renderer, made if there is none."""
    nodes = owner.node_tree.nodes
    found = [n for n in nodes if n.bl_idname == "ShaderNodeOutputMaterial" and n.target == target]
    if found:
        return found[0]
    new = nodes.new("ShaderNodeOutputMaterial")
    new.target = target
    return new


def group() -> bpy.types.NodeTree:
    """A group of the user's with a mix inside."""
    tree = bpy.data.node_groups.new("Theirs", "ShaderNodeTree")
    tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    mix, glow, body, out = (tree.nodes.new(n) for n in ("ShaderNodeAddShader", "ShaderNodeEmission", "ShaderNodeBsdfPrincipled", "NodeGroupOutput"))
    for source, socket in ((glow, mix.inputs[0]), (body, mix.inputs[1]), (mix, out.inputs[0])):
        tree.links.new(source.outputs[0], socket)
    return tree


def build(owner, nodes: str, links: str) -> None:
    tree = owner.node_tree
    output_of(owner).name = "o"
    for name, kind in (each.split("=") for each in nodes.split()):
        node = tree.nodes.new("NodeReroute" if kind == "R" else f"ShaderNode{_TYPES[kind[0]]}")
        node.name, node.mute = name, kind.endswith("!")
        if kind == "X":
            node.node_tree = group()
    for source, target in (each.split(">") for each in links.split()):
        tree.links.new(tree.nodes[source].outputs[0], socket_at(owner, target))


def socket_at(owner, place: str):
    name, _, index = place.partition(".")
    return owner.node_tree.nodes[name].inputs[int(index or 0)]


@pytest.mark.parametrize("case", MIXES.values(), ids=MIXES)
def test_the_mix_stays_and_what_gives_way_is_named(owner, case):
    nodes, links, places, said = case
    build(owner, nodes, links)
    kept = [each for each in links.split() if each.split(">")[1] not in places]
    assert what_gives_way(owner) == said
    material.apply_stack(owner, STACK, "weidlich_wilkie", "nodes")
    for place in places:
        assert socket_at(owner, place).links[0].from_socket == surface_of(owner)
    for source, target in (each.split(">") for each in kept):
        assert socket_at(owner, target).links[0].from_node.name == source
    assert len(surface_of(owner).links) == len(places) and what_gives_way(owner) == ""
    gone = [each.split("=")[0] for each in nodes.split() if each.split("=")[0] not in owner.node_tree.nodes]
    assert gone == [name for name in ("p",) if f"{name}=P" in nodes.split()]
    layers.add_layer(owner, "dielectric", 0)
    owner.lamina.backend = "auto"
    assert all(socket_at(owner, place).links[0].from_socket == surface_of(owner) for place in places)
    assert [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.level != check.NOTE] == []


def test_the_operator_says_what_gave_way(owner, capfd):
    build(owner, "a=A e=E p=P", "e>a.0 p>a.1 a>o")
    item = bpy.data.objects.new("ball", sphere_mesh("ball"))
    item.data.materials.append(owner)
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    assert bpy.ops.lamina.apply_preset(preset="clean_copper") == {"FINISHED"}
    assert "Lamina: p gives way; what it is mixed with stays" in capfd.readouterr().out


def test_a_principled_in_a_mix_is_converted_there(owner):
    build(owner, "a=A e=E p=P", "e>a.0 p>a.1 a>o")
    owner.node_tree.nodes["p"].inputs["Base Color"].default_value = (0.7, 0.1, 0.1, 1.0)
    conversion.to_lamina(owner)
    assert socket_at(owner, "a.1").links[0].from_socket == surface_of(owner) and "p" not in owner.node_tree.nodes
    color = node_of(owner.lamina.base).inputs["Color"].default_value
    assert color[0] > 3.0 * color[1] and socket_at(owner, "a.0").links[0].from_node.name == "e"


def stage(owner) -> None:
    scene = bpy.context.scene
    ball = bpy.data.objects.new("ball", sphere_mesh("ball"))
    ball.data.materials.append(owner)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 1.0, (0.0, 0.0, 5.0)
    for item in (ball, camera):
        scene.collection.objects.link(item)
    scene.camera, scene.world = camera, None  # dark
    measurement_settings(scene, 8, 4, max_bounces=2)


def light(folder) -> np.ndarray:
    render_to(bpy.context.scene, folder / "picture.exr")
    channels = read_exr(folder / "picture.exr").channels
    return np.array([channels[next(c for c in channels if c.split(".")[-1] == name)].mean() for name in "RGB"])


def test_a_glow_goes_on_to_shine(owner, tmp_path):
    """In the dark a picture is what the emission gives."""
    build(owner, "a=A e=E p=P", "e>a.0 p>a.1 a>o")
    owner.node_tree.nodes["e"].inputs["Color"].default_value = (0.3, 0.2, 0.1, 1.0)
    material.apply_stack(owner, STACK, "weidlich_wilkie")
    stage(owner)
    for bpy.context.scene.cycles.shading_system in (True, False):
        assert light(tmp_path) == pytest.approx([0.3, 0.2, 0.1], abs=1e-5)


@pytest.mark.parametrize("target", ["CYCLES", "EEVEE", "ALL"])
def test_an_output_of_the_users_steps_back_with_one_click(owner, tmp_path, target):
    """Its surface is kept, and its volume and displacement go on to show. Green is Lamina, red the user's."""
    tree = owner.node_tree
    build(owner, "e=E p=P", "p>o")
    own, glow = tree.nodes["o"], tree.nodes["e"]
    glow.inputs["Color"].default_value = (1.0, 0.0, 0.0, 1.0)
    theirs = tree.nodes.new("ShaderNodeOutputMaterial")
    theirs.name, theirs.target = "theirs", target
    bump, fog = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes.new("ShaderNodeVolumeAbsorption")
    fog.inputs["Density"].default_value = 0.0
    for source, name in ((glow, "Surface"), (fog, "Volume"), (bump, "Displacement")):
        tree.links.new(source.outputs[0], theirs.inputs[name])
    add = tree.nodes.new("ShaderNodeAddShader")  # around Lamina, to be seen in the dark
    mine = tree.nodes.new("ShaderNodeEmission")
    mine.inputs["Color"].default_value = (0.0, 1.0, 0.0, 1.0)
    tree.links.new(mine.outputs[0], add.inputs[0])
    tree.links.new(tree.nodes["p"].outputs[0], add.inputs[1])
    tree.links.new(add.outputs[0], own.inputs["Surface"])
    own.is_active_output = True
    material.apply_stack(owner, STACK, "weidlich_wilkie", "nodes")
    theirs.is_active_output = True
    stage(owner)
    if target == "ALL":  # a preset goes to the active one
        assert surface_output(tree) == theirs
    found = [f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code.startswith("output_")]
    assert [f.code for f in found] == ["output_rests" if target == "ALL" else "output_hides"] and found[0].mending == "Let Lamina Show"
    if target != "EEVEE":
        assert light(tmp_path) == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    check.mend(owner, bpy.context.scene, bpy.context.preferences, found[0].key)
    assert [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code.startswith("output_")] == []
    assert light(tmp_path) == pytest.approx([0.0, 1.0, 0.0], abs=1e-5)
    own = surface_output(tree)
    lamina_output = node_with(owner, EEVEE_OUTPUT)
    assert tree.get_output_node("CYCLES") == own and tree.get_output_node("EEVEE") in (own, lamina_output) and own.is_active_output
    assert theirs.inputs["Surface"].links[0].from_node == glow
    for output in (own, theirs):
        assert output.inputs["Volume"].links[0].from_node == fog and output.inputs["Displacement"].links[0].from_node == bump


def test_outputs_for_one_renderer_alone_stay_and_lamina_gets_its_own(owner):
    tree = owner.node_tree
    for target in ("CYCLES", "EEVEE"):
        body = tree.nodes.new("ShaderNodeBsdfPrincipled")
        tree.links.new(body.outputs[0], output_of(owner, target).inputs["Surface"])
    material.apply_stack(owner, STACK, "weidlich_wilkie", "nodes")
    found = [f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code == "output_hides"]
    assert [f.words["renderer"] for f in found] == ["Cycles", "Eevee"]
    for finding in found:
        check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    outputs = [n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial"]
    assert {"CYCLES", "EEVEE"} & {output.target for output in outputs if ROLE not in output} == set() and tree.get_output_node("CYCLES").inputs[
        "Surface"
    ].links[0].from_socket == surface_of(owner)
    assert tree.get_output_node("EEVEE") == tree.get_output_node("CYCLES")


@pytest.mark.parametrize("target", ["CYCLES", "EEVEE", "ALL"])
def test_exporters_find_what_shows_after_the_click(owner, tmp_path, target):
    tree = owner.node_tree
    build(owner, "p=P q=P", "p>o")
    theirs = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes["q"].outputs[0], theirs.inputs["Surface"])
    tree.nodes["q"].inputs["Base Color"].default_value = (1.0, 0.0, 0.0, 1.0)
    tree.nodes["o"].is_active_output = True
    material.apply_stack(owner, Stack.from_dict({"base": {"kind": "lambert", "color": [0.0, 0.5, 0.0]}}), "weidlich_wilkie", "nodes")
    theirs.target, theirs.is_active_output = target, True
    (finding,) = [f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code.startswith("output_")]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    stage(owner)
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "out.gltf"), export_format="GLTF_SEPARATE")
    found = json.loads((tmp_path / "out.gltf").read_text())["materials"][0]["pbrMetallicRoughness"]
    assert found["baseColorFactor"] == pytest.approx([0.0, 0.5, 0.0, 1.0], abs=0.01)
    layers.add_layer(owner, "dielectric", 0)
    assert tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_socket == surface_of(owner)
