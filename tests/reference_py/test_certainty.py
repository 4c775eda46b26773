# SPDX-License-Identifier: GPL-3.0-or-later
"""Standard errors of fitted values in closed form, and from which on a value is not determined."""

import numpy as np
import pytest
from support.stacks import lambert, stack

from lamina.reference_py.fit.certainty import certainty
from lamina.reference_py.fit.elsewhere import straight
from lamina.reference_py.fit.fitting import Fit
from lamina.reference_py.fit.measurement import checked, spread_pairs
from lamina.reference_py.fit.metric import Metric
from lamina.reference_py.fit.parameters import Parameters, Structure

# Residuals are never believed to .5 % of the model, alike to .95: sqrt((1 + .95) / (1 - .95)) times that.
LEAST = 0.005 * 39.0**0.5


def test_errors_of_a_line_are_those_of_textbooks():
    """y = a + b x through n points: var(b) = s^2 / sum (x - mean)^2, var(a) = s^2 (1/n + mean^2 / sum (x - mean)^2)."""
    x = np.array([0.0, 1.0, 2.0, 5.0])
    spread = np.sum(np.square(x - x.mean()))
    expected = 0.1 * np.sqrt([1.0 / 4.0 + x.mean() ** 2 / spread, 1.0 / spread])
    assert straight(np.stack([np.ones(4), x], axis=1), 0.1) == pytest.approx(expected)


def test_what_nothing_depends_on_has_no_end():
    assert straight(np.array([[1.0, 0.0], [1.0, 0.0]]), 0.1)[1] > 1e6


@pytest.mark.parametrize("moves, determined", [(0.012, True), (0.016, True), (0.019, False), (0.03, False)])
def test_a_twentieth_of_a_value_is_the_most_that_is_determined(moves, determined):
    """A grey of .5, whose coordinate is its root: moved by e it becomes .5 + 2 sqrt(.5) e + e^2, .025 at e = .0175."""
    wi, wo = spread_pairs(60, np.random.default_rng(0))
    color = (0.5, 0.4, 0.6)
    metric = Metric(checked(wi, wo, np.array(color) / np.pi * np.ones((60, 1)), "matte"))
    parameters = Parameters(Structure.of(0, "lambert"), 3)
    matte = stack(base={**lambert(0.5), "color": list(color)})
    # one row per value: each is known as well as its residual
    rows = np.zeros((180, 3))
    rows[:3] = LEAST / moves * np.eye(3)
    fit = Fit("weidlich_wilkie", parameters, metric, parameters.coordinates(matte), np.zeros(180), rows, 1, np.zeros(180))
    red = certainty(fit)[0]
    assert red.name == "red color of the base" and red.value == pytest.approx(0.5)
    assert red.standard_error == pytest.approx(2.0 * 0.5**0.5 * moves + moves**2, rel=1e-2)
    assert red.determined == determined and not red.at_bound
