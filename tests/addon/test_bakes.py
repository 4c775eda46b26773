# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes beside the window: a material is live at once, baked a little later, and live again when a value changes."""

import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("bpy")

from lamina.addon.jobs import bakes, conversions, prefetch
from lamina.addon.jobs.prefetch import Baker
from lamina.addon.material import elements, material
from lamina.addon.material.hand_over import MIX, is_handed_over
from lamina.addon.material.live_values import live_values
from lamina.addon.material.reading import stack_of
from lamina.addon.material.roles import ROLE
from lamina.addon.material.shader_node import shader_of
from lamina.addon.material.state import Wanted, is_settled, is_stale, lags, wanted_lobes
from lamina.addon.shader.nodes.node_groups import lobe_group
from lamina.addon.shader.nodes.stock_nodes import eevee_stock_tables, stock_tables
from lamina.reference_py.exchange import hand_over as solving
from lamina.reference_py.lobes import cache
from lamina.reference_py.material import presets
from lamina.reference_py.material.place import Place
from lamina.study.suite import suite_stack

pytestmark = pytest.mark.blender

COATED = suite_stack("plastic_grey_0")


@pytest.fixture
def window(blender, monkeypatch, tmp_path):
    """Blender as with a window: nothing waits for a bake. Nothing baked before is known."""
    cache.keep_in(tmp_path)
    monkeypatch.setenv("LAMINA_CACHE", str(tmp_path))
    monkeypatch.setattr(cache, "_memory", {})
    yield blender
    conversions.stop()
    if bakes._state.bake is not None:
        bakes._state.bake.cancel()
        bakes._state.bake = None
    cache.keep_in(None)


def coated(bpy, tier="baked"):
    made = bpy.data.materials.new("coated")
    material.apply_stack(made, COATED, tier)
    return made


def test_without_a_window_a_medium_that_scatters_is_baked_once_and_not_for_what_stands_in(window):
    made = window.data.materials.new("celadon")
    material.apply_stack(made, presets.load("celadon"), "auto")
    assert is_settled(made) and list(cache._memory) == [wanted_lobes(made).key]


def is_live(owner) -> bool:
    """Whether the shader reads the sockets."""
    return any(socket.is_linked for socket in shader_of(owner).inputs)


def rest(owner) -> None:
    """Look until there is nothing left to do."""
    limit = time.monotonic() + 120.0
    while bakes.tick() is not None:
        assert time.monotonic() < limit
        time.sleep(0.05)


def test_a_material_is_live_until_its_bake_is_done(window):
    owner = coated(window, "auto")
    assert is_live(owner) and not is_settled(owner)
    bakes.tick()
    bakes.tick()
    assert bakes.bake_of(owner) is not None
    rest(owner)
    assert is_settled(owner) and not is_stale(owner)
    assert "error" in owner.lamina.note and bakes.bake_of(owner) is None


def shown_by(owner, engine: str):
    """The branch that an engine shows: EEVEE has an output of its own, beside the one for all renderers."""
    if engine == "EEVEE":
        return owner.node_tree.get_output_node(engine).inputs["Surface"].links[0].from_node
    hand_over = owner.node_tree.get_output_node(engine).inputs["Surface"].links[0].from_node
    assert hand_over[ROLE] == MIX and not hand_over.inputs[0].is_linked and hand_over.inputs[0].default_value == 0.0
    mix = hand_over.inputs[1].links[0].from_node
    assert mix.inputs[0].default_value == 0.0 and mix.inputs[0].links[0].from_node.inputs[0].links[0].from_socket.name == "Live"
    return mix.inputs[2].links[0].from_node


def test_eevee_shows_the_same_lobes_in_stock_nodes(window):
    owner = coated(window)
    rest(owner)
    preview = shown_by(owner, "EEVEE")
    assert preview.bl_idname == "ShaderNodeGroup" and shown_by(owner, "CYCLES") == shader_of(owner)
    tables = preview.node_tree.name  # a removed group's place may be the next one's
    made = wanted_lobes(owner).make()
    assert preview.node_tree == lobe_group(eevee_stock_tables(made, stock_tables(made)))
    elements.node_of(owner.lamina.base).inputs["Color"].default_value = (0.1, 0.1, 0.1, 1.0)
    rest(owner)
    assert shown_by(owner, "EEVEE").node_tree.name != tables
    owner.lamina.tier = "weidlich_wilkie"
    live = shown_by(owner, "EEVEE").node_tree.name
    elements.node_of(owner.lamina.base).inputs["Color"].default_value = (0.4, 0.1, 0.1, 1.0)
    assert lags(owner)
    rest(owner)
    assert shown_by(owner, "EEVEE").node_tree.name != live and not lags(owner)


def test_a_changed_value_is_shown_at_once_and_baked_when_it_rests(window):
    owner = coated(window)
    rest(owner)
    assert not is_live(owner)
    color = elements.node_of(owner.lamina.base).inputs["Color"]
    for value in (0.1, 0.2):
        color.default_value = (value, value, value, 1.0)
        bakes.tick()
        assert is_live(owner) and bakes.bake_of(owner) is None
    rest(owner)
    assert not is_live(owner) and is_settled(owner)
    color.default_value = (0.1, 0.1, 0.1, 1.0)
    bakes.tick()
    assert is_live(owner)


def test_what_was_baked_before_is_there_at_once(window):
    rest(coated(window))
    cache._memory.clear()  # as in a new session: the folder remains
    owner = coated(window)
    assert not is_live(owner) and is_settled(owner)


def test_a_save_without_a_window_bakes_all_that_it_needs_in_as_many_processes_as_there_are_cores(window, monkeypatch, tmp_path, capsys):
    started, asked = [], []
    monkeypatch.setattr(prefetch, "Baker", lambda left: started.append(Baker(left)) or started[-1])
    monkeypatch.setattr(Wanted, "request", lambda wanted, own=Wanted.request: asked.append(wanted.key) or own(wanted))
    monkeypatch.setattr(prefetch.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(solving, "to_principled", None)  # they solve the hand-overs too, next to each stack's truth
    owners = [coated(window) for _ in range(4)]
    for i, owner in enumerate(owners):
        elements.node_of(owner.lamina.base).inputs["Color"].default_value = (0.5, 0.2, 0.1 * min(i, 2), 1.0)
    window.ops.wm.save_as_mainfile(filepath=str(tmp_path / "many.blend"))
    assert len(started) == 2 and all(baker.is_done for baker in started)
    assert len(set(asked)) == len(asked) == 3 and "3 of 3 bakes are done" in capsys.readouterr().out
    assert all(is_settled(owner) and not is_live(owner) and is_handed_over(owner, stack_of(owner)) for owner in owners)


def test_nothing_stands_in_for_a_bake_that_is_waited_for(window, monkeypatch):
    monkeypatch.setattr(material, "provisional", None)
    made = window.data.materials.new("coated")
    material.apply_stack(made, COATED, "auto", settle=True)
    assert is_settled(made) and is_handed_over(made, stack_of(made))


def test_a_bake_that_fails_leaves_the_next_to_its_process(window, monkeypatch):
    monkeypatch.setattr(prefetch.os, "cpu_count", lambda: 1)
    own, wrong, told = Wanted.request, Wanted(COATED, "baked"), []
    right = Wanted(suite_stack("plastic_white_smooth"), "baked")
    monkeypatch.setattr(Wanted, "request", lambda one: own(one).replace('"baked"', '"none"' if one is wrong else '"baked"'))
    prefetch.prefetch([wrong, right], [], told.append)
    assert right.is_cached() and not wrong.is_cached() and told == ["1 of 2 bakes are done"]


def test_a_cancelled_bake_stays_live_until_asked_for(window):
    owner = coated(window)
    bakes.tick()
    bakes.tick()
    bakes.cancel(owner)
    assert bakes.failed(owner) == "cancelled"
    rest(owner)
    assert is_live(owner) and bakes.failed(owner) == "cancelled"
    bakes.retry(owner)
    rest(owner)
    assert not is_live(owner) and not bakes.failed(owner)


def test_a_worker_that_cannot_start_is_named_and_costs_nothing(window, monkeypatch, capsys):
    owner = coated(window)
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    for _ in range(4):
        bakes.tick()
    assert "cannot start a bake with /no/such/python" in owner.lamina.problem
    assert is_live(owner)


def test_a_texture_on_a_layer_is_followed(window):
    """What is linked is followed by tables over it; the note says so."""
    owner = coated(window, "auto")
    rest(owner)
    tree = owner.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], elements.node_of(owner.lamina.layers[0]).inputs["Tint"])
    assert live_values(owner) == (Place(0, "tint"),)
    rest(owner)
    assert is_live(owner) and is_settled(owner)
    assert "baked over the tint of layer 0" in owner.lamina.note


def test_keyframes_and_drivers_are_live_values(window):
    owner = coated(window)
    node = elements.node_of(owner.lamina.layers[0])
    node.inputs["Roughness"].keyframe_insert("default_value", frame=1)
    node.inputs["Thickness"].driver_add("default_value")
    assert live_values(owner) == (Place(0, "roughness"), Place(0, "thickness"))


def test_opening_an_older_file_changes_nothing_until_an_edit(window):
    path = Path(__file__).resolve().parents[1] / "data" / "schema_2.blend"
    window.ops.wm.open_mainfile(filepath=str(path))
    before = {m.name: sorted(n.name for n in m.node_tree.nodes) for m in window.data.materials if m.lamina.is_layered}
    rest_all()
    assert before == {name: sorted(n.name for n in window.data.materials[name].node_tree.nodes) for name in before}
    paint = window.data.materials["paint"]
    material.regenerate(paint)
    rest_all()
    assert not lags(paint) and paint.lamina.schema_version > 2


def rest_all() -> None:
    limit = time.monotonic() + 60.0
    while bakes.tick() is not None:
        assert time.monotonic() < limit
        time.sleep(0.05)
