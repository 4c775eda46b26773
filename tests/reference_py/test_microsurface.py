# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from support.chi_square import chi_square_p_value

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.optics import microsurface
from lamina.reference_py.optics.frame import dot, spherical
from lamina.reference_py.optics.microfacet import distribution, masking_g1
from lamina.reference_py.optics.microsurface import scatter_conductor, scatter_dielectric, scattering_density
from lamina.reference_py.optics.sampling import (
    projected_area,
    sample_visible_normals,
    visible_normal_density,
)

KINDS = ("ggx", "beckmann")
# Rejects a right sampler once in 10 000 runs per case; seeds are fixed.
SIGNIFICANCE = 1e-4


def rows(theta_deg, n, phi=0.7):
    return np.repeat(spherical(np.radians(theta_deg), phi)[None], n, axis=0)


def hemisphere(n, rng, side=1):
    """Directions of constant density 1 / (2 pi)."""
    z, phi = rng.random(n), 2.0 * np.pi * rng.random(n)
    sin = np.sqrt(1.0 - z * z)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), side * z], axis=-1)


def mirror(cos):
    return np.ones((len(cos), 1))


def assert_close(value, spread_of, n, expected, floor=0.0):
    """Within four standard errors."""
    error = np.std(spread_of) / np.sqrt(n)
    assert abs(value - expected) <= 4.0 * error + floor, (value, expected, error)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("theta", (10.0, 70.0, 95.0, 130.0))
def test_projected_area_is_the_area_of_facets_seen(kind, theta):
    w, alpha, n = spherical(np.radians(theta), 0.0), 0.5, 1200
    z, phi = (np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2.0 * np.pi
    sin = np.sqrt(1.0 - z * z)[:, None]
    seen = np.maximum(sin * np.cos(phi) * w[0] + z[:, None] * w[2], 0.0)
    area = np.sum(seen * distribution(z, alpha, kind)[:, None]) * 2.0 * np.pi / n**2
    assert projected_area(w[None], alpha, kind)[0] == pytest.approx(area, rel=2e-4)


@pytest.mark.parametrize("kind, tolerance", (("ggx", 1e-12), ("beckmann", 4e-3)))
def test_masking_is_that_of_the_closures(kind, tolerance):
    w = spherical(np.linspace(0.1, 1.5, 40), 0.0)
    assert microsurface.masking(w, 0.4, kind) == pytest.approx(masking_g1(w[:, 2], 0.4, kind), rel=tolerance)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("alpha", (0.05, 0.5, 1.0))
@pytest.mark.parametrize("theta", (0.0, 60.0, 88.0, 110.0))
def test_visible_normals_follow_their_density(kind, alpha, theta):
    if theta > 90.0 and alpha == 0.05:
        theta = 91.0  # beyond, such a ray has left the surface for certain
    n = 40_000
    wm = sample_visible_normals(rows(theta, n), alpha, kind, np.random.default_rng(3))
    assert np.max(np.abs(dot(wm, wm) - 1.0)) < 1e-9
    p = chi_square_p_value(wm, lambda m: visible_normal_density(rows(theta, len(m)), m, alpha, kind))
    assert p > SIGNIFICANCE


def test_chi_square_finds_a_wrong_width():
    wm = sample_visible_normals(rows(50.0, 40_000), 0.5, "ggx", np.random.default_rng(3))
    p = chi_square_p_value(wm, lambda m: visible_normal_density(rows(50.0, len(m)), m, 0.55, "ggx"))
    assert p < SIGNIFICANCE


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("eta", (1.5, 1.0 / 1.5))
@pytest.mark.parametrize("side", (1, -1))
def test_single_scattering_follows_its_density(kind, eta, side):
    n, alpha = 60_000, 0.4
    w = rows(40.0, n)
    rng = np.random.default_rng(11)
    wm = sample_visible_normals(w, alpha, kind, rng)
    cos = dot(w, wm)
    reflectance, cos_t = microsurface.fresnel_and_refraction(cos, eta)
    reflected = rng.random(n) < reflectance
    o = microsurface._bend(w, wm, cos, cos_t, eta, reflected)
    o = o[((o[:, 2] > 0.0) == reflected) & (np.sign(o[:, 2]) == side)]
    p = chi_square_p_value(o, lambda x: scattering_density(rows(40.0, len(x)), x, eta, alpha, kind), hemisphere=side, drawn=n)
    assert p > SIGNIFICANCE


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("alpha", (0.1, 1.0))
@pytest.mark.parametrize("eta", (1.5, 1.0 / 1.5))
@pytest.mark.parametrize("theta", (0.0, 85.0))
def test_multiple_loses_nothing(kind, alpha, eta, theta):
    n = 5_000
    scattered = scatter_dielectric(rows(theta, n), eta, alpha, kind, np.random.default_rng(0))
    assert np.all(scattered.weight == 1.0)
    assert np.max(np.abs(dot(scattered.direction, scattered.direction) - 1.0)) < 1e-9
    metal = scatter_conductor(rows(theta, n), mirror, alpha, kind, np.random.default_rng(0))
    assert np.all(metal.weight == 1.0) and np.all(metal.direction[:, 2] > 0.0)


def test_single_loses_what_facets_send_to_the_wrong_side():
    n = 20_000
    weight = scatter_conductor(rows(0.0, n), mirror, 1.0, "ggx", np.random.default_rng(0), "single").weight
    # white GGX of alpha 1 at normal incidence, by quadrature of D G1 G1 / 4 over the hemisphere
    z = (np.arange(4000) + 0.5) / 4000
    cos_h = np.sqrt(0.5 * (1.0 + z))
    energy = np.sum(distribution(cos_h, 1.0, "ggx") / 4.0 * masking_g1(z, 1.0, "ggx")) * 2.0 * np.pi / 4000
    assert_close(weight.mean(), weight, n, energy, floor=1e-4)
    assert energy < 0.7


def energies(surface, kind, eta, alpha=0.5, theta=60.0, n=60_000):
    """(sampled energy, energy of the evaluated BSDF, values) per side."""
    rng = np.random.default_rng(5)
    w = rows(theta, n)
    scattered = scatter_dielectric(w, eta, alpha, kind, rng, surface)
    for side in (1, -1):
        on_side = scattered.weight * (scattered.direction[:, 2] * side > 0.0)
        toward = scatter_dielectric(w, eta, alpha, kind, rng, surface, hemisphere(n, rng, side)).toward
        yield on_side, 2.0 * np.pi * toward


@pytest.mark.parametrize("surface", microsurface.SURFACES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("eta", (1.5, 1.0 / 1.5))
def test_evaluation_integrates_to_the_sampled_energy(surface, kind, eta):
    for sampled, evaluated in energies(surface, kind, eta):
        error = np.hypot(np.std(sampled), np.std(evaluated)) / np.sqrt(len(sampled))
        assert abs(evaluated.mean() - sampled.mean()) < 4.0 * error


@pytest.mark.parametrize("surface", microsurface.SURFACES)
def test_a_lost_jacobian_is_caught(surface, monkeypatch):
    monkeypatch.setattr(microsurface, "refraction_jacobian", lambda eta, length2: np.ones_like(length2))
    _, (sampled, evaluated) = energies(surface, "ggx", 1.5)
    error = np.hypot(np.std(sampled), np.std(evaluated)) / np.sqrt(len(sampled))
    assert abs(evaluated.mean() - sampled.mean()) > 20.0 * error


@pytest.mark.parametrize("kind", KINDS)
def test_conductor_evaluation_integrates_to_one(kind):
    n, rng = 60_000, np.random.default_rng(2)
    target = hemisphere(n, rng)
    value = 2.0 * np.pi * scatter_conductor(rows(50.0, n), mirror, 0.6, kind, rng, "multiple", target).toward[:, 0]
    assert_close(value.mean(), value, n, 1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_multiple_is_reciprocal(kind):
    """f_r(a, b) = f_r(b, a), and f_t(a, b) / n_b^2 = f_t(b, a) / n_a^2 (Walter07)."""
    n, eta, alpha, rng = 100_000, 1.5, 0.7, np.random.default_rng(8)
    a, b = rows(30.0, n, 0.0), rows(65.0, n, 2.0)
    there = scatter_dielectric(a, eta, alpha, kind, rng, "multiple", b).toward / b[0, 2]
    back = scatter_dielectric(b, eta, alpha, kind, rng, "multiple", a).toward / a[0, 2]
    below = rows(155.0, n, 2.8)
    down = scatter_dielectric(a, eta, alpha, kind, rng, "multiple", below).toward / -below[0, 2] / eta**2
    up = scatter_dielectric(-below, 1.0 / eta, alpha, kind, rng, "multiple", -a).toward / a[0, 2]
    for first, second in ((there, back), (down, up)):
        error = np.hypot(first.std(), second.std()) / np.sqrt(n)
        assert error < 0.02 * first.mean()
        assert abs(first.mean() - second.mean()) < 4.0 * error


def test_same_seed_same_result():
    runs = [scatter_dielectric(rows(30.0, 500), 1.5, 0.5, "ggx", np.random.default_rng(4)).direction for _ in "ab"]
    assert np.array_equal(*runs)


def test_unknown_surface_names_the_choices():
    with pytest.raises(LaminaError, match="'double'; choose multiple, single"):
        scatter_dielectric(rows(30.0, 5), 1.5, 0.5, "ggx", np.random.default_rng(4), "double")
