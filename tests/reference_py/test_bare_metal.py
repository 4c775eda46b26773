# SPDX-License-Identifier: GPL-3.0-or-later
"""Bare metals: over live values the closure with a metal's own curve and what is reflected more often, constants as fits."""

import numpy as np
import pytest
from support.coats import METAL

from lamina.reference_py.lobes.baked import baked
from lamina.reference_py.lobes.baked.bare_metal import bake_metal, is_bare_metal
from lamina.reference_py.lobes.closure import lobe_energy, lobe_f, unit_energy
from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.live_grid import LiveLobes
from lamina.reference_py.lobes.lobe import ConductorCurve, GlossyLobe
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.serialize import pack_grid, unpack_grid
from lamina.reference_py.lobes.tabulate import tabulate, without_metals
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.bases import ConductorBase
from lamina.reference_py.optics.quadrature import balanced_directions

COSINES = np.cos(np.radians([0.0, 20.0, 40.0, 60.0, 75.0, 80.0]))
ROUGHNESS, REFLECTANCE, EDGE = (Place(None, name) for name in ("roughness", "reflectance", "edge_color"))
BARE = Stack.from_dict({"base": METAL})


def with_values(stack: Stack, **values) -> Stack:
    for name, value in values.items():
        stack = Place(None, name).with_value(stack, value)
    return stack


def drawn(rng, stack: Stack, live) -> Stack:
    for place in live:
        stack = place.with_value(stack, float(rng.uniform(0.05, 0.9)) if place is ROUGHNESS else tuple(rng.uniform(0.03, 0.97, 3)))
    return stack


@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_a_metals_closure_has_its_curve_and_energy(roughness):
    """Its f over the cosine is its energy, and along a mirror's direction it is the metal's reflectance of what a white one has."""
    stack = with_values(BARE, roughness=roughness)
    alpha = np.full(len(COSINES), roughness**2)
    lobe = GlossyLobe("ggx", np.ones(3), alpha, alpha, fresnel=ConductorCurve.of(stack.base))
    white = GlossyLobe("ggx", np.ones(3), alpha, alpha)
    wo = np.stack([np.sqrt(1.0 - COSINES**2), 0.0 * COSINES, COSINES], axis=-1)
    mirrored = wo * [-1.0, -1.0, 1.0]
    ratio = lobe_f(lobe, wo, mirrored) / lobe_f(white, wo, mirrored)
    np.testing.assert_allclose(ratio, ConductorBase.of(stack.base, 1.0).reflectance(COSINES), rtol=1e-9)
    wi, share = balanced_directions(wo, [("ggx", roughness**2)], 4000)
    columns = GlossyLobe("ggx", np.ones(3), alpha[:, None], alpha[:, None], fresnel=lobe.fresnel)
    energy = np.sum(share[..., None] * lobe_f(columns, wo[:, None], wi), axis=1)
    np.testing.assert_allclose(unit_energy(lobe, COSINES), energy, rtol=5e-3)


@pytest.mark.parametrize(
    "live, albedo, shape",
    [((ROUGHNESS,), 0.002, 1.1), ((ROUGHNESS, REFLECTANCE), 0.003, 1.0), ((REFLECTANCE, EDGE), 0.003, 1.2), ((ROUGHNESS, REFLECTANCE, EDGE), 0.006, 1.6)],
)
def test_every_metal_of_a_texture_is_closer_than_its_own_fits(live, albedo, shape):
    """Nine draws: the worst albedo, the median of shapes over that of the fits of each alone, and no view as far off as what fits of textures were."""
    followed, rng, found = bake_metal(BARE, live, 2, lambda share: None), np.random.default_rng(17), []
    for _ in range(9):
        here = drawn(rng, BARE, live)
        estimator = ErrorEstimator(here, truth_of(here), COSINES)
        errors, own = (estimator.errors(lobes) for lobes in (followed.with_values_of(here), baked(here, (), 2, None)))
        found.append((np.max(errors.albedo), np.median(errors.shape), np.median(own.shape), np.max(errors.shape)))
    worst, mine, own, far = np.array(found).T
    print(
        f"{', '.join(map(str, live))}: albedo {100 * worst.max():.2f} %, shape {100 * np.median(mine):.2f} % for {100 * np.median(own):.2f} %, worst {100 * far.max():.1f} %"
    )
    assert np.max(worst) <= albedo and np.median(mine) <= shape * np.median(own) and np.max(far) <= 0.045


def test_those_that_do_not_know_the_curve_have_fits():
    """In Blender 4.5, in EEVEE and in other working spaces; elsewhere stock nodes have the curve and Lambert's lobe. The energies are the same."""
    live = (ROUGHNESS, REFLECTANCE)
    made = make_lobe_set(BARE, "auto", live=live)
    exact, fits = made.lobe_set, without_metals(made).lobe_set
    assert isinstance(exact, LiveLobes) and exact.knows_metal and not fits.knows_metal and fits.ramp is None
    assert without_metals(made).choice.chosen == made.choice.stock != made.choice.chosen and "EEVEE" in made.reason
    kept, plain = tabulate(made.lobe_set, keep_dielectrics=True), tabulate(made.lobe_set)
    assert any(isinstance(table.fresnel, ConductorCurve) for table in kept.tables) and all(table.fresnel is None for table in plain.tables)
    here = with_values(BARE, roughness=0.33, reflectance=(0.7, 0.4, 0.9))
    wanted = truth_of(here).albedo(np.stack([np.sqrt(1.0 - COSINES**2), 0.0 * COSINES, COSINES], axis=-1))
    for lobes, error in ((exact, 0.003), (kept, 0.004), (fits, 0.02), (plain, 0.02)):
        energy = sum(lobe_energy(lobe, COSINES) for lobe in lobes.with_values_of(here).lobes(COSINES))
        np.testing.assert_allclose(energy, wanted, rtol=error)


def test_a_bake_of_metals_is_kept_and_found_again():
    exact = bake_metal(BARE, (ROUGHNESS,), 2, lambda share: None)
    here = with_values(BARE, roughness=0.62)
    again = unpack_grid(pack_grid(exact), here)
    for lobe, other in zip(exact.with_values_of(here).lobes(COSINES), again.lobes(COSINES), strict=True):
        np.testing.assert_allclose(lobe_energy(lobe, COSINES), lobe_energy(other, COSINES), rtol=1e-12)


def test_which_metals_are_bare():
    coated, filmed = Stack.from_dict({"layers": [{"kind": "dielectric"}], "base": METAL}), METAL | {"film_thickness": 300.0, "film_ior": 1.9}
    brushed, smooth = METAL | {"anisotropy": 0.5, "rotation": 0.0}, with_values(BARE, roughness=0.0)
    assert is_bare_metal(BARE, (REFLECTANCE,)) and is_bare_metal(smooth, (ROUGHNESS,)) and not is_bare_metal(smooth, (REFLECTANCE,))
    assert not any(is_bare_metal(stack, (ROUGHNESS,)) for stack in (coated, *(Stack.from_dict({"base": base}) for base in (filmed, brushed))))


@pytest.mark.parametrize("roughness, reflectance", [(0.08, 0.15), (0.06, 0.3), (0.06, 0.6), (0.064, 0.23)])
def test_a_polished_metal_has_one_highlight(roughness, reflectance):
    """A fitted lobe that is narrow and inclined found nothing between the points of the truth that spoke against it: .82 of the light went eight degrees astray."""
    stack = with_values(BARE, roughness=roughness, reflectance=(reflectance,) * 3)
    cosines = np.cos(np.radians([0.0, 20.0, 40.0, 50.0, 60.0, 65.0, 70.0, 75.0, 80.0]))
    errors = ErrorEstimator(stack, truth_of(stack), cosines).errors(baked(stack, (), 2, None))
    print(f"roughness {roughness}, reflectance {reflectance}: {np.round(errors.shape, 4)}")
    assert np.max(errors.shape) <= 0.015
