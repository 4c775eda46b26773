# SPDX-License-Identifier: GPL-3.0-or-later
"""Eq. 1's geometric attenuation beside rays in a groove, at directions where light is blocked."""

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack, view

from lamina.reference_py.frame import dot, half_vector
from lamina.reference_py.models.weidlich_wilkie import WeidlichWilkie
from lamina.reference_py.optics.fresnel import fresnel_conductor, fresnel_dielectric
from lamina.reference_py.optics.microfacet import blinn_exponent, masking_v_cavity

# Angles from the normal in one plane, in degrees; the other side is negative. The facet that mirrors one into the other is
# tilted by half their sum, and where both are on its side the groove's other wall blocks.
BLOCKED = [(70.0, 70.0), (60.0, 50.0), (80.0, 20.0), (75.0, -10.0), (85.0, 40.0), (-65.0, -80.0)]
OPEN = [(0.0, 0.0), (60.0, -60.0), (30.0, 20.0), (70.0, -50.0)]


def visible(tilt, theta, rays=200001):
    """Share of a groove's wall, tilted by `tilt` towards +x, that is seen from `theta`; both in radians.

    The wall goes from the groove's bottom at the origin up to (-cos, sin)(tilt), the other one to (cos, sin)(tilt).
    """
    s = (np.arange(rays) + 0.5) / rays
    x, z = -s * np.cos(tilt), s * np.sin(tilt)
    if theta <= 0.0:
        return 1.0  # nothing stands on that side of this wall
    # height of the ray where it is above the other wall's rim
    return float(np.mean(z + (np.cos(tilt) - x) / np.tan(theta) >= np.sin(tilt)))


def attenuation(theta_i, theta_o):
    """What is neither blocked on its way in nor on its way out: the same part of the wall, its lower one, is hidden from both."""
    tilt = 0.5 * np.radians(theta_i + theta_o)
    side = 1.0 if tilt >= 0.0 else -1.0
    return min(visible(side * tilt, side * np.radians(theta)) for theta in (theta_i, theta_o))


@pytest.mark.parametrize("theta_i, theta_o", BLOCKED + OPEN)
def test_the_factor_is_what_rays_see_of_a_groove(theta_i, theta_o):
    wi, wo = view(theta_i), view(theta_o)
    wh = half_vector(wi, wo)
    expected = attenuation(theta_i, theta_o)
    assert (expected < 0.9) == ((theta_i, theta_o) in BLOCKED)
    assert masking_v_cavity(wi[2], wo[2], wh[2], dot(wi, wh)) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("theta_i, theta_o", BLOCKED)
def test_equation_1_with_its_factor(theta_i, theta_o):
    """D of eq. 7 times the groove's share, on a metal and on a varnish."""
    wi, wo = view(theta_i), view(theta_o)
    wh = half_vector(wi, wo)
    cos_h, m = np.cos(0.5 * np.radians(theta_i - theta_o)), blinn_exponent(0.5)
    d = (m + 2.0) / (2.0 * np.pi) * wh[2] ** m
    lobe = d * attenuation(theta_i, theta_o) / (4.0 * wi[2] * wo[2])
    options = {"distribution": "blinn", "masking": "v_cavity"}
    metal = WeidlichWilkie(stack(base=conductor(0.2, 3.9, 0.5)), **options).f(wo, wi)
    assert metal == pytest.approx(np.full(3, fresnel_conductor(cos_h, 0.2, 3.9) * lobe), rel=1e-3)
    varnish = WeidlichWilkie(stack(coat(0.5), base=lambert(0.0)), **options).f(wo, wi)
    assert varnish == pytest.approx(np.full(3, fresnel_dielectric(cos_h, 1.5) * lobe), rel=1e-3)


def test_out_of_the_plane():
    """Torrance and Sparrow's closed form: 2 (n h) (n w) / (w h) of the lower direction, at most 1."""
    wi, wo = view(80.0, 1.2), view(60.0)
    wh = half_vector(wi, wo)
    expected = 2.0 * wh[2] * np.cos(np.radians(80.0)) / float(wi @ wh)
    assert 0.1 < expected < 0.5
    for one, other in ((wi, wo), (wo, wi)):
        assert masking_v_cavity(one[2], other[2], wh[2], dot(one, wh)) == pytest.approx(expected)
