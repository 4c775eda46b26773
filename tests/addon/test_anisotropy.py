# SPDX-License-Identifier: GPL-3.0-or-later
"""Anisotropic surfaces in the render: equal to the mirror at every azimuth, along the material's Tangent node."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from lamina.addon.nodes import material  # noqa: E402
from lamina.addon.nodes.shader_node import shader_of  # noqa: E402
from lamina.addon.network.stock_nodes import HAS_DIELECTRIC  # noqa: E402
from lamina.addon.rendering.measure import render_sun_sphere  # noqa: E402
from lamina.reference_py.models import make_model  # noqa: E402
from lamina.reference_py.network import make_network  # noqa: E402
from lamina.reference_py.network.closure import lobe_f  # noqa: E402
from lamina.reference_py.network.tabulate import tabulate  # noqa: E402
from lamina.reference_py.stack import Stack  # noqa: E402
from support.goniometer import TOLERANCE, tangent_parity  # noqa: E402

pytestmark = pytest.mark.blender

COAT = {"kind": "dielectric", "ior": 1.5, "roughness": 0.5}
BRUSHED = {"anisotropy": 0.8, "rotation": 0.1}
STEEL = {"kind": "conductor", "metal": "iron", "roughness": 0.6}
GREY = {"kind": "lambert", "color": [0.5, 0.4, 0.3]}
STACKS = {
    "bare metal": ([], {**STEEL, **BRUSHED}),
    "coat over metal": ([{**COAT, "tint": [0.9, 0.6, 0.5]}], {**STEEL, **BRUSHED, "distribution": "beckmann"}),
    "coat": ([{**COAT, **BRUSHED}], GREY),
    "all": ([{**COAT, "anisotropy": 0.5}, {**COAT, "ior": 1.8, **BRUSHED}], {**STEEL, "anisotropy": 1.0, "rotation": 0.25}),
    "half covered": ([{**COAT, **BRUSHED, "coverage": 0.5}], {**STEEL, **BRUSHED}),
    "narrow": ([], {**STEEL, "roughness": 0.15, **BRUSHED}),
}


def shown(layers, base, tier, backend="osl"):
    """A material along the sphere's own meridians, which run from pole to pole on y."""
    import bpy

    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, Stack.from_dict({"layers": layers, "base": base}), tier, backend)
    tangent = new.node_tree.nodes["Lamina Tangent"]
    tangent.direction_type, tangent.axis = "RADIAL", "Y"
    return new


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
@pytest.mark.parametrize("name", STACKS)
def test_render_equals_mirror(blender, tier, name):
    new = shown(*STACKS[name], tier)
    result = tangent_parity(new, make_model("mirror", material.stack_of(new), tier=tier).f, 45.0, 64)
    print(f"{tier}, {name}: 99th percentile {result.percentile_99:.1e} of {result.errors.size}")
    assert result.finite and result.errors.size > 300
    assert result.percentile_99 <= TOLERANCE


def test_the_wrong_azimuth_is_caught(blender):
    new = shown(*STACKS["bare metal"], "weidlich_wilkie")
    turned = Stack.from_dict({"base": {**STEEL, **BRUSHED, "rotation": 0.11}})
    assert tangent_parity(new, make_model("mirror", turned, tier="weidlich_wilkie").f, 45.0, 64).percentile_99 > 100 * TOLERANCE


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
def test_anisotropy_0_renders_as_none(blender, tier):
    import bpy

    plain = bpy.data.materials.new("plain")
    material.apply_stack(plain, Stack.from_dict({"layers": [COAT], "base": STEEL}), tier)
    zero = shown([{**COAT, "anisotropy": 0.0}], {**STEEL, "anisotropy": 0.0, "rotation": 0.3}, tier)
    pictures = [render_sun_sphere(m, 45.0, 48)["radiance"] for m in (plain, zero)]
    assert np.allclose(*pictures, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("name", ["coat over metal", "half covered"])
def test_stock_nodes_equal_mirror(blender, name):
    new = shown(*STACKS[name], "weidlich_wilkie", "nodes")
    network = tabulate(make_network(material.stack_of(new), "weidlich_wilkie"), HAS_DIELECTRIC)

    def f(wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in network.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0)

    result = tangent_parity(new, f, 45.0, 64)
    print(f"{name}: 99th percentile {result.percentile_99:.1e}")
    assert result.percentile_99 <= TOLERANCE


def test_a_bake_falls_back_and_says_why(blender):
    import bpy

    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, Stack.from_dict({"base": {**STEEL, **BRUSHED}}), "baked")
    material.refresh(new, settle=True)
    assert new.lamina.note == "analytic, as a bake cannot follow the anisotropy of the base"
    assert "Anisotropy" in shader_of(new).script.as_string()
