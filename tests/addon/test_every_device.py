# SPDX-License-Identifier: GPL-3.0-or-later
"""One .blend with OSL on, with OSL off and in a Blender without OSL: never black, and the pictures agree."""

import numpy as np
import pytest
from support.sunlit_ball import AGREE, picture, stage

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import environment
from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material import osl_setting
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import node_with
from lamina.addon.material.shader_node import backend_of
from lamina.addon.material.state import is_settled, is_stale, lacks_branch, lags
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

GLAZE = {"kind": "dielectric", "name": "Glaze", "roughness": 0.2, "tint": [0.6, 0.8, 0.9]}
STACKS = {
    "coated paint": Stack.from_dict({"layers": [GLAZE], "base": {"kind": "lambert", "color": [0.6, 0.3, 0.2]}}),
    "two coats": Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.1}, GLAZE], "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3}}),
    "masked": Stack.from_dict({"layers": [{**GLAZE, "coverage": 0.5}], "base": {"kind": "lambert", "color": [0.6, 0.3, 0.2]}}),
}  # fmt: skip


def without(monkeypatch) -> None:
    """From here on this Blender is one that was built without OSL."""
    monkeypatch.setattr(environment, "osl_available", lambda: (False, environment.NO_OSL))
    monkeypatch.setattr(environment, "renders_osl", lambda: False)


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("name", STACKS)
def test_one_file_in_all_surroundings(blender, tmp_path, monkeypatch, name, tier):
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS[name], tier)
    path = stage(owner, tmp_path)
    bpy.ops.wm.open_mainfile(filepath=path)
    owner = bpy.data.materials["owner"]
    assert is_settled(owner) and not is_stale(owner) and not lags(owner)
    on, off = picture(tmp_path, True), picture(tmp_path, False)
    script, text = node_with(owner, "osl"), node_with(owner, "osl").script.name
    assert on.min() > 0.01 and np.all(np.abs(off / on - 1.0) < AGREE)
    script.mute = True
    assert picture(tmp_path, True) == pytest.approx(off, rel=1e-6), "a muted script lets the stock nodes show"
    script.mute = False
    # a Blender without OSL opens and saves it: nothing changes
    without(monkeypatch)
    assert picture(tmp_path, False) == pytest.approx(off, rel=1e-6)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert node_with(owner, "osl").script.name == text
    monkeypatch.undo()
    assert picture(tmp_path, True) == pytest.approx(on, rel=1e-6)


def test_old_values_never_show_over_fresh_ones(blender, tmp_path, monkeypatch):
    """Edited without OSL, a script of other values is dropped; a Blender with OSL shows the stock nodes and makes it again."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "baked")
    path = stage(owner, tmp_path)
    before = picture(tmp_path, True)
    without(monkeypatch)
    node_of(owner.lamina.base).inputs["Color"].default_value = (0.1, 0.5, 0.1, 1.0)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert not is_stale(owner) and backend_of(owner) == "nodes"
    fresh = picture(tmp_path, False)
    monkeypatch.undo()
    bpy.ops.wm.open_mainfile(filepath=path)
    owner = bpy.data.materials["owner"]
    assert lacks_branch(owner)
    assert "one_branch" in [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]
    assert picture(tmp_path, True) == pytest.approx(fresh, rel=1e-6) and abs(fresh[0] / before[0] - 1.0) > 0.3
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert not lacks_branch(owner) and node_with(owner, "osl").bytecode
    again, other = picture(tmp_path, True), bpy.data.materials.new("other")
    materials.apply_stack(other, materials.stack_of(owner), "baked")
    bpy.data.objects["ball"].data.materials[0] = other
    assert again == pytest.approx(picture(tmp_path, True), rel=1e-6) and again == pytest.approx(fresh, rel=2 * AGREE)


def test_a_script_that_reads_its_values_stays_right_without_osl(blender, tmp_path, monkeypatch):
    """Of a live tier the script reads the new values, so it is kept, and the stock nodes follow."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic")
    path = stage(owner, tmp_path)
    without(monkeypatch)
    node_of(owner.lamina.base).inputs["Color"].default_value = (0.1, 0.5, 0.1, 1.0)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert node_with(owner, "osl") is not None
    off = picture(tmp_path, False)
    monkeypatch.undo()
    assert picture(tmp_path, True) == pytest.approx(off, rel=AGREE)


def test_a_script_without_bytecode_lets_the_stock_nodes_show(blender, tmp_path):
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic")
    stage(owner, tmp_path)
    off = picture(tmp_path, False)
    script = node_with(owner, "osl")
    script.bytecode = script.bytecode_hash = ""  # with a hash and no bytecode Blender 5.2 and 5.3 abort
    assert picture(tmp_path, True) == pytest.approx(off, rel=1e-6)


def test_what_comes_to_a_scene_without_osl_shows(blender, tmp_path):
    """Appended or linked into a scene that was never told of OSL, and a second scene of the file."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic")
    path = stage(owner, tmp_path)
    expected = picture(tmp_path, True)
    for link in (False, True):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        with bpy.data.libraries.load(path, link=link) as (_, wanted):
            wanted.materials = ["owner"]
        stage(wanted.materials[0], tmp_path / str(link) if (tmp_path / str(link)).mkdir() is None else None)
        assert picture(tmp_path, False) == pytest.approx(expected, rel=AGREE)


def test_each_channel_is_judged(blender, tmp_path):
    """A deliberate fault: stock nodes of other values are seen by the comparison."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic")
    stage(owner, tmp_path)
    on = picture(tmp_path, True)
    node_of(owner.lamina.base).inputs["Color"].default_value = (0.6, 0.3, 0.25, 1.0)
    assert lags(owner) and not np.all(np.abs(picture(tmp_path, True) / on - 1.0) < AGREE)


def test_a_scene_that_shows_scripts_alone_black_is_told(blender, tmp_path, capsys):
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic", "osl")
    stage(owner, tmp_path)
    assert picture(tmp_path, False).max() == 0.0
    assert "owner: renders black: it is an OSL script alone" in capsys.readouterr().out
    owner.lamina.backend = "auto"
    assert picture(tmp_path, False).min() > 0.01
    assert "black" not in capsys.readouterr().out
    assert osl_setting.why_stock_nodes(bpy.context.scene, bpy.context.preferences) == "Open Shading Language is switched off"


def animated(backend: str):
    """A coated paint of a backend whose roughness has keyframes at frames 1 and 10."""
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic", backend)
    roughness = node_of(owner.lamina.layers[0]).inputs["Roughness"]
    for frame, value in ((1, 0.1), (10, 0.9)):
        roughness.default_value = value
        roughness.keyframe_insert("default_value", frame=frame)
    return owner


@pytest.mark.parametrize("backend", ["auto", "nodes"])
def test_a_render_without_osl_says_that_animation_stands_still(blender, tmp_path, capsys, backend):
    """And does not ask for a save, which is right for one frame alone; that is said of a value that somebody changed."""
    owner = animated(backend)
    path = stage(owner, tmp_path)
    bpy.context.scene.frame_set(1)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.context.scene.frame_set(10)
    capsys.readouterr()
    picture(tmp_path, False)
    assert "owner: its animation stands still" in (said := capsys.readouterr().out) and "save" not in said
    node_of(owner.lamina.base).inputs["Color"].default_value = (0.1, 0.5, 0.1, 1.0)
    picture(tmp_path, False)
    assert "owner: renders old values" in capsys.readouterr().out


@pytest.mark.parametrize("backend, remedy", [("auto", "Open Shading Language is switched off in Scene"), ("nodes", "in the backend Automatic")])
def test_an_animation_that_stands_still_is_told_at_the_frame_that_it_was_saved_at(blender, tmp_path, capsys, backend, remedy):
    """Where nothing lags yet: Blender asks once for all frames. Not where OSL follows."""
    owner = animated(backend)
    stage(owner, tmp_path)
    bpy.context.scene.frame_set(1)
    capsys.readouterr()
    picture(tmp_path, False)
    said = capsys.readouterr().out
    assert said.count("owner: its animation stands still, as stock nodes cannot follow") == 1 and "Roughness; " in said and remedy in said
    picture(tmp_path, True)
    assert ("stands still" in capsys.readouterr().out) == (backend == "nodes")


def test_nothing_drifts_between_blenders_with_osl_and_without(blender, tmp_path, monkeypatch, capsys):
    """Opened, saved and rendered in turns, ten times: textures stay, nothing is told, and each has the pictures of its first turn."""
    pattern = bpy.data.images.new("pattern", 8, 8)
    pattern.pixels.foreach_set(np.random.default_rng(1).uniform(0.1, 0.9, 8 * 8 * 4).astype(np.float32))
    pattern.pack()
    owner = bpy.data.materials.new("owner")
    materials.apply_stack(owner, STACKS["coated paint"], "analytic")
    for element, label in ((owner.lamina.layers[0], "Roughness"), (owner.lamina.base, "Color")):
        texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = pattern
        owner.node_tree.links.new(texture.outputs["Color"], node_of(element).inputs[label])
    path = stage(owner, tmp_path)
    bpy.ops.wm.save_mainfile()
    first: dict[bool, tuple] = {}
    for turn in range(10):
        osl = turn % 2 == 0
        with monkeypatch.context() as patch:
            if not osl:
                without(patch)
            bpy.ops.wm.open_mainfile(filepath=path)
            tree = bpy.data.materials["owner"].node_tree
            capsys.readouterr()
            seen = (picture(tmp_path, osl).tobytes(), sorted((link.from_node.name, link.to_node.name, link.to_socket.name) for link in tree.links))
            bpy.ops.wm.save_mainfile()
            assert "Lamina: " not in capsys.readouterr().out, turn
        assert seen == first.setdefault(osl, seen), turn
    assert first[True][1] == first[False][1] and first[True][0] != first[False][0]
