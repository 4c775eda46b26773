# SPDX-License-Identifier: GPL-3.0-or-later
"""How a material lies in the Shader editor: framed, apart, without sockets that mean nothing, and the user's nodes where they were."""

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.exchange import conversion
from lamina.addon.material import layers, material
from lamina.addon.material.backend import NODES
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import LAYERS_FRAME, ROLE, SHADER_FRAME, node_with
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "name": "Coat"}, {"kind": "dielectric", "name": "Paint", "coverage": 0.5}],
        "base": {"kind": "conductor", "metal": "gold"},
    }
)


@pytest.fixture
def made(blender):
    new = bpy.data.materials.new("Laid Out")
    material.apply_stack(new, STACK, "analytic", NODES)
    return new


def values(made) -> list[bpy.types.Node]:
    """The nodes of the layers from the top, then the base's."""
    return [node_of(element) for element in (*made.lamina.layers, made.lamina.base)]


def places(nodes) -> list[tuple[float, ...]]:
    return [tuple(node.location_absolute) for node in nodes]


def assert_laid_out(made) -> None:
    column = values(made)
    assert {node.parent for node in column} == {node_with(made, LAYERS_FRAME)} and node_with(made, NODES).parent == node_with(made, SHADER_FRAME)
    assert len([node for node in made.node_tree.nodes if node.bl_idname == "NodeFrame"]) == 2
    for above, below in zip(column, column[1:]):
        rows = sum(not socket.hide for socket in (*above.inputs, *above.outputs))
        assert above.location_absolute.x == below.location_absolute.x
        assert above.location_absolute.y - below.location_absolute.y > 22.0 * (rows + 2), "a node lies on the one below"


def test_nodes_are_framed_and_apart(made):
    assert_laid_out(made)
    assert node_with(made, LAYERS_FRAME).label == "Layers: Edit in the Panel"


def test_only_sockets_that_mean_something_are_shown(made):
    coat, paint, base = ([socket.name for socket in node.inputs if not socket.hide] for node in values(made))
    assert coat == ["IOR", "Roughness", "Tint", "Thickness"] and paint == [*coat, "Coverage"]
    assert base == ["Roughness"], "the index of a named metal is its own"
    made.lamina.layers[0].use_coverage = True
    assert not values(made)[0].inputs["Coverage"].hide
    link = made.node_tree.links.new(made.node_tree.nodes.new("ShaderNodeTexNoise").outputs[0], values(made)[0].inputs["Film Thickness"])
    material.regenerate(made)
    assert link.is_valid and not values(made)[0].inputs["Film Thickness"].hide


def test_the_layout_survives_what_changes_the_stack(made):
    layers.move_layer(made, 0, 1)
    assert_laid_out(made)
    layers.add_layer(made, "dielectric", 0)
    assert_laid_out(made)
    material.set_base(made, "lambert")
    assert_laid_out(made)
    layers.remove_layer(made, 1)
    assert_laid_out(made)
    before = places(values(made))
    material.regenerate(made)
    assert places(values(made)) == before


def test_the_column_stays_where_its_frame_was_moved_to(made):
    before = places(values(made))
    for node in values(made):  # as Blender moves what is in a frame
        node.location_absolute = node.location_absolute.x - 700.0, node.location_absolute.y + 90.0
    layers.add_layer(made, "dielectric", 2)
    assert_laid_out(made)
    assert places(values(made))[-1] == (before[-1][0] - 700.0, before[-1][1] + 90.0)


def test_nodes_of_the_user_are_not_moved(made):
    tree = made.node_tree
    own = [tree.nodes.new(kind) for kind in ("ShaderNodeTexNoise", "ShaderNodeMath", "NodeFrame")]
    own[0].location, own[1].location = (-1500.0, 40.0), (-700.0, 100.0)
    tree.links.new(own[0].outputs[0], values(made)[0].inputs["Tint"])
    values(made)[1].parent = own[2]  # a layer's node in the user's frame is the user's to place
    values(made)[1].location_absolute = (333.0, 444.0)
    before = places([*own, values(made)[1]])
    layers.add_layer(made, "dielectric", 0)
    material.regenerate(made)
    assert places([*own, node_of(made.lamina.layers[2])]) == before and node_of(made.lamina.layers[2]).parent == own[2]


def test_undo_and_a_file_keep_it(made, tmp_path):
    item = bpy.data.objects.new("Thing", bpy.data.meshes.new("Thing"))
    item.data.materials.append(made)
    bpy.context.collection.objects.link(item)
    before = places(values(made))
    bpy.ops.ed.undo_push(message="before")
    layers.add_layer(made, "dielectric", 0)
    bpy.ops.ed.undo_push(message="add")
    bpy.ops.ed.undo()
    made = bpy.data.materials["Laid Out"]
    assert_laid_out(made)
    assert places(values(made)) == before
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "laid.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "laid.blend"))
    made = bpy.data.materials["Laid Out"]
    assert places(values(made)) == before
    layers.add_layer(made, "dielectric", 0)
    assert_laid_out(made)
    assert places(values(made))[-1] == before[-1], "the column stands on the base"


def test_a_principled_copy_has_no_frame_and_all_its_sockets(made):
    copy, _, _ = conversion.principled_copy(made)
    assert not [node for node in copy.node_tree.nodes if node.bl_idname == "NodeFrame" or ROLE in node]
    principled = next(node for node in copy.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    assert not any(socket.hide for socket in principled.inputs)
