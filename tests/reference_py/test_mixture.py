# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks of patches: shares of their lobes, lobes that are one, what is told of error and cost, and their keys."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.coverage import patches
from lamina.reference_py.network import TIERS, AutoNetwork, WeidlichWilkieNetwork, choice, make_network
from lamina.reference_py.network.closure import lobe_energy
from lamina.reference_py.network.lobe import DielectricCurve, DiffuseLobe, GlossyLobe, SchlickCurve
from lamina.reference_py.network.mixture import MAX_CLOSURES, PatchNetwork, estimated_cost, estimated_error, glossy_of_each, merged

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
    network = make_network(covered, "weidlich_wilkie")
    glossy, diffuse = network.lobes(VIEWS)
    below_coat = WeidlichWilkieNetwork(stack(coat(0.3), base=lambert(0.5))).lobes(VIEWS)[1].weight
    assert glossy.weight == pytest.approx(0.25 * np.ones((2, 3))) and glossy.fresnel == DielectricCurve(1.5)
    assert diffuse.weight == pytest.approx(0.25 * below_coat + 0.75 * 0.5)
    assert network.lobe_count == 2


@pytest.mark.parametrize("shares", [(0.25, 0.5), (0.0, 0.5), (1.0, 0.3)])
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
def test_energy_is_the_patches_mean(shares, tier):
    """Two covered layers over gold: the four patches' energies, with shares written out."""
    a, b = coat(0.3, tint=[0.9, 0.5, 0.2]), coat(0.1, ior=1.8)
    first, second = shares
    network = make_network(stack({**a, "coverage": first}, {**b, "coverage": second}, base=GOLD), tier)
    bare = [(first * second, (a, b)), (first * (1.0 - second), (a,)), ((1.0 - first) * second, (b,)), ((1.0 - first) * (1.0 - second), ())]
    expected = sum(share * energy(make_network(stack(*layers, base=GOLD), tier)) for share, layers in bare)
    assert energy(network) == pytest.approx(expected, rel=1e-9)
    # what is not there has no closure
    assert network.lobe_count <= sum(make_network(stack(*layers, base=GOLD), tier).lobe_count for share, layers in bare if share > 0.0)


def energy(network):
    return sum(lobe_energy(lobe, VIEWS) for lobe in network.lobes(VIEWS))


def part(albedo, soft_light, cost, reason="because"):
    """What the tier auto chose for a patch."""
    network = object.__new__(AutoNetwork)
    network.choice = SimpleNamespace(chosen=choice.Candidate("analytic", 2, cost, albedo, soft_light, 0.9))
    network.reason = reason
    return network


def test_error_is_the_worst_patchs_and_cost_the_dearests():
    parts = patches(stack(coat(0.3, coverage=0.5), base=lambert(0.5)))
    network = PatchNetwork(stack(base=lambert(0.5)), list(zip(parts, [part(0.01, 0.03, 1.2), part(0.02, 0.0, 1.7, "so")])))
    assert (estimated_error(network), estimated_cost(network)) == (0.03, 1.7)
    assert network.reason == "because; so"
    assert PatchNetwork(network.stack, [(p, part(0, 0, 1)) for p in parts]).reason == "because"


def test_nothing_is_told_of_errors_that_were_not_estimated():
    grey = stack(coat(0.3, coverage=0.5), base=lambert(0.5))
    assert estimated_error(make_network(grey, "analytic")) is None
    filmed = stack(coat(0.3, film_thickness=300.0, film_ior=2.0), base=lambert(0.5))
    parts = patches(grey)
    assert estimated_error(PatchNetwork(filmed, [(p, part(0.01, 0.01, 1.0)) for p in parts])) is None


@pytest.mark.parametrize("count, glossy", [(1, 7), (2, 3), (4, 1)])
def test_lobes_are_shared_out_among_patches(count, glossy):
    """With the one Lambert lobe that they share: 7, 6 and 4 of 8."""
    assert glossy_of_each(count) == glossy
    assert count * glossy + 1 <= MAX_CLOSURES < count * (glossy + 1) + 1


def test_keys_are_those_of_the_patches_with_their_own_layers_numbers():
    whole = stack(coat(0.3, coverage=0.5), coat(0.1, ior=1.8), base=GOLD)
    live = ((1, "roughness"), (0, "coverage"))
    both, one = stack(coat(0.3), coat(0.1, ior=1.8), base=GOLD), stack(coat(0.1, ior=1.8), base=GOLD)
    key = TIERS["auto"].key(whole, live=live)
    assert key.split("\n") == [AutoNetwork.key(both, ((1, "roughness"),), glossy=3), AutoNetwork.key(one, ((0, "roughness"),), glossy=3)]
    # a share is mixed in at shading time: no other one asks for another bake
    assert key == TIERS["auto"].key(stack(coat(0.3, coverage=0.9), coat(0.1, ior=1.8), base=GOLD), live=live)
    assert key != TIERS["auto"].key(stack(coat(0.3, coverage=0.5), coat(0.1, ior=1.7), base=GOLD), live=live)
