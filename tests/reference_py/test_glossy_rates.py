# SPDX-License-Identifier: GPL-3.0-or-later
"""The derivatives that fits go by are those of the lobes that Cycles has."""

import numpy as np
import pytest

from lamina.reference_py.lobes.baked.glossy_rates import glossy_rates, glossy_values
from lamina.reference_py.lobes.closure import unit_glossy
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.microfacet import BECKMANN, GGX, distribution_of

STEP = 1e-5


def lights():
    wi = np.random.default_rng(1).normal(size=(2000, 3))
    wi[:, 2] = np.abs(wi[:, 2])
    return wi / np.linalg.norm(wi, axis=1, keepdims=True)


@pytest.mark.parametrize("theta_deg", [0.0, 20.0, 70.0, 86.0])
@pytest.mark.parametrize("distribution", [GGX, BECKMANN])
def test_rates_are_differences(distribution, theta_deg):
    wi, wo = lights(), spherical(np.radians(theta_deg), 0.0)
    at = np.array([np.log(0.3), np.log(0.15), 0.1])

    def f(shape):
        return unit_glossy(distribution, np.exp(shape[0]), np.exp(shape[1]), shape[2], np.broadcast_to(wo, wi.shape), wi)[0]

    value, *rates = glossy_rates(distribution, np.exp(at[0]), np.exp(at[1]), at[2], (wo[0], wo[2]), tuple(wi.T))
    np.testing.assert_allclose(value, f(at), rtol=1e-12, atol=1e-14 * np.max(value))
    for i, rate in enumerate(rates):
        step = STEP * np.eye(3)[i]
        slope = (f(at + step) - f(at - step)) / (2.0 * STEP)
        # a light that the step takes below the lobe's horizon has no slope
        error = np.abs(rate - slope) / np.max(np.abs(slope))
        assert np.quantile(error, 0.99) < 1e-7, ("log alpha_x", "log alpha_y", "tilt")[i]


@pytest.mark.parametrize("dtype,within", [(np.float64, 1e-12), (np.float32, 2e-4)])
@pytest.mark.parametrize("theta_deg", [0.0, 20.0, 70.0, 86.0])
@pytest.mark.parametrize("distribution", [GGX, BECKMANN])
def test_fits_have_the_lobes_that_tables_are_judged_by(distribution, theta_deg, dtype, within):
    wi, wo = lights(), spherical(np.radians(theta_deg), 0.0)
    # a tilt from which the view stays above the lobe's horizon, and some of the lights do not
    shape = 0.3, 0.15, -0.05
    single = [np.array(value, dtype) for value in shape]
    value = glossy_values(distribution, *single, tuple(wo[[0, 2]].astype(dtype)), tuple(wi.T.astype(dtype)))
    rated = glossy_rates(distribution, *single, tuple(wo[[0, 2]].astype(dtype)), tuple(wi.T.astype(dtype)))[0]
    expected = unit_glossy(distribution, *shape, np.broadcast_to(wo, wi.shape), wi)[0]
    assert value.dtype == rated.dtype == dtype
    for found in (value, rated):
        np.testing.assert_allclose(found, expected, rtol=within, atol=within * np.max(expected))


@pytest.mark.parametrize("distribution", [GGX, BECKMANN])
def test_rates_of_a_distribution(distribution):
    law, x = distribution_of(distribution), np.geomspace(0.4, 50.0, 40)
    value, masking_rate = law.smith_lambda_and_rate(x)
    np.testing.assert_allclose(value, law.smith_lambda(x), rtol=1e-14)
    for function, rate in ((lambda v: np.log(law.slope_density(v)), law.log_slope_density_rate(x)), (law.smith_lambda, masking_rate)):
        np.testing.assert_allclose(rate, (function(x + 1e-5) - function(x - 1e-5)) / 2e-5, rtol=1e-5)
