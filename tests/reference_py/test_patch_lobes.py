# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of patches: their shares, lobes that are one, what is told of error and cost, and their keys."""

from dataclasses import replace

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.lobes.analytic import AnalyticLobes
from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.lobe import DielectricCurve, DiffuseLobe, GlossyLobe, SchlickCurve
from lamina.reference_py.lobes.methods import MAX_CLOSURES, auto, glossy_of_each, key_of, make_lobe_set
from lamina.reference_py.lobes.methods.cost import cost
from lamina.reference_py.lobes.methods.paper import PaperLobes
from lamina.reference_py.lobes.methods.summary import estimated_cost, estimated_error
from lamina.reference_py.lobes.patch_lobes import merged
from lamina.reference_py.material.coverage import patches
from lamina.reference_py.material.place import Place

VIEWS = np.cos(np.radians([10.0, 70.0]))
GOLD = conductor(0.2, 3.9, 0.2)
GLOSSY = GlossyLobe("ggx", np.full(3, 0.2), 0.3, 0.3)


@pytest.mark.parametrize("lobe", [
    GLOSSY,
    replace(GLOSSY, fresnel=DielectricCurve(1.5)),
    replace(GLOSSY, alpha_x=np.array([0.2, 0.3]), frame=0.4),
    DiffuseLobe(np.full(3, 0.2)),
    DiffuseLobe(np.full(3, 0.2), (0.3, 0.2, 0.1), 20.0),
], ids=["glossy", "dielectric", "brushed", "lambert", "oren-nayar"])  # fmt: skip
def test_lobes_that_differ_in_weight_alone_are_one(lobe):
    other = GlossyLobe("beckmann", np.ones(3), 0.9, 0.9)
    first, second = merged([lobe, other, replace(lobe, weight=np.array([0.1, 0.3, 0.5]))])
    assert first.weight == pytest.approx([0.3, 0.5, 0.7]) and second is other
    assert {**vars(first), "weight": None} == {**vars(lobe), "weight": None}


@pytest.mark.parametrize("lobe, change", [
    (GLOSSY, {"distribution": "beckmann"}),
    (GLOSSY, {"alpha_x": 0.31}),
    (GLOSSY, {"alpha_y": 0.31}),
    (GLOSSY, {"tilt": 0.1}),
    (GLOSSY, {"frame": 0.0}),
    (GLOSSY, {"fresnel": DielectricCurve(1.5)}),
    (replace(GLOSSY, fresnel=DielectricCurve(1.5)), {"fresnel": DielectricCurve(1.6)}),
    (DiffuseLobe(np.ones(3), (0.3, 0.2, 0.1), 20.0), {"color": (0.3, 0.2, 0.2)}),
    (DiffuseLobe(np.ones(3), (0.3, 0.2, 0.1), 20.0), {"sigma_deg": 21.0}),
    (DiffuseLobe(np.ones(3), (0.3, 0.2, 0.1), 20.0), {"power": 1}),
    (DiffuseLobe(np.ones(3)), {"color": (1.0, 1.0, 1.0)}),
])  # fmt: skip
def test_lobes_that_differ_in_anything_else_stay_two(lobe, change):
    assert len(merged([lobe, replace(lobe, **change)])) == 2


def test_curves_over_the_view_stay_two():
    """Two Schlick curves are arrays over the view: nothing tells that they are equal for every one."""
    lobe = replace(GLOSSY, fresnel=SchlickCurve(np.full(3, 0.04), np.ones(3)))
    assert len(merged([lobe, lobe])) == 2


def test_a_coat_on_a_quarter_of_a_grey_surface():
    """One glossy lobe of weight 1/4, and one Lambert lobe of what both patches send."""
    covered = stack(coat(0.3, coverage=0.25), base=lambert(0.5))
    lobe_set = make_lobe_set(covered, "weidlich_wilkie")
    glossy, diffuse = lobe_set.lobes(VIEWS)
    below_coat = PaperLobes(stack(coat(0.3), base=lambert(0.5))).lobes(VIEWS)[1].weight
    assert glossy.weight == pytest.approx(0.25 * np.ones((2, 3))) and glossy.fresnel == DielectricCurve(1.5)
    assert diffuse.weight == pytest.approx(0.25 * below_coat + 0.75 * 0.5)
    assert lobe_set.lobe_count == 2


@pytest.mark.parametrize("shares", [(0.25, 0.5), (0.0, 0.5), (1.0, 0.3)])
@pytest.mark.parametrize("method", ["weidlich_wilkie", "analytic"])
def test_energy_is_the_patches_mean(shares, method):
    """Two covered layers over gold: the four patches' energies, with shares written out."""
    a, b = coat(0.3, tint=[0.9, 0.5, 0.2]), coat(0.1, ior=1.8)
    first, second = shares
    lobe_set = make_lobe_set(stack({**a, "coverage": first}, {**b, "coverage": second}, base=GOLD), method)
    bare = [(first * second, (a, b)), (first * (1.0 - second), (a,)), ((1.0 - first) * second, (b,)), ((1.0 - first) * (1.0 - second), ())]
    expected = sum(share * energy(make_lobe_set(stack(*layers, base=GOLD), method)) for share, layers in bare)
    assert energy(lobe_set) == pytest.approx(expected, rel=1e-9)
    # what is not there has no closure
    assert lobe_set.lobe_count <= sum(make_lobe_set(stack(*layers, base=GOLD), method).lobe_count for share, layers in bare if share > 0.0)


def energy(lobe_set):
    return sum(lobe_energy(lobe, VIEWS) for lobe in lobe_set.lobes(VIEWS))


@pytest.fixture
def chosen(monkeypatch):
    """Lets the method auto choose, for the patches in turn, lobes of these estimated figures (albedo, soft light, cost, reason)."""

    def choose_these(*figures):
        left = list(figures)

        def result(computed, stack, options):
            albedo, soft_light, cost, reason = left.pop(0)
            candidate = auto.Candidate("analytic", 2, cost, albedo, soft_light, 0.9)
            return auto.Choice(candidate, AnalyticLobes(stack), (candidate,), reason, candidate)

        monkeypatch.setattr(type(auto.COMPUTED), "result", result)

    return choose_these


HALF = stack(coat(0.3, coverage=0.5), base=lambert(0.5))


def test_error_is_the_worst_patchs_and_cost_the_dearests(chosen):
    chosen((0.01, 0.03, 1.2, "because"), (0.02, 0.0, 1.7, "so"))
    made = make_lobe_set(HALF, "auto")
    assert (estimated_error(made, osl=True), estimated_cost(made, osl=True)) == (0.03, 1.7)
    assert made.reason == "analytic, error 3 %, cost 1.2x: because; analytic, error 2 %, cost 1.7x: so"


def test_a_reason_that_all_patches_have_is_told_once(chosen):
    chosen(*[(0.01, 0.0, 1.0, "because")] * 2)
    assert make_lobe_set(HALF, "auto").reason == "analytic, error 1 %, cost 1x: because"


def test_nothing_is_told_of_errors_that_were_not_estimated(chosen):
    live = make_lobe_set(HALF, "analytic")
    assert estimated_error(live, osl=True) is None
    # the cost of what has no choice is that of its lobes
    assert estimated_cost(live, osl=True) == max(cost(AnalyticLobes(patch.stack)) for patch in patches(HALF))


@pytest.mark.parametrize("count, glossy", [(1, 7), (2, 3), (4, 1)])
def test_lobes_are_shared_out_among_patches(count, glossy):
    """With the one Lambert lobe that they share: 7, 6 and 4 of 8."""
    assert glossy_of_each(count) == glossy
    assert count * glossy + 1 <= MAX_CLOSURES < count * (glossy + 1) + 1


def test_keys_are_those_of_the_patches_with_their_own_layers_numbers():
    whole = stack(coat(0.3, coverage=0.5), coat(0.1, ior=1.8), base=GOLD)
    live = (Place(1, "roughness"), Place(0, "coverage"))
    both, one = stack(coat(0.3), coat(0.1, ior=1.8), base=GOLD), stack(coat(0.1, ior=1.8), base=GOLD)
    key = key_of(whole, "auto", live=live)
    own = [(both, Place(1, "roughness")), (one, Place(0, "roughness"))]
    assert key.split("\n") == [key_of(patch, "auto", live=(place,), glossy=3) for patch, place in own]
    # a share is mixed in at shading time: no other one asks for another bake
    assert key == key_of(stack(coat(0.3, coverage=0.9), coat(0.1, ior=1.8), base=GOLD), "auto", live=live)
    assert key != key_of(stack(coat(0.3, coverage=0.5), coat(0.1, ior=1.7), base=GOLD), "auto", live=live)
