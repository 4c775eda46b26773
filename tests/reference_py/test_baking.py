# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked tier against the truth it was fitted to, between the knots it was fitted at."""

import numpy as np
import pytest

from lamina.reference_py.lobes import cache
from lamina.reference_py.lobes.baked import Baker
from lamina.reference_py.lobes.baked.fit_lobes import non_negative
from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.lobe import DiffuseLobe
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding.adding_model import Adding
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.suite import suite_stack

# Between knots, and not where fits begin.
VIEWS_DEG = np.array([3.0, 25.0, 42.0, 61.0, 73.0, 80.0])
# Largest albedo error over presets and suite (`lamina chart tiers`) is .65 %.
ALBEDO_TOLERANCE = 0.007
STACKS = {
    "frosted_paint": presets.load("frosted_paint"),
    "patina_copper": presets.load("patina_copper"),
    "smooth_coat": suite_stack("plastic_grey_0"),
    "plastic": suite_stack("plastic_grey_0_4"),
}


def energy(lobe_set, cos_o):
    return sum(lobe_energy(lobe, cos_o) for lobe in lobe_set.lobes(cos_o))


@pytest.mark.parametrize("name", STACKS)
def test_albedo_is_the_truth(name):
    theta = np.radians(VIEWS_DEG)
    exact = Adding(STACKS[name]).albedo(spherical(theta, 0.0))
    gap = np.max(np.abs(energy(make_lobe_set(STACKS[name], "baked"), np.cos(theta)) - exact) / exact)
    print(f"{name}: albedo {100 * gap:.2f} %")
    assert gap <= ALBEDO_TOLERANCE


@pytest.mark.parametrize("glossy", [1, 2, 3])
def test_a_channel_that_no_lobe_is_fitted_for_keeps_its_energy(glossy):
    """Varnish over polished silver that leaves a twentieth of the blue light: half of it was lost."""
    lacquer = {"kind": "dielectric", "ior": 1.5, "roughness": 0.1, "tint": [1.0, 0.7, 0.2]}
    stack = Stack.from_dict({"layers": [lacquer], "base": {"kind": "conductor", "metal": "silver", "roughness": 0.0}})
    theta = np.radians(VIEWS_DEG)
    exact = Adding(stack).albedo(spherical(theta, 0.0))
    assert np.max(np.abs(energy(make_lobe_set(stack, "baked", glossy=glossy), np.cos(theta)) - exact) / exact) <= 0.02


def test_coated_grey_is_right_where_stock_coats_are_two_thirds_too_bright():
    """The headline: n = 1.5 smooth over Lambert .5, seen along the normal, reflects .316."""
    baked = make_lobe_set(suite_stack("plastic_grey_0"), "baked")
    assert energy(baked, np.ones(1))[0, 1] == pytest.approx(0.316, abs=0.003)


@pytest.mark.parametrize("count", [1, 3, 8])
@pytest.mark.parametrize("alpha", [0.0, 0.3, 1.0])
def test_white_stacks_are_white(count, alpha):
    layers = [{"kind": "dielectric", "ior": (1.5, 1.3)[i % 2], "roughness": alpha**0.5} for i in range(count)]
    white = Stack.from_dict({"layers": layers, "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]}})
    cos_o = np.cos(np.radians([0.0, 30.0, 60.0, 75.0, 85.0]))
    assert energy(make_lobe_set(white, "baked", glossy=1), cos_o) == pytest.approx(1.0, abs=0.005)


def test_more_lobes_come_closer():
    baker = Baker(STACKS["frosted_paint"], Adding(STACKS["frosted_paint"]))
    few, more = (baker.bake(k).shape_error.mean() for k in (1, 2))
    assert more < few


@pytest.mark.parametrize("glossy", [2, 3])
def test_tables_have_no_jumps(glossy):
    """Alike lobes could change places from one knot to the next; between these a table would then mix them (13 % at 75 degrees)."""
    gold = Stack.from_dict({"layers": [], "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3**0.5}})
    truth = truth_of(gold)
    bake = Baker(gold, truth).bake(glossy)
    between = ErrorEstimator(gold, truth, np.linspace(0.1, 0.99, 25)).errors(bake.lobe_set)
    print(f"at knots {np.max(bake.shape_error):.4f}, between {np.max(between.shape):.4f}, albedo {np.max(between.albedo):.4f}")
    assert np.max(between.shape) < 1.5 * np.max(bake.shape_error[4:]) + 0.01 and np.max(between.albedo) < 0.01


def test_weights_are_never_negative_and_alphas_stay_in_range():
    for name, stack in STACKS.items():
        for lobe in make_lobe_set(stack, "baked").lobes(np.linspace(0.0, 1.0, 101)):
            assert np.all(lobe.weight >= 0.0), name
            assert isinstance(lobe, DiffuseLobe) or np.all((lobe.alpha_x >= 0.0) & (lobe.alpha_x <= 1.0)), name


def test_progress_is_reported_and_can_cancel():
    shares = []

    def cancel(share):
        shares.append(share)
        if len(shares) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_lobe_set(suite_stack("plastic_grey_0_2"), "baked", glossy=1, progress=cancel)
    assert shares == sorted(shares)


@pytest.mark.parametrize("lobes", [2, 3, 4])
def test_non_negative_least_squares_beats_every_other_choice(lobes):
    rng = np.random.default_rng(3)
    columns, goal = rng.normal(size=(lobes, 30)), rng.normal(size=(30, 20))
    gram = np.repeat((columns @ columns.T)[None], 20, axis=0)
    best = non_negative(gram, (columns @ goal).T)
    lowest = np.sum(np.square(goal - columns.T @ best.T), axis=0)
    for _ in range(500):
        other = np.maximum(best + rng.normal(scale=0.05, size=best.shape), 0.0)
        assert np.all(np.sum(np.square(goal - columns.T @ other.T), axis=0) >= lowest - 1e-12)


def test_mirror_evaluates_the_bake():
    stack = STACKS["smooth_coat"]
    wo = spherical(np.radians([20.0, 70.0]), 0.0)
    expected = energy(make_lobe_set(stack, "baked"), wo[:, 2])
    assert make_model("closure_model", stack, method="baked").albedo(wo) == pytest.approx(expected, rel=2e-3)


def test_a_cache_that_cannot_be_written_is_told_of_once(tmp_path):
    (tmp_path / "file").write_text("")
    told = []
    cache.keep_in(tmp_path / "file" / "bakes", told.append)
    try:
        for number in range(2):
            cache.cached(f"key {number}", lambda: 1.0, lambda value: {"value": value}, lambda data: data["value"])
        assert len(told) == 1 and str(tmp_path / "file") in told[0]
    finally:
        cache.keep_in(None)
