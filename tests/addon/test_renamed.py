# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of nodes, groups and texts are the user's: whatever they are, the stack stays, and a deleted node comes back with its values."""

import json
from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.check import check
from lamina.addon.jobs import bakes
from lamina.addon.material import layers, material, osl_setting
from lamina.addon.material.elements import ID_KEY, node_of
from lamina.addon.material.reading import measure_means
from lamina.addon.material.roles import ROLE, node_with
from lamina.reference_py.material.ready_layers import load, names
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

DATA = Path(__file__).parent.parent / "data"
STACK = Stack.from_dict({
    "layers": [{"kind": "dielectric", "name": "Clear", "roughness": 0.1}, {"kind": "dielectric", "name": "Hidden", "roughness": 0.4}],
    "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3, "anisotropy": 0.5},
})  # fmt: skip


def findings(owner) -> list[str]:
    return [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.level != check.NOTE]


def mend(owner, code: str) -> None:
    finding = next(f for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code == code)
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)


def rename_all(owner) -> None:
    """What batch renaming does, to all that the user can name."""
    for number, node in enumerate(owner.node_tree.nodes):
        node.name = f"n {number}"
    for number, code in enumerate((*bpy.data.node_groups, *bpy.data.texts)):
        code.name = f"Code {number}"


@pytest.fixture
def owner(blender):
    osl_setting.enable_osl(bpy.context.scene)
    new = bpy.data.materials.new("owner")
    material.apply_stack(new, STACK, "weidlich_wilkie")
    new.lamina.layers[1].visible = False
    return new


def test_all_can_be_renamed(owner):
    stack, count = material.stack_of(owner, hidden=True), len(owner.node_tree.nodes)
    tangent = node_with(owner, "Tangent")
    tangent.direction_type = "RADIAL"  # the user's choice
    rename_all(owner)
    assert material.stack_of(owner, hidden=True) == stack and findings(owner) == []
    material.regenerate(owner)
    layers.move_layer(owner, 0, 1)
    layers.move_layer(owner, 1, 0)
    owner.lamina.layers[1].visible = True
    owner.lamina.layers[1].visible = False
    assert material.stack_of(owner, hidden=True) == stack and findings(owner) == []
    assert len(owner.node_tree.nodes) == count and tangent.direction_type == "RADIAL"


@pytest.mark.parametrize("version", [1, 2])
def test_all_of_an_older_file_can_be_renamed(blender, version):
    facts = json.loads((DATA / f"schema_{version}.json").read_text(encoding="utf-8"))["stacks"]
    bpy.ops.wm.open_mainfile(filepath=str(DATA / f"schema_{version}.blend"))
    measured = {}
    for name in facts:
        measure_means(bpy.data.materials[name])
        measured[name] = material.stack_of(bpy.data.materials[name], hidden=True)
    bpy.ops.wm.open_mainfile(filepath=str(DATA / f"schema_{version}.blend"))
    for name in facts:
        owner = bpy.data.materials[name]
        stack = material.stack_of(owner, hidden=True)
        rename_all(owner)
        assert material.stack_of(owner, hidden=True) == stack and findings(owner) == ["one_branch"]
        material.regenerate(owner)
        assert material.stack_of(owner, hidden=True) == measured[name]
        assert not {"node_gone", "node_lost", "node_spare", "shader_gone", "shader_unlinked", "one_branch"} & set(findings(owner))
        assert all(ID_KEY in node_of(e) for e in (*owner.lamina.layers, owner.lamina.base) if owner.lamina.shows(e) or e == owner.lamina.base)


@pytest.mark.parametrize("backend", ["auto", "osl", "nodes"])
def test_a_deleted_tinted_glaze_comes_back_with_its_tint(owner, backend, tmp_path):
    """Also where it was tinted after the shader was made: at the next save, or when values rest."""
    owner.lamina.backend, owner.use_fake_user = backend, True
    ready = next(name for name in names() if load(name)[0] == "Tinted Glaze")
    layers.add_layers(owner, load(ready)[2], 0)
    glaze = node_of(owner.lamina.layers[0])
    tint = tuple(glaze.inputs["Tint"].default_value)
    assert tint != (1.0, 1.0, 1.0, 1.0)
    owner.node_tree.nodes.remove(glaze)
    mend(owner, "node_gone")
    assert tuple(node_of(owner.lamina.layers[0]).inputs["Tint"].default_value) == tint and findings(owner) == []
    for rest, tint in (
        (lambda: bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "one.blend")), (0.9, 0.5, 0.1, 1.0)),
        (lambda: (bakes.tick(), bakes.tick()), (0.1, 0.5, 0.9, 1.0)),
    ):
        node_of(owner.lamina.layers[0]).inputs["Tint"].default_value = tint
        rest()
        owner.node_tree.nodes.remove(node_of(owner.lamina.layers[0]))
        mend(owner, "node_gone")
        assert tuple(node_of(owner.lamina.layers[0]).inputs["Tint"].default_value) == pytest.approx(tint) and findings(owner) == []


def test_a_copy_takes_over_where_its_original_was_deleted(owner):
    """Shift-D copies values and tags."""
    original = node_of(owner.lamina.base)
    copy = owner.node_tree.nodes.new("ShaderNodeGroup")
    copy.node_tree, copy[ID_KEY] = original.node_tree, original[ID_KEY]
    for socket, twin in zip(original.inputs, copy.inputs):
        twin.default_value = socket.default_value
    stack = material.stack_of(owner)
    owner.node_tree.nodes.remove(original)
    assert material.stack_of(owner) == stack and ROLE not in copy
    mend(owner, "shader_unlinked")
    assert findings(owner) == [] and material.stack_of(owner) == stack
