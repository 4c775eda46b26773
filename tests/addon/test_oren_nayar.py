# SPDX-License-Identifier: GPL-3.0-or-later
"""A rough diffuse base renders the same in every Blender, whose own closure changed in 5.3."""

import numpy as np
import pytest

pytest.importorskip("bpy")

import bpy
from support.goniometer import TOLERANCE, parity
from support.linked_values import link_values

from lamina.addon.check import check
from lamina.addon.material import material
from lamina.addon.material.live_values import live_values
from lamina.addon.material.reading import stack_of
from lamina.addon.material.roles import node_with
from lamina.addon.rendering.measure import render_furnace
from lamina.addon.shader.nodes.node_groups import lobe_group
from lamina.addon.shader.nodes.stock_nodes import eevee_stock_tables, stock_tables
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.diffuse import oren_nayar
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender

CASES = {"half": ((0.5, 0.5, 0.5), 90.0), "dark": ((0.18, 0.18, 0.18), 60.0), "colored": ((0.9, 0.5, 0.02), 40.0), "white": ((1.0, 1.0, 1.0), 60.0)}
# Of nodes that cube the color: the energy is right at every view, the shape's L1 error is 1.3 % at most (test_tabulate.py).
CUBING_TOLERANCE = 0.04


def rough(name: str, layers=()) -> Stack:
    color, sigma_deg = CASES[name]
    return Stack.from_dict({"layers": list(layers), "base": {"kind": "oren_nayar", "color": list(color), "sigma_deg": sigma_deg}})


def shown(stack: Stack, tier: str, backend: str):
    new = bpy.data.materials.new("rough")
    material.apply_stack(new, stack, tier, backend)
    return new


@pytest.mark.parametrize("tier, backend", [("weidlich_wilkie", "osl"), ("analytic", "osl"), ("analytic", "nodes")])
@pytest.mark.parametrize("name", CASES)
def test_render_equals_the_formula(blender, name, tier, backend):
    color, sigma_deg = CASES[name]
    new = shown(rough(name), tier, backend)
    result = parity(new, lambda wo, wi: oren_nayar(wi, wo, color, sigma_deg), 45.0, 64)
    print(f"{name}, {tier}, {backend}: 99th percentile {result.percentile_99:.1e}, {new.lamina.lobe_count} closures")
    cubes = backend == "nodes" and bpy.app.version < (5, 3, 0)
    assert result.finite and result.percentile_99 <= (CUBING_TOLERANCE if cubes else TOLERANCE)
    assert new.lamina.lobe_count == (1 if backend == "nodes" else 2)


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("name, normal", [("half", 0.4510), ("dark", 0.1554)])
def test_albedo(blender, name, normal, backend):
    """Along the normal and at 60 and 80 degrees; before, Blender 5.2 and 4.5 gave .4298 and .1516 along the normal."""
    stack, theta_deg = rough(name), [0.0, 60.0, 80.0]
    measured, stderr = render_furnace(shown(stack, "analytic", backend), theta_deg, samples=64, size=16)
    wo = np.array([[np.sin(t), 0.0, np.cos(t)] for t in np.radians(theta_deg)])
    truth = make_model("adding", stack).albedo(wo)
    print(f"{name}, {backend}: {np.round(measured[:, 0], 4)}, truth {np.round(truth[:, 0], 4)}")
    assert measured[0] == pytest.approx(normal, abs=5e-4)
    assert np.all(np.abs(measured - truth) < 1e-3 * truth + 3.0 * stderr)


STEEL = {"kind": "conductor", "metal": "iron", "roughness": 0.3}


def textured(covered: bool, backend: str, tier: str) -> tuple:
    """A material whose rough base, or opaque layer on steel, has its color and slopes from other nodes, and these nodes' sockets."""
    kind, owner = {"kind": "oren_nayar", "color": [0.5, 0.5, 0.5], "sigma_deg": 20.0}, bpy.data.materials.new("textured")
    stack = {"layers": [{**kind, "coverage": 0.6}], "base": STEEL} if covered else {"layers": [], "base": kind}
    material.apply_stack(owner, Stack.from_dict(stack), tier, backend)
    link_values(owner, {(0 if covered else None, "Color"): (0.5, 0.5, 0.5), (0 if covered else None, "Slope Deviation"): 20.0})
    material.refresh(owner, settle=True)
    return owner, [next(node.outputs[0] for node in owner.node_tree.nodes if node.bl_idname == kind) for kind in ("ShaderNodeRGB", "ShaderNodeValue")]


@pytest.mark.parametrize("tier, backend", [("auto", "nodes"), ("auto", "osl"), ("baked", "nodes"), ("analytic", "nodes")])
def test_textures_of_a_bare_base_are_followed(blender, tier, backend):
    owner, (color, slopes) = textured(False, backend, tier)
    color.default_value, slopes.default_value = (0.8, 0.3, 0.05, 1.0), 50.0
    result = parity(owner, lambda wo, wi: oren_nayar(wi, wo, (0.8, 0.3, 0.05), 50.0), 45.0, 64)
    print(f"{tier}, {backend}: 99th percentile {result.percentile_99:.1e}")
    cubes = backend == "nodes" and bpy.app.version < (5, 3, 0)
    assert result.finite and result.percentile_99 <= (CUBING_TOLERANCE if cubes else TOLERANCE)
    assert "texture_ignored" not in [found.code for found in check.find(owner, bpy.context.scene, bpy.context.preferences)]


@pytest.mark.parametrize("covered, in_eevee", [(False, False), (True, False), (False, True)])
def test_stock_nodes_have_the_energy_of_textured_rough_bases(blender, covered, in_eevee):
    """Those of EEVEE, whose diffuse node has no roughness, too: Cycles shows what they say."""
    theta_deg, (owner, (color, slopes)) = [0.0, 60.0, 80.0], textured(covered, "nodes", "auto")
    values = {"kind": "oren_nayar", "color": [0.8, 0.3, 0.05], "sigma_deg": 50.0}
    color.default_value, slopes.default_value = (*values["color"], 1.0), values["sigma_deg"]
    if in_eevee:
        node, made = node_with(owner, "nodes"), make_lobe_set(stack_of(owner), "auto", live=live_values(owner))
        links = [(link.from_socket, link.to_socket.name) for socket in node.inputs for link in socket.links]
        node.node_tree = lobe_group(eevee_stock_tables(made, stock_tables(made)))
        for source, name in links:
            owner.node_tree.links.new(source, node.inputs[name])
    measured, stderr = render_furnace(owner, theta_deg, samples=64, size=16)
    wo = np.array([[np.sin(t), 0.0, np.cos(t)] for t in np.radians(theta_deg)])
    stack = Stack.from_dict({"layers": [{**values, "coverage": 0.6}], "base": STEEL} if covered else {"layers": [], "base": values})
    truth = make_model("adding", stack).albedo(wo)
    print(f"covered {covered}, eevee {in_eevee}: {np.round(measured / truth - 1.0, 4)}")
    assert np.all(np.abs(measured - truth) < 0.01 * truth + 3.0 * stderr)


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
def test_render_under_a_coat_equals_the_mirror(blender, tier):
    stack = rough("colored", [{"kind": "dielectric", "roughness": 0.5, "tint": [0.9, 0.6, 0.5]}])
    result = parity(shown(stack, tier, "osl"), make_model("closure_model", stack, method=tier).f, 45.0, 64)
    assert result.finite and result.percentile_99 <= TOLERANCE
