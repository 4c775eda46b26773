# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel, microfacet and diffuse formulas against closed values and integrals."""

import numpy as np
import pytest

from lamina.reference_py.lobes.lobe import DARK
from lamina.reference_py.optics import microfacet
from lamina.reference_py.optics.diffuse import CYCLES_5_2_POWER, OREN_NAYAR_POWER, oren_nayar, oren_nayar_1994, oren_nayar_shares
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import cos_theta_t, fresnel_conductor, fresnel_dielectric
from lamina.reference_py.optics.quadrature import directional_albedo

COS = np.linspace(0.0, 1.0, 101)


def test_dielectric_at_normal_incidence_brewster_and_grazing():
    assert fresnel_dielectric(1.0, 1.5) == pytest.approx(0.04)
    assert fresnel_dielectric(0.0, 1.5) == pytest.approx(1.0)
    brewster = np.cos(np.arctan(1.5))
    r_s = ((1.5**2 - 1.0) / (1.5**2 + 1.0)) ** 2
    assert fresnel_dielectric(brewster, 1.5) == pytest.approx(0.5 * r_s)


@pytest.mark.parametrize("eta", [1.1, 1.5, 2.4])
def test_dielectric_is_the_same_from_either_side_and_total_beyond_the_critical_angle(eta):
    assert fresnel_dielectric(cos_theta_t(COS, eta), 1.0 / eta)[1:] == pytest.approx(fresnel_dielectric(COS, eta)[1:])
    critical = np.sqrt(1.0 - 1.0 / eta**2)
    assert np.all(fresnel_dielectric(np.linspace(0.0, critical - 1e-9, 9), 1.0 / eta) == 1.0)


def test_equal_indices_reflect_nothing():
    assert np.all(fresnel_dielectric(COS, 1.0) == 0.0)


def test_conductor_without_extinction_is_a_dielectric():
    assert fresnel_conductor(COS, 1.5, 0.0) == pytest.approx(fresnel_dielectric(COS, 1.5), abs=1e-12)


@pytest.mark.parametrize("kind", [microfacet.GGX, microfacet.BECKMANN, microfacet.BLINN])
@pytest.mark.parametrize("alpha", [0.05, 0.3, 0.9])
def test_distribution_has_projected_area_one(kind, alpha):
    cos, weight = np.polynomial.legendre.leggauss(400)
    cos, weight = 0.5 * (cos + 1.0), 0.5 * weight
    area = 2.0 * np.pi * np.sum(weight * microfacet.distribution(cos, alpha, kind) * cos)
    assert area == pytest.approx(1.0, rel=2e-3)


def test_blinn_and_beckmann_agree_for_small_angles():
    cos = np.cos(np.linspace(0.0, 0.06, 20))
    blinn, beckmann = (microfacet.distribution(cos, 0.03, kind) for kind in (microfacet.BLINN, microfacet.BECKMANN))
    assert blinn == pytest.approx(beckmann, rel=0.02)


@pytest.mark.parametrize("sigma_deg", [0.0, 20.0, 60.0])
def test_white_oren_nayar_keeps_all_light_and_is_reciprocal(sigma_deg):
    wo = spherical(np.radians([0.0, 40.0, 80.0]), 0.0)
    albedo = directional_albedo(lambda o, i: oren_nayar(i, o, np.ones(3), sigma_deg), wo, [])
    assert albedo == pytest.approx(np.ones((3, 3)), abs=2e-3)
    rng = np.random.default_rng(1)
    a, b = (spherical(rng.uniform(0, 1.5, 50), rng.uniform(0, 6, 50)) for _ in range(2))
    color = np.array([0.2, 0.5, 0.9])
    assert oren_nayar(a, b, color, sigma_deg) == pytest.approx(oren_nayar(b, a, color, sigma_deg))


@pytest.mark.parametrize("color, sigma_deg, expected", [(0.5, 90.0, 0.4510), (0.18, 60.0, 0.1554)])
def test_between_facets_oren_nayar_has_the_square_of_the_color(color, sigma_deg, expected):
    """Albedos along the normal that Blender 5.3's own closure renders; with the cube they were .4298 and .1516."""
    normal, found = np.array([0.0, 0.0, 1.0]), []
    for power in (OREN_NAYAR_POWER, CYCLES_5_2_POWER):
        found.append(directional_albedo(lambda o, i: oren_nayar(i, o, (color,) * 3, sigma_deg, power), normal, [])[0])
    print(f"square {found[0]:.4f}, cube {found[1]:.4f}")
    assert found[0] == pytest.approx(expected, abs=1e-4)


def test_white_and_one_facet_make_every_oren_nayar():
    """In every power; so what is made of a white and a dark closure is the same in every Blender."""
    rng = np.random.default_rng(2)
    a, b = (spherical(rng.uniform(0, 1.5, 50), rng.uniform(0, 6, 50)) for _ in range(2))
    color = np.array([0.2, 0.5, 0.95])
    white, single = oren_nayar_shares(color, 60.0)
    for power in (OREN_NAYAR_POWER, CYCLES_5_2_POWER):
        parts = white * oren_nayar(a, b, np.ones(3), 60.0, power) + single * oren_nayar(a, b, np.full(3, DARK), 60.0, power) / DARK
        assert parts == pytest.approx(oren_nayar(a, b, color, 60.0), rel=1e-5)
    assert np.all(white > 0.0) and np.all(single > 0.0)


def test_oren_nayar_of_1994_scatters_back():
    wo, back, front = spherical(np.radians([60.0, 60.0, 60.0]), np.radians([0.0, 0.0, 180.0]))
    assert np.all(oren_nayar_1994(back, wo, np.ones(3), 30.0) > 1.3 * oren_nayar_1994(front, wo, np.ones(3), 30.0))
