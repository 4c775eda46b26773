# SPDX-License-Identifier: GPL-3.0-or-later
"""Covered layers in the render: the patches at 0 and 1, their mean between, live in every tier and both backends."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from support.covered import GLAZE, GOLD, GREY, VARNISH, layered, picture
from support.goniometer import TOLERANCE, parity

from lamina.addon.material import elements, material
from lamina.addon.material.shader_node import shader_of
from lamina.addon.material.state import is_settled, is_stale
from lamina.addon.rendering.measure import render_furnace, render_sun_sphere
from lamina.addon.shader.nodes.stock_nodes import stock_tables
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.closure import lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender


# A bake has a lobe set for each of the four patches.
@pytest.mark.parametrize("tier, base", [("weidlich_wilkie", GREY), ("weidlich_wilkie", GOLD), ("analytic", GREY), ("analytic", GOLD), ("baked", GREY)])
def test_render_equals_mirror(blender, tier, base):
    new = layered([{**VARNISH, "coverage": 0.4}, {**GLAZE, "coverage": 0.7}], base, tier)
    result = parity(new, make_model("closure_model", material.stack_of(new), method=tier).f, 45.0, 64)
    print(f"{tier}: 99th percentile {result.percentile_99:.1e}")
    assert result.finite and result.errors.size > 1000
    assert result.percentile_99 <= TOLERANCE


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_ends_are_the_patches_and_the_middle_is_their_mean(blender, tier, backend):
    def covered(coverage):
        return picture([{**VARNISH, "coverage": coverage}, GLAZE], GREY, tier, backend)

    there, gone = picture([VARNISH, GLAZE], GREY, tier, backend), picture([GLAZE], GREY, tier, backend)
    assert np.abs(there - gone).max() > 0.05 * there.max()
    assert np.allclose(covered(1.0), there, rtol=1e-5, atol=1e-7)
    assert np.allclose(covered(0.0), gone, rtol=1e-5, atol=1e-7)
    assert np.allclose(covered(0.5), 0.5 * (there + gone), rtol=1e-5, atol=1e-7)


def test_stock_nodes_equal_mirror(blender):
    new = layered([{**VARNISH, "coverage": 0.4}, {**GLAZE, "coverage": 0.7}], GREY, "weidlich_wilkie", "nodes")
    lobe_set = stock_tables(make_lobe_set(material.stack_of(new), "weidlich_wilkie"))

    def f(wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in lobe_set.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0)

    assert parity(new, f, 45.0, 64).percentile_99 <= TOLERANCE


@pytest.mark.parametrize("tier", ["analytic", "baked"])
def test_white_stays_white(blender, tier):
    clear = {"kind": "dielectric", "roughness": 0.5}
    new = layered([{**clear, "coverage": 0.3}, {**clear, "ior": 1.8, "coverage": 0.5}], {"kind": "lambert", "color": [1, 1, 1]}, tier)
    albedo, stderr = render_furnace(new, (0.0, 60.0), samples=64, size=24)
    print(f"{tier}: albedo {albedo[:, 0]} +- {stderr[:, 0]}")
    assert np.all(np.abs(albedo - 1.0) <= 0.005 + 4.0 * stderr)


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_a_mask_is_live_in_a_bake(blender, backend):
    new = layered([{**VARNISH, "coverage": 1.0}], GREY, "baked", backend)
    node = elements.node_of(new.lamina.layers[0])
    mask = new.node_tree.nodes.new("ShaderNodeValue")
    mask.outputs[0].default_value = 0.0
    new.node_tree.links.new(mask.outputs[0], node.inputs["Coverage"])
    assert not is_stale(new) and is_settled(new)
    shader = shader_of(new)
    assert shader.inputs["Layer1Coverage"].links[0].from_node == node
    assert [s.name for s in shader.inputs if s.is_linked] == ["Layer1Coverage"]
    bare = picture([], GREY, "baked", backend)
    assert np.allclose(render_sun_sphere(new, 45.0, 48)["radiance"], bare, rtol=1e-5, atol=1e-7)


def test_too_many_covered_layers_leave_all_as_it_was(blender):
    new = layered([{**GLAZE, "coverage": 0.5}] * 3 + [GLAZE], GREY, "weidlich_wilkie")
    script = shader_of(new).script
    new.lamina.layers[3].use_coverage = True
    assert "4 clear layers have a coverage (layers 0, 1, 2, 3); choose at most 3" in new.lamina.problem
    assert shader_of(new).script == script
    with pytest.raises(LaminaError, match="choose at most 3"):
        make_lobe_set(material.stack_of(new), "analytic")
