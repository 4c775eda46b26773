# SPDX-License-Identifier: GPL-3.0-or-later
"""The estimate of a lobe set's error: beside truths in closed form, whose errors are known beforehand."""

import numpy as np
import pytest
from support.stacks import coat, lambert, stack, view

from lamina.reference_py.lobes.error_estimate import ErrorEstimator, Errors, ball_cosines
from lamina.reference_py.lobes.methods.paper import PaperLobes
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.lobes.view_table import KNOTS, DiffuseTable, TableLobes
from lamina.reference_py.registry import make_model

MATTE = stack(base=lambert(0.5))
ALBEDO = 0.5
VIEWS = np.cos(np.radians([20.0, 60.0]))


class Truth:
    """f = ALBEDO / pi (1 + s(wi)), with s of mean 0: its albedo is ALBEDO from everywhere."""

    def __init__(self, pattern=lambda wi: np.zeros(wi.shape[:-1])):
        self._pattern = pattern

    def f(self, wo, wi):
        return ALBEDO / np.pi * (1.0 + self._pattern(wi))[..., None] * np.ones(3)

    def albedo(self, wo):
        return np.full(wo.shape, ALBEDO)


def matte(*color):
    """A Lambert lobe set of a color."""
    return TableLobes((DiffuseTable(np.array(color) * np.ones((KNOTS, 3))),))


def test_the_truth_itself_has_no_error():
    errors = ErrorEstimator(MATTE, Truth(), VIEWS).errors(matte(ALBEDO))
    assert max(errors.albedo.max(), errors.soft_light.max(), errors.shape.max(), errors.visible) < 1e-12


@pytest.mark.parametrize("scale", [0.9, 1.2])
def test_too_much_or_too_little_everywhere_is_all_three_errors(scale):
    """Points' measure sums to pi to a hundredth, so the shares do."""
    errors = ErrorEstimator(MATTE, Truth(), VIEWS).errors(matte(scale * ALBEDO))
    off = abs(scale - 1.0)
    assert errors.albedo == pytest.approx(np.full(2, off), rel=1e-9)
    assert errors.soft_light == pytest.approx(np.full(2, off), rel=0.01)
    assert errors.shape == pytest.approx(np.full(2, off), rel=0.01)


def test_albedo_and_shape_are_the_worst_channels_and_soft_light_all_of_them():
    errors = ErrorEstimator(MATTE, Truth(), VIEWS).errors(matte(ALBEDO, ALBEDO, 0.7 * ALBEDO))
    assert errors.albedo == pytest.approx(np.full(2, 0.3), rel=1e-9)
    assert errors.shape == pytest.approx(np.full(2, 0.3), rel=0.01)
    assert errors.soft_light == pytest.approx(np.full(2, 0.1), rel=0.01)


def sides(wi):
    return np.sign(wi[..., 0])


def stripes(wi):
    """120 of them, a fortieth of a soft light's width."""
    return np.sign(np.sin(60.0 * np.pi * wi[..., 0]))


def test_light_on_the_wrong_side_is_seen_though_the_albedo_is_right():
    """Of two halves that are .4 too bright and too dark, the lights that stand on one side alone see .4, those between less."""
    errors = ErrorEstimator(MATTE, Truth(lambda wi: 0.4 * sides(wi)), VIEWS).errors(matte(ALBEDO))
    assert np.all(errors.albedo < 1e-12)
    assert errors.shape == pytest.approx(np.full(2, 0.4), rel=0.01)
    assert np.all((0.6 * 0.4 < errors.soft_light) & (errors.soft_light < 0.9 * 0.4))
    assert errors.visible == pytest.approx(np.mean(errors.soft_light))


def test_soft_lights_blur_what_is_finer_than_they_are():
    estimator = ErrorEstimator(MATTE, Truth(lambda wi: 0.4 * stripes(wi)), VIEWS)
    errors = estimator.errors(matte(ALBEDO))
    assert errors.shape == pytest.approx(np.full(2, 0.4), rel=0.01)
    assert np.all(errors.soft_light < 0.4 * 0.4)
    # and the wider the more
    truth = Truth(lambda wi: 0.4 * stripes(wi))
    seen = [np.mean(ErrorEstimator(MATTE, truth, VIEWS, light_deg).errors(matte(ALBEDO)).soft_light) for light_deg in (40.0, 80.0, 120.0)]
    assert seen[0] > seen[1] > seen[2]


def test_the_error_that_is_seen_is_the_worse_of_the_worst_albedo_and_the_mean_soft_light():
    shape = np.full(2, 0.9)
    assert Errors(np.array([0.01, 0.03]), np.array([0.0, 0.08]), shape).visible == pytest.approx(0.04)
    assert Errors(np.array([0.01, 0.05]), np.array([0.0, 0.08]), shape).visible == pytest.approx(0.05)


def test_views_split_a_balls_pixels_evenly():
    """Over a disc the mean of cos is 2/3, of its square 1/2, of its fourth power 1/3."""
    cosines = ball_cosines()
    assert [np.mean(cosines**power) for power in (1, 2, 4)] == pytest.approx([2 / 3, 1 / 2, 1 / 3], abs=5e-3)
    assert np.all((cosines > 0.0) & (cosines < 1.0))


def test_the_estimate_beside_the_models_own_albedos():
    """A smooth coat of n = 1.5 on grey: what the method forgets to lose within the coat makes it half too bright."""
    coated = stack(coat(0.0), base=lambert(0.5))
    errors = ErrorEstimator(coated, truth_of(coated), VIEWS).errors(PaperLobes(coated))
    wo = view(np.degrees(np.arccos(VIEWS)))
    truth = make_model("adding", coated).albedo(wo)
    found = make_model("closure_model", coated, method="weidlich_wilkie").albedo(wo)
    assert errors.albedo == pytest.approx(np.max(np.abs(found / truth - 1.0), axis=-1), rel=1e-3)
    assert np.all((0.5 < errors.albedo) & (errors.albedo < 0.6))
