# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of the default tier: which of candidates of given errors and costs is taken, and why; and what a network costs."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

import lamina
from lamina.reference_py import presets
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.network import AnalyticNetwork, WeidlichWilkieNetwork, choice
from lamina.reference_py.network.judge import Errors
from lamina.reference_py.network.table import KNOTS, DiffuseTable, GlossyTable, TableNetwork

COATED = stack(coat(0.1), base=lambert(0.5))
FIGURES = Path(lamina.__file__).parent / "figures"
WORST, CLOSE = 0.5, 0.001


@pytest.fixture
def offered(monkeypatch):
    """`choose` among candidates, given as label: (cost, worst albedo's error, soft light's), of which "baked, k glossy" are bakes.

    Every shape is far off: it does not count. Calls of `cost` tell whether values are live.
    """

    def offer(candidates, live=(), **options):
        told = []

        class Judge:
            def __init__(self, *arguments):
                pass

            def errors(self, network):
                _, albedo, soft = candidates[network.tier]
                # the albedo is the worst view's, the soft light's a mean over views
                return Errors(np.array([0.0, albedo]), np.array([0.5 * soft, 1.5 * soft]), np.array([0.9, 0.9]))

        def bake(k):
            return SimpleNamespace(network=SimpleNamespace(tier=f"baked, {k} glossy", lobe_count=k + 1))

        def cost(network, live):
            told.append(live)
            return candidates[network.tier][0]

        monkeypatch.setattr(choice, "Judge", Judge)
        monkeypatch.setattr(choice, "Baker", lambda *arguments: SimpleNamespace(bake=bake))
        monkeypatch.setattr(choice, "baked", lambda stack, axes, glossy, report: SimpleNamespace(tier="over", lobe_count=2, axes=axes))
        monkeypatch.setattr(choice, "cost", cost)
        result = choice.choose(COATED, None, live, cosines=np.ones(2), **options)
        assert set(told) == {bool(live)}
        return result

    return offer


DEAR_AND_EXACT = {"weidlich_wilkie": (1.2, WORST, WORST), "analytic": (3.0, CLOSE, CLOSE)}


@pytest.mark.parametrize("bakes, taken, tried", [
    # the exact tier costs more than a bake that is good enough
    ([(1.1, 0.019, 0.019)], "baked, 1 glossy", 3),
    # what is cheap and wrong is not taken, and more lobes are tried until they do
    ([(1.1, 0.3, 0.01), (1.3, 0.04, 0.01), (1.5, 0.01, 0.01), (1.7, 0.0, 0.0)], "baked, 3 glossy", 5),
    # soft light counts as much as the albedo
    ([(1.1, CLOSE, 0.03), (1.3, CLOSE, 0.01)], "baked, 2 glossy", 4),
    # at the tolerance is within it
    ([(1.1, 0.02, 0.0)], "baked, 1 glossy", 3),
    # bakes that never are good enough leave the tier that is
    ([(1.1, 0.1, 0.1), (1.3, 0.08, 0.1), (1.5, 0.06, 0.1), (1.7, 0.05, 0.1)], "analytic", 6),
    # a bake that is good enough may be the dearer one
    ([(3.2, CLOSE, CLOSE)], "analytic", 3),
])  # fmt: skip
def test_the_cheapest_within_the_tolerance_is_taken(offered, bakes, taken, tried):
    told = offered({**DEAR_AND_EXACT, **{f"baked, {k} glossy": figures for k, figures in enumerate(bakes, 1)}}, tolerance=0.02)
    assert told.chosen.label == told.network.tier == taken
    assert [c.label for c in told.tried] == ["weidlich_wilkie", "analytic", *(f"baked, {k} glossy" for k in range(1, tried - 1))]
    assert told.chosen in told.tried and told.reason == "the cheapest whose error is at most 2 %"


@pytest.mark.parametrize("figures, taken", [
    # 4 % more error for a third of the cost: as close
    ([(1.2, WORST, 0.0), (3.0, 0.1, 0.0), (1.1, 0.104, 0.0), (1.3, 0.2, 0.0)], "baked, 1 glossy"),
    # 6 % more error is not
    ([(1.2, WORST, 0.0), (3.0, 0.1, 0.0), (1.1, 0.106, 0.0), (1.3, 0.2, 0.0)], "analytic"),
    # and neither is what only the soft light tells apart
    ([(1.2, 0.1, WORST), (3.0, 0.1, 0.1), (1.1, 0.1, 0.3), (1.3, 0.1, 0.2)], "analytic"),
    ([(1.2, 0.1, 0.0), (3.0, 0.1, 0.0), (1.4, 0.1, 0.0), (1.6, 0.1, 0.0)], "weidlich_wilkie"),
])  # fmt: skip
def test_where_none_is_good_enough_the_cheapest_of_the_closest_is_taken(offered, figures, taken):
    labels = ("weidlich_wilkie", "analytic", "baked, 1 glossy", "baked, 2 glossy")
    told = offered(dict(zip(labels, figures)), tolerance=0.02, glossy=2)
    assert told.chosen.label == taken
    assert told.reason == "the cheapest of those about as close as the closest; none of 4 reaches 2 %"


def test_what_people_read_of_a_candidate_is_the_worse_of_both_errors():
    candidate = choice.Candidate("analytic", 3, 1.26, albedo=0.004, soft_light=0.031, shape=0.5)
    assert candidate.seen == 0.031
    assert str(candidate) == "analytic, error 3.1 %, cost 1.3x"
    assert choice.Candidate("analytic", 3, 1.26, albedo=0.04, soft_light=0.031, shape=0.5).seen == 0.04


def test_errors_are_the_worst_albedo_and_the_mean_soft_light(offered):
    told = offered({"weidlich_wilkie": (1.2, 0.3, 0.2), "analytic": (3.0, 0.01, 0.012)}, glossy=0)
    worse, better = told.tried
    assert (worse.albedo, worse.soft_light) == (0.3, pytest.approx(0.2)) and (better.albedo, better.soft_light) == (0.01, pytest.approx(0.012))
    assert (better.closures, worse.cost, better.shape) == (2, 1.2, 0.9)


def test_live_values_are_baked_over_where_a_bake_can_follow_them(offered):
    told = offered({**DEAR_AND_EXACT, "over": (1.2, 0.01, 0.01)}, live=((0, "thickness"),))
    assert told.chosen.label == "baked over the thickness of layer 0"
    assert [(axis.index, axis.parameter) for axis in told.network.axes] == [(0, "thickness")]
    told = offered(DEAR_AND_EXACT, live=((0, "tint"),))
    assert told.chosen.label == "analytic" and len(told.tried) == 2
    assert told.reason == "the cheapest whose error is at most 2 %; a bake cannot follow the tint of layer 0"


def test_progress_grows_to_the_end(offered):
    shares = []
    offered({**DEAR_AND_EXACT, "baked, 1 glossy": (1.1, 0.1, 0.1), "baked, 2 glossy": (1.1, 0.01, 0.01)}, progress=shares.append, glossy=2)
    assert len(shares) == 5 and shares == sorted(shares) and shares[-1] == 1.0


@pytest.mark.parametrize("tolerance", [0.0, -0.01, 1.01, float("nan")])
def test_a_tolerance_that_means_nothing_is_refused(tolerance):
    with pytest.raises(LaminaError, match=r"tolerance .* percent: choose more than 0 and at most 100"):
        choice.choose(COATED, None, tolerance=tolerance)


def tables(diffuse=0, mirrors=0, glossy=0):
    """A network of so many lobes."""
    ones = np.ones((KNOTS, 3))
    lobes = [GlossyTable("ggx", ones, 0.3 * ones)] * glossy + [GlossyTable("ggx", ones, 0.0 * ones)] * mirrors
    return TableNetwork((*lobes, *[DiffuseTable(ones)] * diffuse))


def measured(file):
    """Rows of a table of times that were measured in Cycles."""
    return list(csv.DictReader(line for line in (FIGURES / file).read_text(encoding="utf-8").splitlines() if not line.startswith("#")))


LEVERS = {"ggx": tables(glossy=1), "diffuse": tables(diffuse=1), **{f"diffuse + {k} ggx": tables(diffuse=1, glossy=k) for k in (1, 2, 3)}}


@pytest.mark.parametrize("lever", LEVERS)
def test_costs_of_lobes_are_those_measured(lever):
    """To a tenth; the measurements' own spread is as much."""
    row = next(r for r in measured("levers.csv") if (r["scene"], r["lever"]) == ("frame-filling ball", lever))
    print(lever, choice.cost(LEVERS[lever]), row["cost"])
    assert choice.cost(LEVERS[lever]) == pytest.approx(float(row["cost"]), rel=0.1)


@pytest.mark.parametrize("name", ["glazed_mug", "frosted_paint", "metallic_car_paint", "frosted_metal"])
def test_costs_of_coated_stacks_are_those_measured(name):
    """To the quarter that `cost` promises: layers over diffuse bases and over metals, by their two live tiers."""
    rows = {r["method"]: float(r["cost"]) for r in measured("pareto.csv") if r["surface"] == name}
    for network in (WeidlichWilkieNetwork, AnalyticNetwork):
        estimate = choice.cost(network(presets.load(name)))
        print(name, network.tier, estimate, rows[network.tier])
        assert estimate == pytest.approx(rows[network.tier], rel=0.25)


def test_everything_that_a_shader_has_costs():
    base = choice.cost(tables(diffuse=1))
    diffuse, mirror, glossy = (choice.cost(tables(**{"diffuse": 1, kind: 1 + (kind == "diffuse")})) - base for kind in ("diffuse", "mirrors", "glossy"))
    assert 0.0 < diffuse < mirror < glossy
    metal = conductor(0.2, 3.9, 0.3)
    for base in (lambert(0.5), metal):
        one, two, many = (AnalyticNetwork(stack(*[coat(0.2)] * count, base=base)) for count in (1, 2, 4))
        assert choice.cost(one) < choice.cost(one, live=True)  # OSL folds what is constant
        assert choice.cost(one) < choice.cost(two) < choice.cost(many) == choice.cost(many, live=True)
    assert choice.cost(AnalyticNetwork(stack(coat(0.2), base=lambert(0.5)))) < choice.cost(AnalyticNetwork(stack(coat(0.2), base=metal)))
