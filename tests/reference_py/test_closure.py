# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of single closures against an independent integral of their f."""

from dataclasses import replace

import numpy as np
import pytest

from lamina.reference_py.lobes.closure import fresnel_share, lobe_f, unit_energy
from lamina.reference_py.lobes.lobe import DielectricCurve, GlossyLobe, SchlickCurve
from lamina.reference_py.lobes.view_table import knot_cosines
from lamina.reference_py.optics.frame import spherical

VIEWS_DEG = np.array([0.0, 40.0, 75.0, 85.0])
LOBES = {
    "narrow": ("ggx", 0.02, 0.02, 0.0, None),
    "wide": ("ggx", 0.8, 0.8, 0.0, None),
    "beckmann": ("beckmann", 0.3, 0.3, 0.0, None),
    "stretched_tilted": ("ggx", 0.15, 0.4, 0.12, None),
    "beckmann_tilted_away": ("beckmann", 0.3, 0.2, -0.1, None),
    "coat": ("ggx", 0.2, 0.2, 0.0, DielectricCurve(1.5)),
}


@pytest.mark.parametrize("name", LOBES)
def test_energy_equals_the_integral_of_f(name):
    distribution, alpha_x, alpha_y, tilt, curve = LOBES[name]
    lobe = GlossyLobe(distribution, np.ones(3), alpha_x, alpha_y, np.float64(tilt), curve)
    cos_o = np.cos(np.radians(VIEWS_DEG))
    measured = unit_energy(lobe, cos_o)[:, 1]
    for theta, energy in zip(VIEWS_DEG, measured):
        assert energy == pytest.approx(_integral(lobe, np.radians(theta)), rel=5e-4), theta


@pytest.mark.parametrize("most_tilt, worst, median", [(0.0, 3e-4, 1e-4), (0.6, 3e-3, 1e-4)])
def test_the_energy_of_any_lobe_is_within_what_is_said(most_tilt, worst, median):
    """Against 21 times the directions, at views to 85 degrees."""
    rng, cos_o, errors = np.random.default_rng(11), np.cos(np.radians(np.linspace(0.0, 85.0, 9))), []
    for _ in range(24):
        alpha_x, alpha_y = np.power(10.0, rng.uniform(-1.7, 0.0)) * np.array([1.0, rng.uniform(0.5, 1.0)])
        lobe = GlossyLobe(rng.choice(["ggx", "beckmann"]), np.ones(3), alpha_x, alpha_y, np.float64(rng.uniform(0.0, most_tilt)))
        exact = unit_energy(lobe, cos_o, rule=(1024, 128))
        errors.append(np.max(np.abs(unit_energy(lobe, cos_o) / exact - 1.0)))
    print(f"median {np.median(errors):.1e}, worst {np.max(errors):.1e}")
    assert np.max(errors) < worst and np.median(errors) < median


CURVES = {
    "dielectric": (DielectricCurve(1.5), 3e-4),
    "schlick": (SchlickCurve(np.full(3, 0.04), np.ones(3)), 3e-4),
    "total reflection": (DielectricCurve(0.7), 3e-3),
}


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("frame, least", [(None, 0.0), (0.0, 7e-4)])
def test_the_share_of_a_curve_is_a_ratio_of_energies(curve, frame, least):
    """Narrow and wide, upright, tilted and brushed lobes, at every knot, against sixteen times the directions."""
    curve, bound = CURVES[curve]
    cos_o, errors = knot_cosines(), []
    for kind in ("ggx", "beckmann"):
        for alpha_x, alpha_y, tilt in ((0.03, 0.03, 0.0), (0.3, 0.3, 0.0), (0.1, 0.15, 0.2)):
            lobe = GlossyLobe(kind, np.ones(3), alpha_x, alpha_y, tilt * np.arccos(cos_o) if frame is None else 0.0, curve, frame)
            exact = unit_energy(lobe, cos_o, 0.7, (256, 64)) / unit_energy(replace(lobe, fresnel=None), cos_o, 0.7, (256, 64))
            errors.append(np.abs(fresnel_share(lobe, cos_o, 0.7) - exact))
    print(f"median {np.median(errors):.1e}, worst {np.max(errors):.1e}")
    assert np.max(errors) < max(bound, least)


def _integral(lobe, theta):
    """Midpoints in the polar angle and azimuth of the half vector about the lobe's own normal."""
    wo = spherical(theta, 0.0)
    x = (np.arange(800) + 0.5) / 800
    # tan(theta_m) crowds where the distribution lives
    tan_m = max(lobe.alpha_x, lobe.alpha_y) * x / (1.0 - x)
    theta_m = np.arctan(tan_m)
    step = max(lobe.alpha_x, lobe.alpha_y) / np.square(1.0 - x) / (1.0 + tan_m**2) / len(x)
    phi = 2.0 * np.pi * (np.arange(400) + 0.5) / 400
    m = spherical(theta_m[:, None], phi[None, :])
    cos_t, sin_t = np.cos(lobe.tilt), np.sin(lobe.tilt)
    wm = np.stack([cos_t * m[..., 0] + sin_t * m[..., 2], m[..., 1], cos_t * m[..., 2] - sin_t * m[..., 0]], axis=-1)
    cos_om = wm @ wo
    wi = 2.0 * cos_om[..., None] * wm - wo
    measure = (np.sin(theta_m) * step)[:, None] * (2.0 * np.pi / len(phi)) * 4.0 * np.abs(cos_om)
    seen = (cos_om > 0.0) & (wi[..., 2] > 0.0)
    wi = np.where(seen[..., None], wi, np.array([0.0, 0.0, 1.0]))
    f = lobe_f(lobe, np.broadcast_to(wo, wi.shape), wi)[..., 1]
    return float(np.sum(np.where(seen, f * wi[..., 2] * measure, 0.0)))


@pytest.mark.filterwarnings("error")
def test_a_lobe_is_a_mirror_where_its_width_is_none():
    wo, wi = spherical(np.radians([20.0, 50.0, 50.0]), 0.0), spherical(np.radians([20.0, 50.0, 50.0]), np.pi)
    alpha = np.array([0.0, 0.0, 0.3])
    lobe = GlossyLobe("ggx", np.ones((3, 3)), alpha, alpha, np.zeros(3), None)
    f = lobe_f(lobe, wo, wi)
    assert np.all(f[:2] == 0.0) and np.all(f[2] > 0.0)
