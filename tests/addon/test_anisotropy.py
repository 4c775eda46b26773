# SPDX-License-Identifier: GPL-3.0-or-later
"""Anisotropic surfaces in the render: equal to their closure model at every azimuth, along the material's Tangent node."""

import numpy as np
import pytest

pytest.importorskip("bpy")

import bpy
from support.goniometer import TOLERANCE, tangent_parity
from support.linked_values import link_values

from lamina.addon.material import material
from lamina.addon.material.live_values import live_values
from lamina.addon.material.roles import node_with
from lamina.addon.material.shader_node import shader_of
from lamina.addon.rendering.measure import render_furnace, render_sun_sphere
from lamina.addon.shader.nodes.stock_nodes import stock_tables
from lamina.reference_py.lobes.closure import lobe_energy, lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import azimuth, spherical
from lamina.reference_py.registry import make_model

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
    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, Stack.from_dict({"layers": layers, "base": base}), tier, backend)
    tangent = new.node_tree.nodes["Lamina Tangent"]
    tangent.direction_type, tangent.axis = "RADIAL", "Y"
    material.refresh(new, settle=True)
    return new


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("name", STACKS)
def test_render_equals_mirror(blender, tier, name):
    new = shown(*STACKS[name], tier)
    result = tangent_parity(new, make_model("closure_model", material.stack_of(new), method=tier).f, 45.0, 64)
    print(f"{tier}, {name}: 99th percentile {result.percentile_99:.1e} of {result.errors.size}")
    assert result.finite and result.errors.size > 300
    assert result.percentile_99 <= TOLERANCE


def test_the_wrong_azimuth_is_caught(blender):
    new = shown(*STACKS["bare metal"], "weidlich_wilkie")
    turned = Stack.from_dict({"base": {**STEEL, **BRUSHED, "rotation": 0.11}})
    assert tangent_parity(new, make_model("closure_model", turned, method="weidlich_wilkie").f, 45.0, 64).percentile_99 > 100 * TOLERANCE


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
def test_anisotropy_0_renders_as_none(blender, tier):
    plain = bpy.data.materials.new("plain")
    material.apply_stack(plain, Stack.from_dict({"layers": [COAT], "base": STEEL}), tier)
    zero = shown([{**COAT, "anisotropy": 0.0}], {**STEEL, "anisotropy": 0.0, "rotation": 0.3}, tier)
    pictures = [render_sun_sphere(m, 45.0, 48)["radiance"] for m in (plain, zero)]
    assert np.allclose(*pictures, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(
    "tier, name",
    [
        ("weidlich_wilkie", "coat over metal"),
        ("weidlich_wilkie", "half covered"),
        ("analytic", "bare metal"),
        ("analytic", "coat"),
        ("analytic", "half covered"),
    ],
)
def test_stock_nodes_equal_mirror(blender, tier, name):
    new = shown(*STACKS[name], tier, "nodes")
    lobe_set = stock_tables(make_lobe_set(material.stack_of(new), tier))

    def f(wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in lobe_set.lobes(wo[..., 2], azimuth(wo))) * (wi[..., 2:] > 0.0)

    result = tangent_parity(new, f, 45.0, 64)
    print(f"{tier}, {name}: 99th percentile {result.percentile_99:.1e}")
    assert result.percentile_99 <= TOLERANCE


WHITE = {"kind": "conductor", "reflectance": [0.999] * 3, "edge_color": [1.0] * 3, "roughness": 0.5, "anisotropy": 1.0}


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("turns", [0.0, 0.25])
@pytest.mark.parametrize("reflectance", [0.999, 0.9])
def test_a_brushed_metal_reflects_what_it_should(blender, reflectance, turns, backend):
    """Views along and across, in a white furnace (tests/reference_py/test_anisotropy.py has more).

    With the isotropic surface's weights white was 1.018 along the normal and 1.082 at 60 degrees, grey .9688 for .8866.
    """
    theta_deg = [0.0, 60.0, 80.0]
    stack = Stack.from_dict({"base": {**WHITE, "reflectance": [reflectance] * 3, "rotation": turns}})
    truth, noise = make_model("position_free", stack, walks=1 << 14).albedo_stderr(spherical(np.radians(theta_deg), 0.0))
    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, stack, "analytic", backend)
    measured, stderr = render_furnace(new, theta_deg, samples=64, size=16)
    print(f"{reflectance:g}, {360 * turns:g} degrees, {backend}: {np.round(measured[:, 0], 4)}, truth {np.round(truth[:, 0], 4)}, +-{stderr.max():.4f}")
    assert np.all(np.abs(measured - truth) < 0.01 * truth + 3.0 * (stderr + noise))


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("turns", [0.0, 0.25])
def test_a_bake_has_the_energy_of_the_rotation(blender, turns, backend):
    """Brushed metal below a coat, along and across: the live shader is 8 % off."""
    theta_deg = [45.0, 70.0]
    stack = Stack.from_dict({"layers": [{**COAT, "roughness": 0.0}], "base": {**STEEL, **BRUSHED, "metal": "copper", "rotation": turns}})
    truth, noise = make_model("position_free", stack, walks=1 << 15).albedo_stderr(spherical(np.radians(theta_deg), 0.0))
    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, stack, "baked", backend)
    material.refresh(new, settle=True)
    measured, stderr = render_furnace(new, theta_deg, samples=64, size=16)
    print(f"{360 * turns:g} degrees, {backend}: {np.round(measured, 4).tolist()}, truth {np.round(truth, 4).tolist()}, +-{stderr.max():.4f}")
    assert np.all(np.abs(measured - truth) < 0.01 * truth + 3.0 * (stderr + noise))


@pytest.mark.parametrize(
    "layers, base, links",
    [
        ([{**COAT, "roughness": 0.0}], {**STEEL, "metal": "copper", **BRUSHED}, {(None, "Roughness"): 0.37, (None, "Rotation"): 0.29}),
        ([], {**STEEL, "metal": "copper", **BRUSHED}, {(None, "Roughness"): 0.37, (None, "Rotation"): 0.29}),
        ([{**COAT, **BRUSHED, "tint": [0.9, 0.7, 0.4]}], STEEL, {(0, "Roughness"): 0.43, (0, "Thickness"): 1.3, (0, "Rotation"): 0.83}),
        ([{**COAT, **BRUSHED}], GREY, {(None, "Color"): (0.2, 0.6, 0.7)}),
        ([{**COAT, **BRUSHED}], GREY, {(0, "Anisotropy"): 0.63}),
        ([], {**STEEL, "metal": "copper", **BRUSHED}, {(None, "Anisotropy"): 0.27, (None, "Roughness"): 0.37, (None, "Rotation"): 0.29}),
    ],
)
def test_a_bake_over_live_values_equals_its_lobe_set(blender, layers, base, links):
    new = shown(layers, base, "baked", "auto")
    link_values(new, links)
    material.refresh(new, settle=True)
    lobe_set = make_lobe_set(material.stack_of(new), "baked", live=live_values(new)).lobe_set
    assert set(lobe_set.followed) == set(live_values(new)) and len(lobe_set.followed) == len(links)
    text, group = shader_of(new).script.as_string(), node_with(new, "nodes")
    assert len([socket for socket in group.inputs if socket.is_linked]) == len(links) + 1, "and the tangent"
    for shown_set in (lobe_set, stock_tables(make_lobe_set(material.stack_of(new), "baked", live=live_values(new)))):

        def f(wo, wi, shown_set=shown_set):
            return sum(lobe_f(lobe, wo, wi) for lobe in shown_set.lobes(wo[..., 2], azimuth(wo))) * (wi[..., 2:] > 0.0)

        result = tangent_parity(new, f, 45.0, 32)
        print(f"{type(shown_set).__name__}: 99th percentile {result.percentile_99:.1e}, text {len(text) / 1e3:.0f} kB, {len(group.node_tree.nodes)} nodes")
        assert result.finite and result.errors.size > 300 and result.percentile_99 <= 4e-4
        new.node_tree.links.new(group.outputs["BSDF"], new.node_tree.get_output_node("ALL").inputs["Surface"])
    views, phis = np.cos(np.radians([0.0, 40.0, 65.0, 80.0])), np.radians([0.0, 36.0, 80.0, 126.0])
    energy, expected = (np.array([sum(lobe_energy(lobe, views, phi) for lobe in a.lobes(views, phi)) for phi in phis]) for a in (shown_set, lobe_set))
    assert energy == pytest.approx(expected, rel=0.015)


def test_a_bare_metal_keeps_its_own_closure(blender):
    new = bpy.data.materials.new("brushed")
    material.apply_stack(new, Stack.from_dict({"base": {**STEEL, **BRUSHED}}), "baked")
    material.refresh(new, settle=True)
    assert new.lamina.note == "the base's own closures, right within 1 %"
    assert "Anisotropy" in shader_of(new).script.as_string()
