# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Copy and Paste Material, which take a node tree and no properties: the layers come along, in this file and into another."""

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender.versions import node_tree
from lamina.addon.check import check
from lamina.addon.material import layers, material, osl_setting
from lamina.addon.material.elements import ID_KEY, node_of
from lamina.addon.material.roles import ROLE, node_with
from lamina.addon.material.shader_node import surface_of
from lamina.addon.rendering.geometry import sphere_mesh
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({
    "name": "Painted",
    "layers": [{"kind": "dielectric", "name": "Clear", "roughness": 0.1}, {"kind": "dielectric", "name": "Paint", "roughness": 0.5, "tint": [0.9, 0.2, 0.1]}],
    "base": {"kind": "lambert", "color": [0.6, 0.3, 0.2]},
})  # fmt: skip
OTHER = Stack.from_dict({"name": "Gold", "layers": [{"kind": "dielectric"}], "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3}})


@pytest.fixture
def source(blender, tmp_path):
    """A material whose structure is nowhere the default. The copy is a file in Blender's temporary folder."""
    bpy.context.preferences.filepaths.temporary_directory = str(tmp_path)
    osl_setting.enable_osl(bpy.context.scene)
    new = bpy.data.materials.new("source")
    material.apply_stack(new, STACK, "analytic")
    new.lamina.layers[1].visible = False
    new.lamina.layers[0].name = "Topcoat"
    new.lamina.tolerance = 7.0
    new.lamina.tier = "weidlich_wilkie"
    new.lamina.stack_name = "Repainted"
    yield new
    bpy.context.preferences.filepaths.temporary_directory = ""


def facts(owner) -> tuple:
    """What is to come along."""
    lamina = owner.lamina
    elements = [(e.name, e.kind, e.visible) for e in (*lamina.layers, lamina.base)]
    return elements, lamina.tier, lamina.backend, round(lamina.tolerance, 4), material.stack_of(owner, hidden=True)


def copy(owner) -> None:
    call(bpy.ops.material.copy, owner)


def paste(owner) -> None:
    call(bpy.ops.material.paste, owner)


def call(operator, owner) -> None:
    """Blender wants an active object, from 5 on with a material, whichever."""
    item = bpy.data.objects.new("active", bpy.data.meshes.new("active"))
    item.data.materials.append(bpy.data.materials.new("active"))
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    with bpy.context.temp_override(material=owner):
        assert operator() == {"FINISHED"}


def findings(owner) -> list[str]:
    return [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.level != check.NOTE]


def target(kind: str, source):
    """A material to paste onto."""
    if kind == "copy":
        new = source.copy()
        layers.add_layer(new, "dielectric", 0)
        layers.remove_layer(new, 1)
        return new
    new = bpy.data.materials.new(kind)
    if kind == "layered":
        material.apply_stack(new, OTHER, "analytic", "nodes")
    return new


@pytest.mark.parametrize("is_used", [False, True], ids=["on no object", "on an object"])
@pytest.mark.parametrize("kind", ["plain", "layered", "copy", "itself"])
def test_layers_come_along_and_can_be_edited(source, kind, is_used):
    there, wanted = source if kind == "itself" else target(kind, source), facts(source)
    if is_used:
        ball = bpy.data.objects.new("ball", sphere_mesh("ball"))
        ball.data.materials.append(there)
        bpy.context.scene.collection.objects.link(ball)
    copy(source)
    if kind == "itself":  # back to what it was when it was copied
        layers.remove_layer(source, 0)
        source.lamina.tier = "analytic"
    paste(there)
    assert facts(there) == wanted and findings(there) == [] and not there.lamina.problem
    nodes = len(there.node_tree.nodes)
    layers.move_layer(there, 0, 1)
    there.lamina.layers[0].visible = True
    node_of(there.lamina.layers[0]).inputs["Roughness"].default_value = 0.9
    assert findings(there) == [] and len(there.node_tree.nodes) == nodes
    assert [e.name for e in there.lamina.layers] == ["Paint", "Topcoat"]
    if kind != "itself":
        assert facts(source) == wanted and findings(source) == []


def test_into_another_file(source, tmp_path):
    wanted = facts(source)
    copy(source)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.filepaths.temporary_directory = str(tmp_path)
    osl_setting.enable_osl(bpy.context.scene)
    there = bpy.data.materials.new("there")
    paste(there)
    assert facts(there) == wanted and findings(there) == []
    there.use_fake_user = True
    path = str(tmp_path / "there.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    there = bpy.data.materials["there"]
    assert facts(there) == wanted and findings(there) == []


def test_a_file_in_which_somebody_pasted_without_lamina(source, tmp_path):
    """Nothing looks at the material before it is saved."""
    there, wanted = target("layered", source), facts(source)
    handlers, kept = bpy.app.handlers.depsgraph_update_post, list(bpy.app.handlers.depsgraph_update_post)
    handlers.clear()
    try:
        copy(source)
        paste(there)
        assert there.lamina.stack_name == "Gold"
        there.use_fake_user = True
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "there.blend"))
    finally:
        handlers.extend(kept)
    assert facts(there) == wanted and findings(there) == []


def test_a_plain_material_over_layers_leaves_a_plain_material(source):
    plain = bpy.data.materials.new("plain")
    node_tree(plain)
    copy(plain)
    paste(source)
    assert not source.lamina.is_layered and source.lamina.tier == plain.lamina.tier
    material.apply_stack(source, OTHER, "weidlich_wilkie")
    assert findings(source) == [] and material.stack_of(source) == OTHER


def test_pasted_values_are_what_exporters_and_solid_view_find(source, tmp_path):
    there = target("layered", source)
    there.use_fake_user = True
    material.hand_over(source, settle=True)
    copy(source)
    paste(there)
    node_of(there.lamina.base).inputs["Color"].default_value = (0.1, 0.2, 0.7, 1.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "there.blend"))
    color = node_with(there, "principled").inputs["Base Color"].default_value
    assert color[2] > 2.0 * color[0] and tuple(there.diffuse_color)[:3] == pytest.approx(tuple(color)[:3], abs=1e-6)
    assert tuple(source.diffuse_color)[0] > tuple(source.diffuse_color)[2]


def duplicated(node):
    """Shift-D: what belongs to the node comes along, but its name."""
    new = node.id_data.nodes.new(node.bl_idname)
    for key in (ROLE, ID_KEY):
        if key in node:
            new[key] = node[key]
    for name in ("node_tree", "script"):
        if getattr(node, name, None) is not None:
            setattr(new, name, getattr(node, name))
    return new


@pytest.mark.parametrize("is_renamed", [False, True], ids=["names", "renamed"])
def test_copies_of_nodes_do_not_stand_for_them(source, is_renamed):
    tree, wanted = source.node_tree, facts(source)
    here = [node for node in tree.nodes if ROLE in node or ID_KEY in node]
    if is_renamed:  # the copies come first by name
        for number, node in enumerate(here):
            node.name = f"z {number}"
    for node in here:
        duplicated(node)
    surface = surface_of(source)
    assert facts(source) == wanted and node_of(source.lamina.base) in here and surface.node in here
    material.regenerate(source)
    source.lamina.tier = "analytic"
    layers.add_layer(source, "dielectric", 0)
    assert set(findings(source)) == {"node_spare"} and node_of(source.lamina.base) in here
    for finding in check.find(source, bpy.context.scene, bpy.context.preferences):
        check.mend(source, bpy.context.scene, bpy.context.preferences, finding.key)
    assert findings(source) == []
