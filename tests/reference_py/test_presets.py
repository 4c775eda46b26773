# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: those of the paper carry its numbers (Weidlich07, sections 6.1 and 6.2), all have a source and a stated error."""

import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.optics.microfacet import GGX, roughness_from_slope_deg, slope_deg_from_roughness

# name: ((ior, slope_deg, thickness) per layer, None where the paper gives no number), (base kind, metal, slope or sigma)
PAPER = {
    "crayon_paint": (((1.3, 0, None),), ("lambert", None, None)),
    "glazed_mug": (((1.6, 0, None),), ("lambert", None, None)),
    "tinted_glaze": (((None, 0, 1.6),), ("lambert", None, None)),
    "frosted_paint": (((1.6, 12, 0.5),), ("lambert", None, None)),
    "metal_foil": (((None, 1, None),), ("conductor", "silver", 1)),
    "metallic_car_paint": (((1.45, 0.1, None),), ("conductor", "aluminium", 12)),
    "frosted_metal": (((1.6, 12, 0.5),), ("conductor", "silver", None)),
    "clean_copper": ((), ("conductor", "copper", 8)),
    "patina_copper": (((1.3, 12, None),), ("conductor", "copper", 8)),
    "blue_wall_paint": (((1.3, 32, None), (1.3, 8, None)), ("oren_nayar", None, 20)),
}


def test_all_presets_are_here():
    assert set(PAPER) == set(presets.PAPER) and set(PAPER) <= set(presets.names())
    assert len(presets.names()) >= len(PAPER) + 16


@pytest.mark.parametrize("name", presets.names())
def test_every_preset_is_whole_and_says_where_its_numbers_are_from(name):
    stack = presets.load(name)
    assert stack.name == presets.label(name)
    assert len(stack.source) > 60 and stack.source.endswith(".")
    assert not stack.unknown_keys()
    assert name in PAPER or "ours" in stack.source or "by eye" in stack.source  # what was measured and what was chosen


@pytest.mark.parametrize("name", PAPER)
def test_numbers_of_the_paper(name):
    stack = presets.load(name)
    layers, (kind, metal, width) = PAPER[name]
    assert stack.source.startswith("Weidlich and Wilkie 2007")
    assert len(stack.layers) == len(layers)
    for layer, (ior, slope, thickness) in zip(stack.layers, layers):
        assert ior is None or layer["ior"] == ior
        assert thickness is None or layer["thickness"] == thickness
        assert slope_deg_from_roughness(layer["roughness"], layer["distribution"]) == pytest.approx(slope, abs=1e-3)
    assert stack.base.kind == kind
    if metal:
        assert stack.base["metal"] == metal
    if kind == "oren_nayar":
        assert stack.base["sigma_deg"] == width
    elif width is not None:
        assert slope_deg_from_roughness(stack.base["roughness"], stack.base["distribution"]) == pytest.approx(width, abs=1e-3)


@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_mean_slope_is_that_of_the_distribution(kind):
    """The mean of tan(theta) over D cos(theta), integrated numerically, is the tangent of the slope asked for."""
    import numpy as np

    alpha = float(roughness_from_slope_deg(12.0, kind)) ** 2
    u = (np.arange(2_000_000) + 0.5) / 2_000_000
    tan = alpha * (np.sqrt(u / (1.0 - u)) if kind == GGX else np.sqrt(-np.log1p(-u)))
    assert np.degrees(np.arctan(tan.mean())) == pytest.approx(12.0, rel=2e-3)


def test_unknown_preset_lists_the_names():
    with pytest.raises(LaminaError, match="unknown preset 'nope'; choose anodised_aluminium, anodised_titanium"):
        presets.load("nope")
