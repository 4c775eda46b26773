# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of the tier `analytic` against the adding operators they come from, off their nodes."""

import numpy as np
import pytest

from lamina.reference_py.lobes.analytic import interface_tables
from lamina.reference_py.lobes.closure import unit_energy
from lamina.reference_py.lobes.lobe import DielectricCurve, GlossyLobe
from lamina.reference_py.optics.fresnel import fresnel_dielectric
from lamina.study.make_interface_tables import lossless_reflectance

COS = np.cos(np.radians(np.linspace(0.0, 85.0, 18)))
KINDS = ("ggx", "beckmann")


def surfaces(count=10, seed=3):
    """(alpha, eta > 1) between the tables' nodes."""
    rng = np.random.default_rng(seed)
    return zip(rng.uniform(0.01, 1.0, count), rng.uniform(1.1, 2.5, count))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("side, mean_bound, bound", [("thin", 0.001, 0.0075), ("dense", 0.006, 0.025)])
def test_reflectance(kind, side, mean_bound, bound):
    errors = []
    for alpha, eta in surfaces():
        eta = eta if side == "thin" else 1.0 / eta
        errors.append(interface_tables.reflectance(COS, alpha, eta, kind) - lossless_reflectance(COS, alpha, eta, kind))
    errors = np.abs(errors)
    print(f"{kind} {side}: mean {errors.mean():.4f}, worst {errors.max():.4f}")
    assert errors.mean() <= mean_bound
    assert errors.max() <= bound


@pytest.mark.parametrize("eta", [1.5, 1.0 / 1.5, 1.0])
def test_a_smooth_interface_is_exact(eta):
    assert interface_tables.reflectance(COS, 0.0, eta, "ggx") == pytest.approx(fresnel_dielectric(COS, eta), abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_diffuse_reflectance_is_the_mean(kind):
    x, w = np.polynomial.legendre.leggauss(40)
    u = 0.5 * (x + 1.0)
    for eta in (1.6, 1.0 / 1.6):
        mean = np.sum(w * u * interface_tables.reflectance(u, 0.4, eta, kind))
        assert interface_tables.diffuse_reflectance(0.4, eta, kind) == pytest.approx(mean, abs=0.015)


@pytest.mark.parametrize("kind", KINDS)
def test_top_lobe_has_the_energy_of_the_interface(kind):
    for alpha, eta in surfaces(4):
        lobe = GlossyLobe(kind, np.ones(3), alpha, alpha, fresnel=DielectricCurve(eta))
        energy = interface_tables.top_gain(COS, alpha, eta, kind) * unit_energy(lobe, COS)[:, 0]
        assert np.max(np.abs(energy - lossless_reflectance(COS, alpha, eta, kind))) <= 0.006


@pytest.mark.parametrize("kind", KINDS)
def test_closure_energy(kind):
    for alpha in (0.04, 0.25, 0.6, 0.9):
        exact = unit_energy(GlossyLobe(kind, np.ones(3), alpha, alpha), COS)[:, 0]
        assert interface_tables.closure_energy(COS, alpha, kind) == pytest.approx(exact, abs=0.012)


def test_critical_variable_and_its_inverse():
    v = np.linspace(-0.99, 1.0, 50)
    assert interface_tables.critical_variable(interface_tables.cosine_of_critical_variable(v, 0.7), 0.7) == pytest.approx(v, abs=1e-9)
