# SPDX-License-Identifier: GPL-3.0-or-later
"""Opaque layers in the render: the stack without them at 0, over them at 1, their mean between, in every tier and both backends."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from support.covered import GLAZE, GOLD, GREY, VARNISH, layered, picture
from support.goniometer import TOLERANCE, parity

from lamina.addon.material import elements, layers, material
from lamina.addon.material.shader_node import shader_of
from lamina.addon.material.state import is_settled, is_stale
from lamina.addon.rendering.measure import render_furnace, render_sun_sphere
from lamina.addon.shader.nodes.stock_nodes import stock_tables
from lamina.reference_py.lobes.closure import lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender

PAINT = {"kind": "lambert", "color": [0.1, 0.4, 0.6]}
RUST = {"kind": "oren_nayar", "color": [0.3, 0.1, 0.05], "sigma_deg": 30.0}
CHROME = {"kind": "conductor", "metal": "chromium", "roughness": 0.4}
COLORED = {"kind": "conductor", "reflectance": [0.8, 0.5, 0.3], "edge_color": [0.9, 0.9, 0.9], "roughness": 0.6, "distribution": "beckmann"}


# under a coat that is on a part of it: all base kinds as layers, each over one of another kind
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
@pytest.mark.parametrize("opaque, base", [(PAINT, GOLD), (RUST, GOLD), (CHROME, GREY), (COLORED, RUST)], ids=["paint", "rust", "chrome", "colored"])
def test_render_equals_closure_model(blender, tier, opaque, base):
    new = layered([{**VARNISH, "coverage": 0.4}, {**opaque, "coverage": 0.7}, GLAZE], base, tier)
    result = parity(new, make_model("closure_model", material.stack_of(new), method=tier).f, 45.0, 48)
    assert result.finite and result.errors.size > 500
    assert result.percentile_99 <= TOLERANCE


def test_bake_equals_closure_model(blender):
    new = layered([VARNISH, {**PAINT, "coverage": 0.4}], GREY, "baked")
    assert parity(new, make_model("closure_model", material.stack_of(new), method="baked").f, 45.0, 48).percentile_99 <= TOLERANCE


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
def test_ends_are_the_stacks_without_and_with_it(blender, tier, backend):
    def covered(coverage):
        return picture([VARNISH, {**PAINT, "coverage": coverage}], GREY, tier, backend)

    there, gone = picture([VARNISH], PAINT, tier, backend), picture([VARNISH], GREY, tier, backend)
    assert np.abs(there - gone).max() > 0.05 * there.max()
    assert np.allclose(covered(1.0), there, rtol=1e-5, atol=1e-7)
    assert np.allclose(covered(0.0), gone, rtol=1e-5, atol=1e-7)
    # Cycles drops closures of weights below 1e-5, and so half of one that is just above
    assert np.allclose(covered(0.5), 0.5 * (there + gone), rtol=1e-5, atol=1e-5 if tier == "baked" else 1e-7)


def test_without_coverage_it_hides_all_below(blender):
    for backend in ("osl", "nodes"):
        hidden = picture([VARNISH, PAINT, GLAZE], GOLD, "analytic", backend)
        assert np.allclose(hidden, picture([VARNISH], PAINT, "analytic", backend), rtol=1e-5, atol=1e-7)


def test_stock_nodes_equal_closure_model(blender):
    """Patches of unequal depth: two opaque layers, and a clear one between them."""
    new = layered([{**PAINT, "coverage": 0.3}, {**VARNISH, "coverage": 0.6}, {**CHROME, "coverage": 0.5}], GREY, "analytic", "nodes")
    lobe_set = stock_tables(make_lobe_set(material.stack_of(new), "analytic"))

    def f(wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in lobe_set.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0)

    assert parity(new, f, 45.0, 48).percentile_99 <= TOLERANCE


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_white_stays_white(blender, backend):
    white = {"kind": "lambert", "color": [1.0, 1.0, 1.0]}
    clear = {"kind": "dielectric", "roughness": 0.5}
    new = layered([{**clear, "coverage": 0.3}, {**white, "coverage": 0.4}, {**clear, "ior": 1.8}], white, "baked", backend)
    albedo, stderr = render_furnace(new, (0.0, 60.0), samples=64, size=24)
    assert np.all(np.abs(albedo - 1.0) <= 0.005 + 4.0 * stderr)


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_mask_and_color_are_live_in_a_bake(blender, backend):
    """The color of an opaque Lambert layer is one that bakes follow, as a base's is; the other patch does not read it."""
    new, alone = layered([VARNISH, {**PAINT, "coverage": 1.0}], GREY, "baked", backend), layered([VARNISH], PAINT, "baked", backend)
    node = elements.node_of(new.lamina.layers[1])
    link_value(new, node.inputs["Coverage"], "ShaderNodeValue", 0.25)
    for owner, values in ((new, node), (alone, elements.node_of(alone.lamina.base))):
        link_value(owner, values.inputs["Color"], "ShaderNodeRGB", (0.6, 0.2, 0.1, 1.0))
        material.refresh(owner, settle=True)
    assert not is_stale(new) and is_settled(new)
    assert {s.name for s in shader_of(new).inputs if s.is_linked} == {"Layer2Coverage", "Layer2Color"}
    expected = 0.25 * render_sun_sphere(alone, 45.0, 48)["radiance"] + 0.75 * picture([VARNISH], GREY, "baked", backend)
    # Cycles drops a closure of a mean weight under 1e-5, which a share of a quarter may make of it
    assert np.allclose(render_sun_sphere(new, 45.0, 48)["radiance"], expected, rtol=1e-5, atol=1e-5)


def link_value(owner, socket, kind, value):
    source = owner.node_tree.nodes.new(kind)
    source.outputs[0].default_value = value
    owner.node_tree.links.new(source.outputs[0], socket)


def test_add_reorder_copy_and_choices_of_an_opaque_layer(blender):
    new = layered([VARNISH], GOLD, "weidlich_wilkie")
    layers.add_layer(new, "conductor", 1)
    layer = new.lamina.layers[1]
    node = elements.node_of(layer)
    assert node.inputs["Coverage"].default_value == 1.0 and "Coverage" not in elements.node_of(new.lamina.base).inputs
    # a metal that is picked for the layer is written into its sockets, and the base keeps its own
    gold = tuple(elements.node_of(new.lamina.base).inputs["IOR"].default_value)
    layer.metal = "copper"
    assert material.stack_of(new).layers[1]["metal"] == "copper" and material.stack_of(new).base["metal"] == "gold"
    assert tuple(elements.node_of(new.lamina.base).inputs["IOR"].default_value) == gold != tuple(node.inputs["IOR"].default_value)
    layer.use_coverage = True
    node.inputs["Coverage"].default_value = 0.5
    layers.move_layer(new, 1, 0)
    assert elements.node_of(new.lamina.layers[0]) == node
    layers.paste_layers(new, layers.copied_text(new, [0]), 0)
    first, second, _ = material.stack_of(new).layers
    assert first.values == second.values and first["coverage"] == 0.5
    assert shader_of(new).inputs["Layer2Coverage"].links[0].from_node == node
