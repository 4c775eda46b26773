# SPDX-License-Identifier: GPL-3.0-or-later
"""The image of stock nodes that follow live values: it lives, travels and goes with the group that looks up in it."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import EEVEE, node_with
from lamina.addon.material.shader_node import remove_material
from lamina.addon.material.state import is_settled, lags
from lamina.addon.shader.nodes.node_groups import is_untouched
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "tint": [0.9, 0.6, 0.3]}], "base": {"kind": "conductor", "roughness": 0.4}})


def tinted(name: str = "tinted") -> bpy.types.Material:
    """A lacquered metal whose tint comes from another node."""
    owner = bpy.data.materials.new(name)
    materials.apply_stack(owner, STACK, "baked")
    source = owner.node_tree.nodes.new("ShaderNodeRGB")
    owner.node_tree.links.new(source.outputs[0], node_of(owner.lamina.layers[0]).inputs["Tint"])
    materials.refresh(owner, settle=True)
    assert is_settled(owner) and not lags(owner)
    return owner


def images() -> dict[str, np.ndarray]:
    found = {}
    for image in bpy.data.images:
        if image.packed_file is not None:
            found[image.name] = np.empty(len(image.pixels), np.float32)
            image.pixels.foreach_get(found[image.name])
    return found


def same(first: dict[str, np.ndarray], second: dict[str, np.ndarray]) -> bool:
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


def test_materials_of_one_lobe_set_share_it_and_it_goes_with_the_last(blender):
    first, other = tinted(), tinted("other")
    copy = first.copy()
    names = {node_with(first, role).node_tree.name for role in ("nodes", EEVEE)}
    assert len(names) == 2 and set(images()) == names, "one for Cycles, one for EEVEE"
    for owner in (first, copy):
        remove_material(owner)
        assert set(images()) == names
    remove_material(other)
    assert images() == {}


def test_a_group_that_follows_no_more_takes_it_away(blender):
    owner = tinted()
    owner.node_tree.links.remove(node_of(owner.lamina.layers[0]).inputs["Tint"].links[0])
    materials.refresh(owner, settle=True)
    assert images() == {}


@pytest.mark.parametrize("link", [False, True], ids=["append", "link"])
def test_it_travels_with_the_material(blender, tmp_path, link):
    owner = tinted()
    owner.use_fake_user = True
    made, file = images(), str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    assert same(images(), made) and is_untouched(node_with(bpy.data.materials["tinted"], "nodes").node_tree)
    assert all(image.is_float and not image.use_half_precision and image.colorspace_settings.is_data for image in bpy.data.images)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(file, link=link) as (_, wanted):
        wanted.materials = ["tinted"]
    assert same(images(), made)


def test_undo_and_redo_keep_it(blender):
    bpy.ops.ed.undo_push(message="before")
    tinted()
    made = images()
    bpy.ops.ed.undo_push(message="made")
    bpy.data.materials["tinted"].diffuse_color = (1.0, 0.0, 0.0, 1.0)
    bpy.ops.ed.undo_push(message="colored")
    bpy.ops.ed.undo()
    assert same(images(), made)
    bpy.ops.ed.undo()
    assert images() == {}
    bpy.ops.ed.redo()
    assert same(images(), made)


def test_a_group_whose_image_was_painted_is_left_alone(blender):
    owner = tinted()
    group = node_with(owner, "nodes").node_tree
    (image,) = {node.image for node in group.nodes if hasattr(node, "image")}
    image.pixels[0] = 7.0
    assert not is_untouched(group)
    remove_material(owner)
    assert group.name in bpy.data.node_groups and set(images()) == {group.name}


@pytest.mark.parametrize("setting", ["texture_limit", "texture_limit_render"])
def test_check_finds_a_limit_that_shrinks_it_and_raises_it(blender, setting):
    owner, scene = tinted(), bpy.context.scene
    size = max(max(image.size) for image in bpy.data.images)

    def told() -> list[str]:
        return [f.key for f in check.find(owner, scene, bpy.context.preferences) if f.code == "tables_shrunk"]

    setattr(scene.cycles, setting, "128")
    assert 128 < size <= 8192 and told() == [], "Simplify is off"
    scene.render.use_simplify = True
    (key,) = told()
    check.mend(owner, scene, bpy.context.preferences, key)
    assert told() == [] and size <= int(getattr(scene.cycles, setting)) < 2 * size, "no more than needed"
    plain = bpy.data.materials.new("plain")
    materials.apply_stack(plain, STACK, "baked")
    setattr(scene.cycles, setting, "128")
    assert not [f for f in check.find(plain, scene, bpy.context.preferences) if f.code == "tables_shrunk"], "it looks up nothing"
