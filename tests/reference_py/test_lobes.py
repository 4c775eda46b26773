# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets in numpy: exact where a closure can be, energy kept where it cannot, errors as the README states them."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model

BLACK = {"kind": "lambert", "color": [0, 0, 0]}


def pairs(count=200, seed=5):
    """Random directions above the surface, grazing ones among them."""
    rng = np.random.default_rng(seed)
    return (spherical(np.arccos(rng.uniform(1e-3, 1.0, count)), rng.uniform(0.0, 2.0 * np.pi, count)) for _ in range(2))


@pytest.mark.parametrize("layer", [{"ior": 1.5, "roughness": 0.5}, {"ior": 2.4, "roughness": 0.9, "distribution": "beckmann"}])
def test_the_top_interface_is_exact(layer):
    stack = Stack.from_dict({"layers": [{"kind": "dielectric", **layer}], "base": BLACK})
    wo, wi = pairs()
    exact = make_model("weidlich_wilkie", stack).f(wo, wi)
    assert make_model("closure_model", stack, method="weidlich_wilkie").f(wo, wi) == pytest.approx(exact, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("base", [{"kind": "lambert"}, {"kind": "oren_nayar", "sigma_deg": 35}])
def test_a_bare_diffuse_base_is_exact(base):
    """An Oren-Nayar one to what a dark lobe has of light that meets several facets, 2e-6."""
    stack = Stack.from_dict({"base": base})
    wo, wi = pairs()
    assert make_model("closure_model", stack, method="weidlich_wilkie").f(wo, wi) == pytest.approx(make_model("weidlich_wilkie", stack).f(wo, wi), rel=5e-6)


def test_equal_indices_change_nothing():
    clear = {"kind": "dielectric", "ior": 1.0, "roughness": 0.4}
    bare = {"base": {"kind": "conductor", "metal": "gold", "roughness": 0.5}}
    wo, wi = pairs()
    coated = make_model("closure_model", Stack.from_dict({**bare, "layers": [clear, clear]}), method="weidlich_wilkie").f(wo, wi)
    assert coated == pytest.approx(make_model("closure_model", Stack.from_dict(bare), method="weidlich_wilkie").f(wo, wi), rel=2e-2, abs=1e-9)


def test_weights_are_finite_and_never_negative_from_normal_to_grazing():
    layers = [{"kind": "dielectric", "ior": 1.0 + 0.4 * (i % 4), "roughness": 0.1 * i, "tint": [0, 0.5, 1]} for i in range(8)]
    for base in (BLACK, {"kind": "oren_nayar"}, {"kind": "conductor", "metal": "silver", "roughness": 1.0}):
        lobe_set = make_lobe_set(Stack.from_dict({"layers": layers, "base": base}), "weidlich_wilkie")
        lobes = lobe_set.lobes(np.cos(np.radians([0.0, 45.0, 85.0, 89.9, 90.0])))
        assert len(lobes) == lobe_set.lobe_count == (10 if base["kind"] == "oren_nayar" else 9)
        for lobe in lobes:
            assert np.all(np.isfinite(lobe.weight)) and np.all(lobe.weight >= 0.0)


def test_unknown_tier_lists_the_tiers():
    with pytest.raises(LaminaError, match="unknown quality 'magic'; choose weidlich_wilkie"):
        make_lobe_set(presets.load("crayon_paint"), "magic")
