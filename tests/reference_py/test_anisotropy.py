# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of anisotropic surfaces: of the closures, and of the tier `analytic` against walks through the whole stack."""

import numpy as np
import pytest

from lamina.reference_py.lobes.analytic.brushed import seen_alpha
from lamina.reference_py.lobes.analytic.interface_tables import anisotropic_energy
from lamina.reference_py.lobes.brushing import isotropic
from lamina.reference_py.lobes.closure import lobe_energy, lobe_f, unit_energy
from lamina.reference_py.lobes.lobe import DielectricCurve, GlossyLobe
from lamina.reference_py.lobes.made import DEFAULT_TOLERANCE
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.methods.auto import with_anisotropy
from lamina.reference_py.lobes.methods.not_bakeable import not_bakeable
from lamina.reference_py.lobes.tabulate import tabulate
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.interface import AnisotropicRoughness
from lamina.reference_py.optics.quadrature import directional_albedo
from lamina.reference_py.registry import make_model

THETA = np.radians([0.0, 20.0, 40.0, 60.0, 80.0])
AZIMUTHS = np.radians([0.0, 45.0, 90.0])
COAT = {"kind": "dielectric", "roughness": 0.0}


def metal(reflectance=0.999, **values):
    return {"kind": "conductor", "reflectance": [reflectance] * 3, "edge_color": [1.0] * 3, "roughness": 0.5, "anisotropy": 1.0, **values}


METALS = {
    "white": metal(),
    "grey": metal(0.9),
    "white, rougher": metal(roughness=0.75),
    "grey, rougher, less": metal(0.9, roughness=0.7, anisotropy=0.8, rotation=0.1),
    "white, beckmann": metal(distribution="beckmann"),
    "grey, smoother": metal(0.9, roughness=0.35),
}


def energies(lobe_set, theta=THETA, azimuths=AZIMUTHS):
    """(azimuths, angles, 3)."""
    return np.stack([sum(lobe_energy(lobe, np.cos(theta), phi) for lobe in lobe_set.lobes(np.cos(theta), phi)) for phi in azimuths])


def walked(stack, theta=THETA, azimuths=AZIMUTHS, walks=1 << 14):
    return make_model("position_free", stack, walks=walks).albedo_stderr(spherical(theta, azimuths[:, None]))


@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_energy_of_a_closure_at_an_azimuth(kind):
    """Importance-sampled and by a quadrature that knows nothing of the lobe's axes."""
    lobe = GlossyLobe(kind, np.ones(3), np.float64(0.6), np.float64(0.25), frame=0.4)
    for phi in (0.4, 1.2, 0.4 + np.pi / 2.0):
        wo = spherical(np.radians([0.0, 50.0, 75.0]), phi)
        exact = directional_albedo(lambda o, i: np.where(i[..., 2:] > 0.0, lobe_f(lobe, o, i), 0.0), wo, [(kind, 0.6), (kind, 0.25)], 1 << 14)
        assert unit_energy(lobe, wo[:, 2], phi) == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_the_table_of_anisotropic_closures(kind):
    rng, errors = np.random.default_rng(3), []
    for _ in range(150):
        alpha, aspect = rng.uniform(0.2, 1.0) ** 2, np.sqrt(1.0 - 0.9 * rng.uniform())
        alpha_x, alpha_y = min(alpha / aspect, 1.0), alpha * aspect
        cos_o, phi = np.cos(np.radians(rng.uniform(0.0, 82.0, 1))), rng.uniform(0.0, np.pi)
        exact = unit_energy(GlossyLobe(kind, np.ones(3), alpha_x, alpha_y, frame=0.0), cos_o, phi)[0, 0]
        errors.append(abs(anisotropic_energy(cos_o, phi, alpha_x, alpha_y, kind)[0] / exact - 1.0))
    print(f"{kind}: 95 % {np.percentile(errors, 95):.4f}, worst {max(errors):.4f}")
    assert np.percentile(errors, 95) < 0.006 and max(errors) < 0.015


@pytest.mark.parametrize("name", METALS)
def test_a_brushed_metal_reflects_what_it_should(name):
    """Along, between and across, 0 to 80 degrees. With the isotropic surface's weights white was 1.082 and grey .9688 for .8866 at 60 degrees."""
    stack = Stack.from_dict({"base": METALS[name]})
    truth, stderr = walked(stack)
    for lobe_set in (make_lobe_set(stack, "analytic"), tabulate(make_lobe_set(stack, "analytic"))):
        error = np.abs(energies(lobe_set) / truth - 1.0)
        print(f"{name}: {error.max():.4f}, standard error {np.max(stderr / truth):.1e}")
        assert np.all(error < 0.01 + 3.0 * stderr / truth)


def test_isotropic_weights_would_be_caught():
    stack = Stack.from_dict({"base": metal()})
    plain, own = make_lobe_set(isotropic(stack), "analytic").lobes(np.cos(THETA)), make_lobe_set(stack, "analytic").lobes(np.cos(THETA))
    wrong = plain[0].weight * unit_energy(own[0], np.cos(THETA), 0.0)
    print(np.round(wrong[:, 0], 4))
    assert wrong[0, 0] == pytest.approx(1.018, abs=2e-3) and wrong[3, 0] == pytest.approx(1.082, abs=2e-3)


def test_no_anisotropy_is_the_limit():
    for base in (metal(0.6, anisotropy=0.0), {"kind": "lambert", "color": [0.5, 0.4, 0.3]}):
        stack = Stack.from_dict({"layers": [{**COAT, "roughness": 0.5, "anisotropy": 0.0}], "base": base})
        assert energies(make_lobe_set(stack, "analytic")) == pytest.approx(energies(make_lobe_set(isotropic(stack), "analytic")), rel=1e-3)


@pytest.mark.parametrize("eta", [1.2, 1.5])
def test_what_a_view_sees_of_an_anisotropic_coat(eta):
    """Reflectances of single scattering, of the anisotropic closure and of the isotropic one that stands for it."""
    curve, worst = DielectricCurve(eta), np.zeros(len(THETA))
    for alpha_x, alpha_y in ((0.79, 0.079), (0.61, 0.39), (0.28, 0.028)):
        for phi in AZIMUTHS:
            exact = unit_energy(GlossyLobe("ggx", np.ones(3), alpha_x, alpha_y, fresnel=curve, frame=0.0), np.cos(THETA), phi)
            alpha = seen_alpha(AnisotropicRoughness(alpha_x, alpha_y, 0.0), np.cos(THETA), phi)
            stands_in = unit_energy(GlossyLobe("ggx", np.ones(3), alpha, alpha, fresnel=curve), np.cos(THETA))
            worst = np.maximum(worst, np.abs(stands_in - exact)[:, 0])
    print(f"eta {eta:g}: {np.round(worst, 4)}")
    assert np.all(worst[:4] < 0.011) and worst[4] < 0.035


def test_a_white_base_under_a_brushed_coat_stays_white():
    stack = Stack.from_dict({"layers": [{**COAT, "roughness": 0.5, "anisotropy": 1.0}], "base": {"kind": "lambert", "color": [1.0] * 3}})
    for lobe_set in (make_lobe_set(stack, "analytic"), tabulate(make_lobe_set(stack, "analytic"))):
        found = energies(lobe_set)
        print(np.round(found[..., 0], 4))
        assert found == pytest.approx(np.ones_like(found), abs=0.01)


@pytest.mark.parametrize(
    "name, layers, base, most",
    [
        ("smooth coat over white", [COAT], metal(), 0.017),
        ("rough coat over white", [{**COAT, "roughness": 0.3}], metal(), 0.021),
    ],
)
def test_coated_brushed_metals_are_as_good_as_isotropic_ones(name, layers, base, most):
    """To .5 % of the light: the tier's own error over a white metal is 1.6 %."""
    stack = Stack.from_dict({"layers": layers, "base": base})
    truth, stderr = walked(stack)
    error = np.abs(energies(make_lobe_set(stack, "analytic")) - truth)
    plain = isotropic(stack)
    own = np.abs(energies(make_lobe_set(plain, "analytic"), azimuths=AZIMUTHS[:1])[0] - make_model("adding", plain).albedo(spherical(THETA, 0.0)))
    print(f"{name}: {error.max():.4f}, without anisotropy {own.max():.4f}, standard error {stderr.max():.1e}")
    assert np.all(error < most + 3.0 * stderr)


def test_the_estimated_error_knows_the_anisotropy():
    """Of the tier that forgets what facets hide from each other it is large, of the other what walks say."""
    stack = Stack.from_dict({"base": metal(0.9)})
    choice = make_lobe_set(isotropic(stack), "auto", live=not_bakeable(stack)).choice
    told = {c.label: c for c in with_anisotropy(choice, stack, DEFAULT_TOLERANCE).tried}
    theta, azimuths = np.radians([15.0, 45.0, 75.0]), np.radians([0.0, 90.0])
    truth, _ = walked(stack, theta, azimuths)
    for tier, candidate in told.items():
        error = np.max(np.abs(energies(make_lobe_set(stack, tier), theta, azimuths) / truth - 1.0))
        print(f"{tier}: estimated {candidate.albedo:.4f}, found {error:.4f}")
        assert candidate.albedo == pytest.approx(error, rel=0.2, abs=3e-3)
    assert told["analytic"].albedo < 0.01 < 0.3 < told["weidlich_wilkie"].albedo
