# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks in Blender: there at the first click, where the form says, kept by bakes, and never in the place of a user's link."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.exchange import mask_bake
from lamina.addon.material import layers, masks, material, means
from lamina.addon.material.elements import node_of
from lamina.addon.material.node_copy import copy_sources
from lamina.addon.material.reading import measured_stack, stack_of
from lamina.addon.material.state import is_stale
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.masks import GENERATORS
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

DUST = {"kind": "oren_nayar", "coverage": 0.2}
BASE = {"kind": "lambert", "color": [0.1, 0.1, 0.1]}


def masked(generator: str, item=None, **values):
    """A material with one layer of dust by a mask, on an object."""
    stack = Stack.from_dict({"layers": [{**DUST, "masks": {"coverage": {"generator": generator, **values}}}], "base": BASE})
    new = bpy.data.materials.new("Worn")
    material.apply_stack(new, stack, "weidlich_wilkie", "nodes")
    if item is not None:
        item.data.materials.append(new)
    return new


def box(cuts: int = 24):
    """A cube of 2 m, its faces divided, with UVs, selected."""
    import bmesh

    mesh, edit = bpy.data.meshes.new("Box"), bmesh.new()
    bmesh.ops.create_cube(edit, size=2.0, calc_uvs=True)
    bmesh.ops.subdivide_edges(edit, edges=edit.edges, cuts=cuts, use_grid_fill=True)
    edit.loops.layers.uv.verify()
    edit.to_mesh(mesh)
    edit.free()
    item = bpy.data.objects.new("Box", mesh)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return item


def places(item) -> np.ndarray:
    return np.array([vertex.co[:] for vertex in item.data.vertices])


def at_vertices(new, item) -> np.ndarray:
    """The mask of the only layer, by a bake."""
    assert mask_bake.bake_masks(new, [item], mask_bake.ATTRIBUTE) == 1
    values = np.empty(len(item.data.vertices), np.float32)
    item.data.attributes[f"{new.name} Oren-Nayar Coverage"].data.foreach_get("value", values)
    return values


@pytest.mark.parametrize("size", [1.0, 0.02])
def test_edges_are_where_the_form_has_them_at_any_size(blender, size):
    item = box()
    item.scale = (size,) * 3
    bpy.context.view_layer.update()
    worn = at_vertices(masked("edges", item, amount=0.03, pull=6.0, width=0.04), item)
    edge = np.sum(np.abs(np.abs(places(item)) - 1.0) < 1e-3, axis=1) >= 2
    flat = np.sum(np.abs(places(item)) < 0.8, axis=1) == 2
    print(f"size {size}: at edges {worn[edge].mean():.2f}, elsewhere {worn[flat].mean():.3f}")
    assert worn[edge].mean() > 0.6 and worn[flat].mean() < 0.12


def test_dust_settles_on_what_faces_up_in_the_world(blender):
    item = box()
    item.rotation_euler = (np.pi, 0.0, 0.0)
    bpy.context.view_layer.update()
    dust = at_vertices(masked("settled", item, amount=0.9), item)
    inside = np.max(np.abs(places(item)[:, :2]), axis=1) < 0.9
    top, under = inside & (places(item)[:, 2] < -0.99), inside & (places(item)[:, 2] > 0.99)
    assert dust[top].mean() > 0.75 and dust[under].max() == 0.0


def test_dirt_lies_in_corners(blender):
    item = box()
    for face in item.data.polygons:
        face.flip()  # a room, seen from inside
    item.data.update()
    dirt = at_vertices(masked("cavities", item, amount=0.02, width=0.2, pull=8.0), item)
    corner = np.sum(np.abs(np.abs(places(item)) - 1.0) < 0.1, axis=1) >= 2
    middle = np.sum(np.abs(places(item)) < 0.5, axis=1) == 2
    assert dirt[corner].mean() > 0.5 and dirt[middle].mean() < 0.12


@pytest.mark.parametrize("amount", [0.0, 0.1, 0.5, 1.0])
def test_the_amount_is_a_share_of_the_surface(blender, amount):
    mean = stack_of(masked("patches", amount=amount, scale=20.0)).layers[0]["coverage"]
    print(f"amount {amount}: covers {mean}")
    assert abs(mean - amount) <= (0.05 if 0.0 < amount < 1.0 else 0.0)


@pytest.mark.parametrize("generator", GENERATORS)
def test_every_generator_draws_something_and_goes_with_its_layer(blender, generator):
    new = masked(generator, amount=0.5)
    before = len(new.node_tree.nodes)
    layers.add_layer(new, "dielectric", 1)
    layers.remove_layer(new, 0)
    assert 0.0 < masks.GENERATORS[generator].parameters[0].default
    assert not any(masks.is_mask(node) for node in new.node_tree.nodes) and len(new.node_tree.nodes) < before
    item = box(8)
    values = at_vertices(masked(generator, item, amount=0.5, scale=3.0), item)
    assert values.min() >= 0.0 and values.max() > 0.5 and values.std() > 0.05


def test_a_file_gives_back_what_the_nodes_hold(blender):
    new = masked("drips", length=3.0)
    masks.mask_node(node_of(new.lamina.layers[0]).inputs["Coverage"]).inputs["Amount"].default_value = 0.4
    held = stack_of(new).layers[0].masks["coverage"]
    assert (held.generator.name, held.values["length"], held.values["amount"]) == ("drips", 3.0, 0.4)
    again = bpy.data.materials.new("Again")
    material.apply_stack(again, stack_of(new), "weidlich_wilkie", "nodes")
    assert stack_of(again).layers[0].masks == stack_of(new).layers[0].masks
    pasted = masked("patches")
    layers.paste_layers(pasted, layers.copied_text(new, [0]), 0)
    assert [layer.masks["coverage"].generator.name for layer in stack_of(pasted).layers] == ["drips", "patches"]
    layers.duplicate_layer(new, 0)
    assert len([node for node in new.node_tree.nodes if masks.is_mask(node)]) == 1  # a copy shares it, as any texture


def test_links_of_the_user_stay(blender):
    new = bpy.data.materials.new("Own")
    material.apply_stack(new, Stack.from_dict({"layers": [DUST], "base": BASE}), "weidlich_wilkie", "nodes")
    own = new.node_tree.nodes.new("ShaderNodeTexNoise")
    new.node_tree.links.new(own.outputs[0], node_of(new.lamina.layers[0]).inputs["Coverage"])
    with pytest.raises(LaminaError, match="Coverage has a link already"):
        layers.add_mask(new, 0, "coverage", "edges")
    dressed = bpy.data.materials.new("Dressed")
    worn = Stack.from_dict({"layers": [{**DUST, "masks": {"coverage": {"generator": "edges"}}}], "base": BASE})
    material.apply_stack(dressed, worn, "weidlich_wilkie", "nodes", lambda target: copy_sources(*(node_of(m.lamina.layers[0]) for m in (new, target))))
    source = node_of(dressed.lamina.layers[0]).inputs["Coverage"].links[0].from_node
    assert source.bl_idname == "ShaderNodeTexNoise" and not any(masks.is_mask(node) for node in dressed.node_tree.nodes)
    assert own.name in new.node_tree.nodes


def test_a_failed_change_leaves_no_mask_behind(blender):
    new = masked("patches")
    names = {node.name for node in new.node_tree.nodes}
    with pytest.raises(LaminaError):
        material.apply_stack(new, Stack.from_dict({"layers": [{**DUST, "masks": {"coverage": {"generator": "edges"}}}], "base": BASE}), "nonsense", "nodes")
    with pytest.raises(LaminaError, match="takes no mask"):
        layers.add_mask(new, 0, "color", "edges")
    assert {node.name for node in new.node_tree.nodes} == names


@pytest.mark.parametrize("into", [mask_bake.IMAGE, mask_bake.ATTRIBUTE])
def test_a_bake_shows_what_was_live_and_goes_back(blender, into):
    item = box()
    new = masked("patches", item, amount=0.4, scale=1.5, softness=1.0, low=0.1, high=0.9)
    mean, nodes = measured_stack(new).layers[0]["coverage"], len(new.node_tree.nodes)
    live = at_vertices(new, item)
    assert live.min() == 0.0 and live.max() == 1.0  # Low and High stay live
    mask_bake.draw_live(new)
    mask_bake.bake_masks(new, [item], into, 64)
    mask = masks.mask_node(node_of(new.lamina.layers[0]).inputs["Coverage"])
    assert mask.inputs["Use Baked"].default_value == 1.0 and mask.inputs["Baked"].is_linked
    again = at_vertices(new, item)
    assert np.abs(again - live).max() < 0.02 and not is_stale(new)
    assert mask_bake.draw_live(new) == 1 and len(new.node_tree.nodes) == nodes
    assert measured_stack(new).layers[0]["coverage"] == pytest.approx(mean)


def test_what_cannot_be_baked_is_said_and_nothing_changes(blender):
    item = box(2)
    plain = bpy.data.materials.new("Plain")
    material.apply_stack(plain, Stack.from_dict({"layers": [DUST], "base": BASE}), "weidlich_wilkie", "nodes")
    with pytest.raises(LaminaError, match="has no masks to bake; choose Add Mask"):
        mask_bake.bake_masks(plain, [item], mask_bake.IMAGE)
    new = masked("edges")
    with pytest.raises(LaminaError, match="select a mesh that has it"):
        mask_bake.bake_masks(new, [item], mask_bake.IMAGE)
    item.data.materials.append(new)
    while item.data.uv_layers:
        item.data.uv_layers.remove(item.data.uv_layers[0])
    names = {node.name for node in new.node_tree.nodes}
    with pytest.raises(LaminaError, match="no UV map; unwrap it first, or bake to an attribute"):
        mask_bake.bake_masks(new, [item], mask_bake.IMAGE)
    assert {node.name for node in new.node_tree.nodes} == names


def test_buttons(blender):
    item = box(2)
    assert bpy.ops.lamina.apply_preset(preset="glazed_mug") == {"FINISHED"}
    assert bpy.ops.lamina.layer_add_ready(ready="dirt") == {"FINISHED"}
    new = item.active_material
    assert new.lamina.layers[0].use_coverage
    assert masks.mask_node(node_of(new.lamina.layers[0]).inputs["Coverage"]) is not None
    new.lamina.active_layer = 1
    assert bpy.ops.lamina.add_mask(generator="fingerprints", value="roughness") == {"FINISHED"}
    values = stack_of(new).layers[1].masks["roughness"].values
    assert (values["low"], values["high"]) == (0.0, 0.4)
    assert bpy.ops.lamina.bake_masks(into="IMAGE", size="64") == {"FINISHED"}
    assert bpy.ops.lamina.live_masks() == {"FINISHED"}


def test_a_mask_that_comes_again_is_not_measured_again(blender, monkeypatch):
    measured = []
    monkeypatch.setattr(means, "_measured", {})
    monkeypatch.setattr(means, "mean_of", lambda source, _: measured.append(source.node.name) or 0.5)
    first = masked("patches")
    assert len(measured) == 1
    masked("patches")
    assert len(measured) == 1
    masked("patches", scale=7.0)
    assert len(measured) == 2
    mask = masks.mask_node(node_of(first.lamina.layers[0]).inputs["Coverage"])
    picture = node_of(first.lamina.layers[0]).id_data.nodes.new("ShaderNodeTexImage")
    picture.image = bpy.data.images.new("packed", 4, 4)
    picture.id_data.links.new(picture.outputs[0], mask.inputs[0])
    for count in (3, 4):
        measured_stack(first)
        assert len(measured) == count
