# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of another file, linked and as library overrides: nothing of Lamina changes them, and everything works once they are local."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.check import check
from lamina.addon.jobs import (
    bakes,
    staleness,
)
from lamina.addon.material import layers, material, osl_setting
from lamina.addon.material.elements import node_of
from lamina.addon.material.snapshot import snapshot
from lamina.addon.rendering.geometry import sphere_mesh
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({
    "name": "Painted",
    "layers": [{"kind": "dielectric", "name": "Clear", "roughness": 0.1}, {"kind": "dielectric", "name": "Paint", "roughness": 0.5}],
    "base": {"kind": "lambert", "color": [0.05, 0.2, 0.33]},
})  # fmt: skip
# (tier, backend): values live, held by both branches, and by stock nodes alone
MADE = {"live": ("weidlich_wilkie", "osl"), "held": ("analytic", "auto"), "nodes": ("analytic", "nodes")}
OPERATORS = {
    "apply_preset": {"preset": "clean_copper"}, "layer_add": {}, "layer_add_ready": {}, "layer_duplicate": {}, "layer_remove": {},
    "layer_solo": {"index": 0}, "layer_move": {"direction": "DOWN"}, "layer_paste": {}, "set_base": {"kind": "oren_nayar"}, "regenerate": {}, "retry_bake": {},
    "mend": {"finding": "shader_stale//"}, "mend_all": {}, "convert_principled": {}, "import_stack": {},
}  # fmt: skip
PROPERTIES = {"tier": "weidlich_wilkie", "backend": "auto", "tolerance": 9.0, "stack_name": "Mine"}


@pytest.fixture(scope="module")
def library(registered_lamina, tmp_path_factory) -> str:
    """A file with the materials of MADE."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    osl_setting.enable_osl(bpy.context.scene)
    for name, (tier, backend) in MADE.items():
        material.apply_stack(bpy.data.materials.new(name), STACK, tier, backend)
    path = str(tmp_path_factory.mktemp("library") / "library.blend")
    bpy.data.libraries.write(path, set(bpy.data.materials), fake_user=True)
    return path


@pytest.fixture(params=["linked", "override"])
def brought(request, library, blender):
    """The materials of MADE from another file, on objects: Blender 5.3 counts what nothing uses as indirectly linked."""
    osl_setting.enable_osl(bpy.context.scene)
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.materials = list(MADE)
    found = {}
    for each in wanted.materials:
        ball = bpy.data.objects.new(each.name, sphere_mesh(each.name))
        ball.data.materials.append(each)
        bpy.context.scene.collection.objects.link(ball)
        if request.param == "override":
            each = each.override_create(remap_local_usages=True)
            node_of(each.lamina.base).inputs["Color"].default_value = (0.9, 0.1, 0.1, 1.0)
        found[ball.name] = each
    bpy.context.view_layer.update()
    return found


def plain(value):
    return tuple(np.ravel(value).tolist()) if hasattr(value, "__len__") and not isinstance(value, str) else value


def facts(owner) -> list:
    """Everything of a material that Lamina sets."""
    tree = owner.node_tree
    code = [getattr(node, name, None) for node in tree.nodes for name in ("node_tree", "script")]
    return [
        {name: value for name, value in snapshot(owner.lamina).items() if name not in ("problem", "packed_problem")},
        dict(tree.items()),
        [(n.name, n.label, n.mute, tuple(n.location), getattr(n, "bytecode_hash", ""), dict(n.items())) for n in tree.nodes],
        [(n.name, s.identifier, plain(getattr(s, "default_value", None))) for n in tree.nodes for s in n.inputs],
        sorted((link.from_node.name, link.from_socket.name, link.to_node.name, link.to_socket.identifier) for link in tree.links),
        [c and c.name_full for c in code],
        (tuple(owner.diffuse_color), owner.roughness, owner.metallic),
    ]


def test_no_operator_changes_them(brought):
    for name, owner in brought.items():
        before, count = facts(owner), len(bpy.data.materials)
        bpy.context.view_layer.objects.active = bpy.data.objects[name]
        bpy.ops.lamina.layer_copy()
        for operator, options in OPERATORS.items():
            assert hasattr(bpy.types, f"LAMINA_OT_{operator}")
            try:
                getattr(bpy.ops.lamina, operator)(**options)
            except RuntimeError as error:
                assert operator in ("convert_principled", "import_stack", "mend") or "make it local" in str(error), operator
            else:
                assert operator == "mend_all", operator
            assert facts(owner) == before and len(bpy.data.materials) == count, operator


def test_no_property_changes_them_and_the_console_says_why(brought, capsys):
    for owner in brought.values():
        before = facts(owner)
        for name, value in PROPERTIES.items():
            setattr(owner.lamina, name, value)
            assert facts(owner) == before, name
        owner.lamina.layers[0].name = "Mine"
        owner.lamina.layers[0].visible = False
        assert facts(owner) == before and not owner.lamina.problem
        assert capsys.readouterr().out.count("make it local to edit it") == len(PROPERTIES) + 2


def test_neither_a_save_nor_the_timer_nor_a_call_changes_them(brought, tmp_path, capsys):
    before = {name: facts(owner) for name, owner in brought.items()}
    bakes.tick()
    for owner in brought.values():
        for call in (material.refresh, material.refresh_stock, material.regenerate, bakes.retry, lambda m: layers.remove_layer(m, 0)):
            with pytest.raises(LaminaError, match="make it local"):
                call(owner)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "here.blend"))
    staleness.announce(bpy.context.scene)
    assert {name: facts(owner) for name, owner in brought.items()} == before
    said = [line for line in capsys.readouterr().out.splitlines() if "renders old values" in line]
    overridden = brought["held"].override_library is not None
    assert len(said) == (2 if overridden else 0) and all("make it local" in line for line in said)


def test_local_ones_are_as_if_made_here(brought, tmp_path):
    overridden = brought["held"].override_library is not None
    for name, owner in brought.items():
        local = owner.make_local()
        assert local.library is None and local.override_library is None
        color = tuple(node_of(local.lamina.base).inputs["Color"].default_value)[:3]
        assert color == pytest.approx((0.9, 0.1, 0.1) if overridden else (0.05, 0.2, 0.33))
        layers.add_layer(local, "dielectric", 0)
        local.lamina.tier = "analytic"
        local.lamina.backend = "auto"
        assert not local.lamina.problem and local.lamina.tier == "analytic", name
        assert [f.code for f in check.find(local, bpy.context.scene, bpy.context.preferences) if f.level != check.NOTE] == []
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "here.blend"))
