# SPDX-License-Identifier: GPL-3.0-or-later
"""What no shader can have is refused before any work: one line with the count and the limit, at every entry."""

import json

import pytest

from lamina.addon.cli.main import run
from lamina.addon.material.limits import require_shader
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods.method import Computed
from lamina.reference_py.material.coverage import MAX_CLEAR
from lamina.reference_py.material.stack import MAX_LAYERS, Stack

MANY = {"layers": [{"kind": "dielectric", "ior": 1.5 + 0.001 * i, "roughness": 0.1} for i in range(50)], "base": {"kind": "lambert"}}
PATCHY = {"layers": [{"kind": "dielectric", "coverage": 0.5} for _ in range(MAX_CLEAR + 1)], "base": {"kind": "lambert"}}
REFUSED = {
    "many": (MANY, "50 layers need 201 shader parameters, and Cycles takes 123; choose fewer layers, or the backend nodes"),
    "patchy": (PATCHY, "4 clear layers have a coverage (layers 0, 1, 2, 3); choose at most 3"),
}


@pytest.fixture(params=REFUSED)
def refused(request, tmp_path):
    """The path of a stack that no shader can have, and what is said of it."""
    stack, told = REFUSED[request.param]
    (tmp_path / "stack.json").write_text(json.dumps(stack), encoding="utf-8")
    return tmp_path / "stack.json", told


COMMANDS = {
    "shader": lambda stack, tmp: ("shader", stack),
    "shader baked": lambda stack, tmp: ("shader", stack, "--tier", "baked"),
    "explain": lambda stack, tmp: ("explain", stack),
    "render": lambda stack, tmp: ("render", stack, "-o", tmp / "out.png"),
    "furnace": lambda stack, tmp: ("render", stack, "--scene", "furnace"),
    "apply": lambda stack, tmp: ("apply", "--stack", stack, "--object", "Cube", tmp / "no.blend", "-o", tmp / "out.blend"),
    "batch": lambda stack, tmp: ("batch", _job(tmp, stack), "-o", tmp / "out"),
    "farm": lambda stack, tmp: ("farm", _job(tmp, stack), "-o", tmp / "out"),
}


def _job(folder, stack):
    job = folder / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper", stack.name]}), encoding="utf-8")
    return job


@pytest.mark.blender
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_commands_refuse_before_any_work_and_write_nothing(blender, refused, command, tmp_path, monkeypatch, capfd):
    stack, told = refused
    arguments = command(stack, tmp_path)
    before = sorted(tmp_path.iterdir())
    monkeypatch.setattr(Computed, "result", lambda *_: pytest.fail("it began to compute"))
    assert run([str(word) for word in arguments]) == 2
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 1 and told in err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.blender
@pytest.mark.parametrize("tier", ["auto", "baked", "analytic", "weidlich_wilkie"])
def test_a_material_refuses_at_once_and_stays(blender, refused, tier, monkeypatch):
    from lamina.addon.material import material, state

    path, told = refused
    monkeypatch.setattr(state.Wanted, "make", lambda *_: pytest.fail("it began to compute"))
    owner = blender.data.materials.new("owner")
    material.apply_stack(owner, Stack.from_dict({"base": {"kind": "lambert"}}), tier)
    nodes = sorted(node.name for node in owner.node_tree.nodes)
    with pytest.raises(LaminaError) as error:
        material.apply_stack(owner, Stack.load(path), tier)
    assert (told if tier in ("auto", "baked") else told.removesuffix(", or the backend nodes")) in str(error.value)
    assert sorted(node.name for node in owner.node_tree.nodes) == nodes and len(owner.lamina.layers) == 0


@pytest.mark.blender
def test_what_was_computed_before_is_refused_alike(blender, monkeypatch):
    """A bake in the cache needs no parameters; whether there is one must not decide."""
    from lamina.addon.material import material, state

    owner = blender.data.materials.new("owner")
    monkeypatch.setattr(state.Wanted, "is_cached", lambda _: True)
    with pytest.raises(LaminaError, match="50 layers need 201 shader parameters"):
        material.apply_stack(owner, Stack.from_dict(MANY), "auto")


@pytest.mark.blender
def test_stock_nodes_take_as_many_layers_as_a_stack_may_have(blender):
    from lamina.addon.material import material

    layers = (MANY["layers"] * 2)[:MAX_LAYERS]
    owner = blender.data.materials.new("owner")
    material.apply_stack(owner, Stack.from_dict(MANY | {"layers": layers}), "analytic", "nodes")
    assert len(owner.lamina.layers) == MAX_LAYERS and owner.lamina.lobe_count > 0
    require_shader(Stack.from_dict(MANY), "nodes")


@pytest.mark.blender
def test_the_panel_says_it_in_one_line(blender, tmp_path, capfd):
    (tmp_path / "many.json").write_text(json.dumps(MANY), encoding="utf-8")
    item = blender.data.objects.new("object", blender.data.meshes.new("mesh"))
    blender.context.collection.objects.link(item)
    blender.context.view_layer.objects.active = item
    with pytest.raises(RuntimeError, match="50 layers need 201 shader parameters, and Cycles takes 123"):
        blender.ops.lamina.import_stack(filepath=str(tmp_path / "many.json"))
    assert len(blender.data.materials) == 0
