# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender 4.5 samples a tilted lobe below the lobe's own horizon, where its evaluation, as all of Blender 5, gives nothing.

So lamps see the formula there and the white world sees more (README, "Where it fails"). In bsdf_microfacet.h of Cycles 4.5
the sample is rejected by the geometric normal alone, from 5.0 on by the lobe's normal too.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import versions
from lamina.addon.rendering.measure import render_furnace
from lamina.addon.shader.nodes.node_groups import lobe_group
from lamina.reference_py.lobes.closure import unit_energy
from lamina.reference_py.lobes.lobe import GlossyLobe
from lamina.reference_py.lobes.view_table import KNOTS, GlossyTable, TableLobes
from lamina.reference_py.optics.frame import normalize, reflect
from lamina.reference_py.optics.ggx import ggx_visible_normals
from lamina.reference_py.optics.microfacet import smith_lambda
from lamina.reference_py.optics.quadrature import points

pytestmark = pytest.mark.blender

THETA_DEG = np.array([30.0, 60.0, 75.0])
ALPHA, SLOPE = 0.3, 0.25
SAMPLES_BELOW = bpy.app.version < (5, 0, 0)


def below_own_horizon(cos_o: float, tilt: float, alpha: float) -> float:
    """Mean weight of the samples of a white GGX lobe that lie above the surface and below the lobe's horizon."""
    view = np.arccos(cos_o) - tilt
    wo = np.array([np.sin(view), 0.0, np.cos(view)])
    m = ggx_visible_normals(np.broadcast_to(normalize(wo * [alpha, alpha, 1.0]), (16384, 3)), 1.0, *points(16384))
    wi = reflect(wo, normalize(m * [alpha, alpha, 1.0]))
    lambda_o, lambda_i = smith_lambda(wo[2], alpha, "ggx"), smith_lambda(np.maximum(np.abs(wi[:, 2]), 1e-6), alpha, "ggx")
    above_surface = np.cos(tilt) * wi[:, 2] - np.sin(tilt) * wi[:, 0] > 0.0
    return float(np.mean(np.where((wi[:, 2] < 0.0) & above_surface, (1.0 + lambda_o) / (1.0 + lambda_o + lambda_i), 0.0)))


def test_a_tilted_lobe_in_a_white_world(blender):
    material = blender.data.materials.new("tilted")
    tree = versions.node_tree(material)
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.node_tree = lobe_group(TableLobes((GlossyTable("ggx", np.ones((KNOTS, 3)), np.array([ALPHA, ALPHA, SLOPE]) * np.ones((KNOTS, 1))),)))
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    measured, stderr = (values[:, 0] for values in render_furnace(material, THETA_DEG, samples=128, size=32))
    cos_o = np.cos(np.radians(THETA_DEG))
    tilt = np.arctan(SLOPE * np.sin(np.radians(THETA_DEG)))
    formula = unit_energy(GlossyLobe("ggx", np.ones(3), ALPHA, ALPHA, tilt), cos_o)[:, 0]
    below = np.array([below_own_horizon(c, t, ALPHA) for c, t in zip(cos_o, tilt)])
    print(f"formula {formula.round(4)}, measured {measured.round(4)}, below the lobe's horizon {below.round(4)}")
    assert below.max() > 0.01
    expected = formula + below if SAMPLES_BELOW else formula
    np.testing.assert_allclose(measured, expected, atol=1e-3 + 4.0 * stderr.max())
