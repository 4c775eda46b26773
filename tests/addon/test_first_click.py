# SPDX-License-Identifier: GPL-3.0-or-later
"""What a click would wait for is done before it: the script of one plain layer more, which is compiled while nothing happens."""

import pytest

pytest.importorskip("bpy")

from support.stacks import coat, lambert, on_a_plane, stack

from lamina.addon.jobs import bakes
from lamina.addon.material import first_click, layers, script_node
from lamina.addon.material.elements import node_of

pytestmark = pytest.mark.blender

PLAIN = stack(coat(0.2), coat(0.1), base=lambert(0.5))
MASKED = stack(coat(0.2, coverage=0.5), coat(0.1, distribution="beckmann"), base=lambert(0.5))


@pytest.fixture
def compiled(monkeypatch):
    """The shaders that were compiled."""
    names, compile_it = [], script_node._compile
    monkeypatch.setattr(script_node, "_compile", lambda shader: names.append(shader.name) or compile_it(shader))
    script_node._compiled.clear()
    return names


@pytest.mark.parametrize("tier", ["auto", "analytic", "weidlich_wilkie"])
@pytest.mark.parametrize(("shown", "selected"), [(PLAIN, 0), (MASKED, 0), (MASKED, 1)])
def test_a_plain_layer_more_is_compiled_before_the_click(blender, compiled, tier, shown, selected):
    owner = on_a_plane(blender, shown, tier)
    owner.lamina.active_layer = selected
    first_click.compile_next(owner)
    assert len(compiled) == 2
    layers.add_layer(owner, "dielectric", selected)
    assert len(compiled) == 2


def test_it_is_done_once_values_rest_and_for_the_active_object_alone(blender, compiled):
    other, owner = on_a_plane(blender, MASKED, "analytic"), on_a_plane(blender, PLAIN, "analytic")
    assert blender.context.object.active_material == owner
    bakes._state.touched = {owner.name_full, other.name_full}
    bakes.tick()
    assert len(compiled) == 2
    bakes.tick()
    assert len(compiled) == 3
    layers.add_layer(owner, "dielectric", 0)
    assert len(compiled) == 3


def test_what_shows_no_script_or_is_wrong_is_left_to_the_click(blender, compiled):
    owner = on_a_plane(blender, PLAIN, "analytic")
    node_of(owner.lamina.base).inputs["Color"].default_value = (2.0, 0.0, 0.0, 1.0)
    first_click.compile_next(owner)
    other = on_a_plane(blender, PLAIN, "analytic")
    other.lamina.backend = "nodes"
    first_click.compile_next(other)
    assert len(compiled) == 1


@pytest.mark.parametrize("engine", ["CYCLES", "BLENDER_WORKBENCH"])
def test_blender_compiles_nothing_besides(blender, monkeypatch, compiled, engine):
    """With Cycles it would as soon as a node has its text."""
    import cycles.osl

    blender.context.scene.render.engine = engine
    monkeypatch.setattr(cycles.osl, "osl_compile", lambda *_: pytest.fail("compiled twice"))
    owner = on_a_plane(blender, PLAIN, "analytic")
    assert len(compiled) == 1
    layers.remove_layer(owner, 0)
    layers.add_layer(owner, "dielectric", 0)
    assert len(compiled) == 2
