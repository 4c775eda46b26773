# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that follow the color of a Lambert base, alone and with a roughness and a thickness, against the truth of each color."""

import json
from dataclasses import replace

import numpy as np
import pytest
from support.coats import TWO_COATS, VARNISH

from lamina.reference_py.lobes.baked import follows, in_tables, pack_lobes, unpack_lobes
from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.lobes.view_table import BASE_COLOR, BaseColorTable
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding import Adding
from lamina.reference_py.optics.frame import spherical

LAYERS = {"bare": [], "glazed": [{"kind": "dielectric"}], "varnished": [VARNISH], "two coats": TWO_COATS}
THETA = np.radians([0.0, 25.0, 50.0, 70.0, 80.0])
COLORS = ((0.02, 0.5, 0.98), (1.0, 0.0, 0.3))


def stack_of(name, color=(0.8, 0.8, 0.8)):
    return Stack.from_dict({"layers": LAYERS[name], "base": {"kind": "lambert", "color": list(color)}})


def energy(lobe_set):
    return sum(lobe_energy(lobe, np.cos(THETA)) for lobe in lobe_set.lobes(np.cos(THETA)))


@pytest.mark.parametrize("name", LAYERS)
def test_every_color_has_its_energy(name):
    followed = make_lobe_set(stack_of(name), "baked", live=(BASE_COLOR,)).lobe_set
    assert followed.followed == (BASE_COLOR,)
    for color in COLORS:
        here = stack_of(name, color)
        exact = Adding(here).albedo(spherical(THETA, 0.0))
        # between knots a mirror's Fresnel curve is off by as much
        np.testing.assert_allclose(energy(followed.with_values_of(here)), exact, rtol=8e-3, atol=1e-4)
        # light that comes back to the base from below the layers is no small part of it
        if LAYERS[name]:
            forgetful = replace(followed, tables=tuple(replace(t, back=0.0 * t.back) if isinstance(t, BaseColorTable) else t for t in followed.tables))
            assert np.max(np.abs(energy(forgetful.with_values_of(here)) / exact - 1.0)) > 0.05


TABLE = (Place(0, "roughness"), Place(1, "thickness"), BASE_COLOR)


def test_a_color_with_a_roughness_and_a_thickness():
    """The wooden table: nine combinations. At knots of all three it is exact; between them a strong tint is the worst."""
    stack, live = stack_of("two coats"), TABLE
    followed = make_lobe_set(stack, "baked", live=live).lobe_set
    assert followed.followed == live
    rng, worst = np.random.default_rng(4), []
    for _ in range(9):
        here = stack
        for place, value in zip(live, (rng.uniform(0.15, 0.7), rng.uniform(0.1, 2.0), tuple(rng.uniform(0.03, 0.95, 3)))):
            here = place.with_value(here, value)
        errors = ErrorEstimator(here, truth_of(here), np.cos(THETA)).errors(followed.with_values_of(here))
        worst.append((np.max(errors.albedo), np.median(errors.shape)))
    albedo, shape = np.max(worst, axis=0)
    print(f"albedo {100 * albedo:.2f} %, shape {100 * shape:.1f} %")
    assert albedo < 0.012 and shape < 0.08


@pytest.mark.parametrize("live", [(BASE_COLOR,), TABLE])
def test_what_is_kept_is_of_any_color(live):
    stack = stack_of("two coats")
    followed = make_lobe_set(stack, "baked", live=live).lobe_set
    other = stack_of("two coats", (0.1, 0.6, 0.2))
    again = unpack_lobes(json.loads(json.dumps(pack_lobes(followed))), other)
    np.testing.assert_allclose(energy(again), energy(followed.with_values_of(other)), rtol=1e-12)
    assert np.max(np.abs(energy(again) / energy(followed) - 1.0)) > 0.2


def test_a_color_beyond_0_and_1_is_that_of_the_bound():
    table = BaseColorTable(np.zeros((24, 3)), np.full((24, 3), 0.9), np.full((24, 3), 0.6), np.array([-1.0, 0.5, 7.0]))
    bounded = replace(table, color=np.array([0.0, 0.5, 1.0]))
    np.testing.assert_array_equal(table.weight, bounded.weight)
    assert np.all(np.isfinite(table.weight))


def test_what_bakes_and_stock_nodes_follow():
    stack, metal = stack_of("varnished"), Stack.from_dict({"layers": [VARNISH], "base": {"kind": "conductor", "metal": "gold"}})
    rough = Stack.from_dict({"layers": [VARNISH], "base": {"kind": "oren_nayar", "color": [0.5, 0.5, 0.5], "sigma_deg": 30.0}})
    roughness, tint = Place(0, "roughness"), Place(0, "tint")
    assert follows(stack, (BASE_COLOR,)) and follows(stack, (roughness, tint, BASE_COLOR)) and follows(rough, (BASE_COLOR,))
    assert not follows(metal, (Place(None, "roughness"), roughness, tint, Place(0, "ior"))) and not follows(metal, (Place(None, "eta"),))
    assert in_tables(stack, (roughness, BASE_COLOR)) == (roughness, BASE_COLOR) and in_tables(rough, (BASE_COLOR,)) == (BASE_COLOR,)
    other = replace(stack, layers=(*stack.layers, *stack.layers))
    assert in_tables(other, (roughness, tint, Place(0, "ior"), Place(1, "ior"), BASE_COLOR)) == (BASE_COLOR,), "more than a bake follows"
    assert in_tables(metal, (Place(None, "roughness"), roughness, tint, Place(0, "ior"))) == ()
