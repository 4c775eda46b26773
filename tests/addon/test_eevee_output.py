# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE has an output with weights of its own where Lamina's surface is all that shows; what a user adds shows in both renderers."""

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.check import check
from lamina.addon.exchange import conversion
from lamina.addon.material import material as materials
from lamina.addon.material.backend import NODES
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import EEVEE, EEVEE_OUTPUT, node_with
from lamina.addon.material.shader_node import surface_of
from lamina.addon.material.state import lags
from lamina.addon.shader.nodes.node_groups import lobe_group
from lamina.addon.shader.nodes.stock_nodes import eevee_stock_tables, stock_tables
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.4}], "base": {"kind": "oren_nayar", "color": [0.5, 0.2, 0.1], "sigma": 20.0}})


@pytest.fixture
def owner(blender):
    made = bpy.data.materials.new("owner")
    materials.apply_stack(made, STACK, "analytic")
    return made


def outputs(owner) -> tuple:
    return tuple(owner.node_tree.get_output_node(renderer) for renderer in ("ALL", "CYCLES", "EEVEE"))


def test_eevee_alone_sees_its_own_weights(owner):
    everyone, cycles, eevee = outputs(owner)
    assert everyone == cycles != eevee == node_with(owner, EEVEE_OUTPUT) and everyone.is_active_output
    group = eevee.inputs["Surface"].links[0].from_node
    made = make_lobe_set(STACK, "analytic")
    assert group == node_with(owner, EEVEE) and group.node_tree == lobe_group(eevee_stock_tables(made, stock_tables(made)))
    assert {"ShaderNodeBsdfMetallic"} & {node.bl_idname for node in group.node_tree.nodes} == set()
    assert all(node.inputs["Roughness"].default_value == 0.0 for node in group.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    assert "output_hides" not in [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]


def test_it_follows_values(owner):
    former = node_with(owner, EEVEE).node_tree.name
    node_of(owner.lamina.layers[0]).inputs["Roughness"].default_value = 0.2
    assert lags(owner)
    materials.refresh_stock(owner)
    assert node_with(owner, EEVEE).node_tree.name != former and not lags(owner) and outputs(owner)[2] == node_with(owner, EEVEE_OUTPUT)


def test_displacement_and_volume_show_in_eevee_too(owner):
    tree = owner.node_tree
    bump, fog = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes.new("ShaderNodeVolumeAbsorption")
    tree.links.new(bump.outputs[0], outputs(owner)[0].inputs["Displacement"])
    tree.links.new(fog.outputs[0], outputs(owner)[0].inputs["Volume"])
    assert lags(owner)
    materials.refresh(owner)
    eevee = outputs(owner)[2]
    assert eevee.inputs["Displacement"].links[0].from_node == bump and eevee.inputs["Volume"].links[0].from_node == fog and not lags(owner)


def test_what_a_user_mixes_in_shows_in_eevee(owner):
    tree, groups = owner.node_tree, len(bpy.data.node_groups)
    glow, mix = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(surface_of(owner), mix.inputs[0])
    tree.links.new(glow.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], outputs(owner)[0].inputs["Surface"])
    assert lags(owner)
    materials.refresh(owner)
    assert outputs(owner)[2] == outputs(owner)[0] and node_with(owner, EEVEE) is None and not lags(owner) and len(bpy.data.node_groups) < groups


def test_a_users_own_output_for_eevee_stays(blender):
    made = bpy.data.materials.new("owner")
    made.use_nodes = True
    own = made.node_tree.nodes.new("ShaderNodeOutputMaterial")
    own.target = "EEVEE"
    materials.apply_stack(made, STACK, "analytic")
    assert made.node_tree.get_output_node("EEVEE") == own and node_with(made, EEVEE_OUTPUT) is None


def test_a_principled_copy_has_none(owner):
    copy, _, _ = conversion.principled_copy(owner)
    assert len({output.name for output in outputs(copy)}) == 1 and node_with(copy, EEVEE) is None


def lookups(node) -> set[str]:
    """Kinds of the nodes that look up tables in a branch's group."""
    return {n.bl_idname for n in node.node_tree.nodes if n.bl_idname.startswith("ShaderNodeTex")}


def test_eevee_never_reads_tables_by_nodes_that_read_smaller_copies_of_them(blender):
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.4}], "base": {"kind": "lambert"}}), "auto")
    tree = owner.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], node_of(owner.lamina.layers[0]).inputs["Roughness"])
    materials.refresh(owner, settle=True)
    assert lookups(node_with(owner, EEVEE)) == {"ShaderNodeTexEnvironment"} and lookups(node_with(owner, NODES)) == {"ShaderNodeTexImage"}
    mix = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(surface_of(owner), mix.inputs[0])
    tree.links.new(mix.outputs[0], outputs(owner)[0].inputs["Surface"])
    materials.refresh_stock(owner)
    assert outputs(owner)[2] == outputs(owner)[0] and lookups(node_with(owner, NODES)) == {"ShaderNodeTexEnvironment"} and not lags(owner)
    tree.nodes.remove(mix)
    tree.links.new(surface_of(owner), outputs(owner)[0].inputs["Surface"])
    for _ in range(2):  # the first makes EEVEE's output
        materials.refresh_stock(owner)
    assert lookups(node_with(owner, NODES)) == {"ShaderNodeTexImage"} and not lags(owner)
