# SPDX-License-Identifier: GPL-3.0-or-later
"""Eight masks in the render: closures of pools equal the closure model, in the script and in stock nodes."""

import pytest

pytest.importorskip("bpy")

from support.covered import GREY, VARNISH, layered
from support.goniometer import TOLERANCE, parity
from support.pools import PAINTS, PAINTS_BELOW_COATS

from lamina.addon.material import material
from lamina.addon.shader.nodes.stock_nodes import closure_count, stock_tables
from lamina.reference_py.lobes.closure import lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.pools import MAX_CLOSURES
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender

METALS = [{"kind": "conductor", "metal": "gold", "roughness": 0.5 + 0.06 * i, "coverage": 0.3} for i in range(8)]


@pytest.mark.parametrize("layers", [METALS, PAINTS], ids=["metals", "paints"])
def test_script_equals_closure_model(blender, layers):
    new = layered(layers, {"kind": "conductor", "metal": "iron", "roughness": 0.9}, "baked")
    assert new.lamina.lobe_count <= MAX_CLOSURES
    result = parity(new, make_model("closure_model", material.stack_of(new), method="baked").f, 45.0, 48)
    assert result.finite and result.percentile_99 <= TOLERANCE


@pytest.mark.parametrize("layers", [METALS, PAINTS, PAINTS_BELOW_COATS], ids=["metals", "paints", "below coats"])
def test_stock_nodes_equal_closure_model(blender, layers):
    """Of 9 and of 24 patches."""
    new = layered(layers, GREY, "analytic", "nodes")
    lobe_set = stock_tables(make_lobe_set(material.stack_of(new), "analytic"))
    assert closure_count(lobe_set) < 64  # of Cycles' own

    def f(wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in lobe_set.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0)

    assert parity(new, f, 45.0, 48).percentile_99 <= TOLERANCE


def test_a_live_tier_says_how_many_closures_it_has(blender):
    new = layered([VARNISH, *METALS], GREY, "analytic")
    assert f"closures, more than the {MAX_CLOSURES} that OptiX takes" in new.lamina.note
