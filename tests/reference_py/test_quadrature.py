# SPDX-License-Identifier: GPL-3.0-or-later
"""The albedo quadrature: known integrals, and its stated error against four times the points."""

import numpy as np
import pytest

from lamina.reference_py.material import presets
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.optical_stack import rough_surfaces
from lamina.reference_py.optics.quadrature import directional_albedo
from lamina.reference_py.registry import make_model

WO = spherical(np.radians([0.0, 45.0, 75.0]), 0.0)
STATED_ERROR = 5e-4


def test_lambert_is_its_color():
    albedo = directional_albedo(lambda wo, wi: np.full(wi.shape, 0.7 / np.pi), WO, [("ggx", 0.3)])
    assert albedo == pytest.approx(np.full((3, 3), 0.7), rel=STATED_ERROR)


@pytest.mark.parametrize("name", ["metal_foil", "clean_copper", "blue_wall_paint"])
def test_stated_error_holds(name):
    stack = presets.load(name)
    model = make_model("closure_model", stack, method="weidlich_wilkie")
    coarse = directional_albedo(model.f, WO, rough_surfaces(stack))
    fine = directional_albedo(model.f, WO, rough_surfaces(stack), 4 * 8192)
    # errors fall with the count: four times the points are off by a quarter of this themselves
    assert np.max(np.abs(coarse / fine - 1.0)) < 0.8 * STATED_ERROR
