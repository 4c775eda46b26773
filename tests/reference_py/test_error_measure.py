# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest

from lamina.reference_py.fit.metric import shape_error
from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.distance import distance
from lamina.reference_py.optics.error_measure import albedo_error, worst_share
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.quadrature import cosine_directions, points
from lamina.reference_py.registry import make_model

COATED = Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.4}], "base": {"kind": "lambert", "color": [0.8, 0.3, 0.1]}})
THETA = np.radians([20.0, 65.0])


def test_worst_channel_is_told_and_a_black_one_is_not_divided_by():
    exact = np.array([[0.5, 0.25, 0.0], [0.5, 0.25, 0.1]])
    assert albedo_error(exact * np.array([1.02, 0.95, 1.0]), exact) == pytest.approx([0.05, 0.05])
    assert worst_share(np.zeros(3), np.zeros(3)) == 0.0


def test_estimate_distance_and_fit_tell_one_error():
    """By rules of their own: points that the truth's lobes draw, a quadrature of the surface's, and points of the cosine."""
    truth, model = make_model("adding", COATED), make_model("closure_model", COATED, method="analytic")
    near = distance(COATED, model, truth, THETA)
    estimated = ErrorEstimator(COATED, truth, np.cos(THETA)).errors(make_lobe_set(COATED, "analytic").lobe_set)
    wi = cosine_directions(*points(2048))
    measured = [shape_error(model.f(wo, wi), truth.f(wo, wi), np.ones(len(wi))) for wo in (np.broadcast_to(spherical(t, 0.0), wi.shape) for t in THETA)]
    print(near.albedo, estimated.albedo, near.shape, estimated.shape, measured)
    assert estimated.albedo == pytest.approx(near.albedo, abs=2e-3)
    assert estimated.shape == pytest.approx(near.shape, rel=0.05)
    assert measured == pytest.approx(near.shape, rel=0.05)
