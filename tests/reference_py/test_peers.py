# SPDX-License-Identifier: GPL-3.0-or-later
"""Other people's models of media that scatter: pbrt's walk has the truth's mean where it may go on, Belcour's operators are what his paper prints."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.baselines import LayeredBxdf
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.charts.peers import COLUMNS, WAYS, peer_rows
from lamina.study.suite import scattering_suite

WO, WI = spherical(np.radians([0.0, 30.0, 60.0]), 0.0), spherical(np.radians([20.0, 50.0, 60.0]), np.radians([0.0, 90.0, 170.0]))
METAL = {"kind": "conductor", "metal": "silver", "roughness": 0.5}


def stack(*layers, base=METAL):
    return Stack.from_dict({"layers": [{"kind": "dielectric", **layer} for layer in layers], "base": base})


def haze(tau, g=0.5, **values):
    return {"extinction": [tau] * 3, "scatter_albedo": [0.9, 0.6, 0.3], "scatter_g": g, **values}


@pytest.mark.parametrize("name", ["bare_haze_over_red", "rough_one_isotropic", "rough_rgb_extinction", "milk_over_clear"])
def test_pbrts_walk_has_the_mean_of_the_truth(name):
    """The truth whose facets light meets once, which is what he computes; four standard errors."""
    one = scattering_suite()[name]
    walk, truth = LayeredBxdf(one, walks=1500, depth=100), make_model("position_free", one, surface="single", walks=3000)
    for method, directions in (("f_stderr", (WO, WI)), ("albedo_stderr", (WO,))):
        value, error = getattr(walk, method)(*directions)
        exact, noise = getattr(truth, method)(*directions)
        assert np.all(np.abs(value - exact) < 4.0 * np.hypot(error, noise))
        assert np.max(error / value) < 0.15


def test_his_ten_events_lose_light_in_a_thick_white_medium():
    one = stack({"scatter_albedo": [1.0] * 3, "extinction": [8.0] * 3, "ior": 1.5, "roughness": 0.5}, base={"kind": "lambert", "color": [0.8] * 3})
    few, many = (LayeredBxdf(one, walks=3000, depth=depth).albedo_stderr(WO)[0] for depth in (10, 200))
    assert np.all(few < 0.8 * many)


def test_he_finds_no_light_that_two_mirrors_turn_back_after_the_last_event():
    one = stack(haze(0.5, 0.8, ior=1.5), base={**METAL, "roughness": 0.0})
    value, error = LayeredBxdf(one, walks=4000, depth=100).f_stderr(WO[2:], WI[2:])
    assert value[0, 0] + 4.0 * error[0, 0] < 0.8 * make_model("adding", one).f(WO[2:], WI[2:])[0, 0]


def test_his_walk_wants_one_patch():
    with pytest.raises(LaminaError, match="is an opaque lambert"):
        LayeredBxdf(stack({"kind": "lambert", "color": [0.5] * 3, "coverage": 0.5}))


def test_belcour_without_density_is_his_clear_stack():
    layer = {"roughness": 0.4, "ior": 1.5}
    clear, none = (make_model("belcour", stack(one)) for one in (layer, {**layer, "scatter_color": [0.5] * 3, "density": 0.0}))
    assert np.array_equal(clear.f(WO, WI), none.f(WO, WI))
    faint, thick = (make_model("belcour", stack({"ior": 1.0, **haze(tau)})).lobes(np.array([0.7]))[1][1] for tau in (1e-9, 1.0))
    assert faint == pytest.approx(thick) and faint > 0.5  # as printed: any density blurs in full


def test_belcour_lets_pass_what_one_event_sends_on():
    cos, tau, g = np.array([0.4, 0.8]), 0.7, 0.6
    [(_, _), (weight, alpha)] = make_model("belcour", stack(haze(tau, g, ior=1.0))).lobes(cos)
    [(bare, own)] = make_model("belcour", stack()).lobes(cos)
    slant = tau / cos[:, None]
    passed = (1.0 + np.array([0.9, 0.6, 0.3]) * slant) * np.exp(-slant)

    def variance(a):
        return a**1.1 / (1.0 - a**1.1)

    # the metal's directional albedo is that of a lobe as wide as what arrives
    once, gain = ((1.0 - g) / g) ** 0.8 / (1.0 + g), weight / passed**2 / bare
    assert np.all((gain > 0.75) & (gain < 1.0)) and np.ptp(gain, axis=1).max() < 0.02
    assert variance(alpha) == pytest.approx(variance(own) + 2.0 * once, rel=1e-3)


def test_the_chart_has_a_row_for_each_way():
    rows = list(peer_rows([("thin", scattering_suite()["rough_thin_isotropic"])], lambda line: None, walks=4))
    assert [row[1] for row in rows] == [way.name for way in WAYS] and all(len(row) == len(COLUMNS) for row in rows)
    errors = {row[1]: float(row[2]) for row in rows}
    assert errors["adding"] == 0.0 and errors["baked"] < 0.01 < errors["belcour"]
