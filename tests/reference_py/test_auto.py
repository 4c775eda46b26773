# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of the default method: which of candidates of given errors and costs is taken, and why."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from support.stacks import coat, lambert, stack

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.baked import Baker
from lamina.reference_py.lobes.error_estimate import SOFT_LIGHT_DEG, ErrorEstimator, Errors, ball_cosines
from lamina.reference_py.lobes.made import Options
from lamina.reference_py.lobes.methods import auto
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.material.place import Place
from lamina.study.suite import suite_stack

COATED = stack(coat(0.1), base=lambert(0.5))
SMOOTH = stack(coat(0.0), base=lambert(0.5))
WORST, CLOSE = 0.5, 0.001


@dataclass(frozen=True)
class Bake:
    name: str
    lobe_count: int
    stock: "Bake | None" = None

    @property
    def has_ramps(self) -> bool:
        return self.name.startswith("ramp")


@pytest.fixture
def offered(monkeypatch):
    """`choose` among candidates, given as label: (cost, worst albedo's error, soft light's), of which "baked, k glossy" are bakes and "ramp, k glossy" those for OSL alone.

    Every shape is far off: it does not count. Calls of `cost` tell whether values are live.
    """

    def offer(candidates, live=(), least=None, shapes=None, **options):
        told = []

        class Estimator:
            def __init__(self, *arguments):
                pass

            def errors(self, lobe_set):
                _, albedo, soft = candidates[lobe_set.name]
                # the albedo is the worst view's, the soft light's a mean over views
                return Errors(np.array([0.0, albedo]), np.array([0.5 * soft, 1.5 * soft]), np.full(2, (shapes or {}).get(lobe_set.name, 0.9)))

        baker = SimpleNamespace(
            most_glossy=4,
            path=lambda k, known: k,
            lobe_set=lambda k: Bake(f"baked, {k} glossy", k + 1),
            least_soft_light=lambda k, *views: (least or {}).get(k, 0.0),
        )

        def cost_of(lobe_set, live):
            told.append(live)
            return candidates[lobe_set.name][0]

        monkeypatch.setattr(auto, "ErrorEstimator", Estimator)
        ramps = SimpleNamespace(
            counts=lambda most: [k for k in range(1, most + 1) if f"ramp, {k} glossy" in candidates],
            lobe_set=lambda k: Bake(f"ramp, {k} glossy", k + 1),
        )
        monkeypatch.setattr(auto, "Baker", lambda *arguments: baker)
        monkeypatch.setattr(auto, "RampBaker", lambda baker: ramps)
        monkeypatch.setattr(auto, "baked", lambda stack, live, glossy, report: SimpleNamespace(name="over", lobe_count=2, live=live))
        monkeypatch.setattr(auto, "cost", cost_of)
        result = auto.choose(COATED, None, Options(live=live, **options), cosines=np.ones(2))
        assert set(told) == {bool(live)}
        return result

    return offer


MANY = (Place(0, "roughness"), Place(0, "thickness"), Place(0, "ior"), Place(None, "roughness"))
DEAR_AND_EXACT = {"weidlich_wilkie": (1.2, WORST, WORST), "analytic": (3.0, CLOSE, CLOSE)}


@pytest.mark.parametrize("bakes, taken, tried", [
    # the exact method costs more than a bake that is good enough
    ([(1.1, 0.019, 0.019)], "baked, 1 glossy", 3),
    # what is cheap and wrong is not taken, and more lobes are tried until they do
    ([(1.1, 0.3, 0.01), (1.3, 0.04, 0.01), (1.5, 0.01, 0.01), (1.7, 0.0, 0.0)], "baked, 3 glossy", 5),
    # soft light counts as much as the albedo
    ([(1.1, CLOSE, 0.03), (1.3, CLOSE, 0.01)], "baked, 2 glossy", 4),
    # at the tolerance is within it
    ([(1.1, 0.02, 0.0)], "baked, 1 glossy", 3),
    # bakes that never are good enough leave the method that is
    ([(1.1, 0.1, 0.1), (1.3, 0.08, 0.1), (1.5, 0.06, 0.1), (1.7, 0.05, 0.1)], "analytic", 6),
    # a bake that is good enough may be the dearer one
    ([(3.2, CLOSE, CLOSE)], "analytic", 3),
])  # fmt: skip
def test_the_cheapest_within_the_tolerance_is_taken(offered, bakes, taken, tried):
    told = offered({**DEAR_AND_EXACT, **{f"baked, {k} glossy": figures for k, figures in enumerate(bakes, 1)}}, tolerance=0.02)
    assert told.chosen.label == told.lobe_set.name == taken
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


def test_a_ramp_is_for_osl_and_stock_nodes_have_what_they_had(offered):
    bakes = {"baked, 1 glossy": (1.1, 0.3, 0.0), "baked, 2 glossy": (1.3, 0.01, 0.0)}
    told = offered({**DEAR_AND_EXACT, **bakes, "ramp, 1 glossy": (1.1, 0.05, 0.0), "ramp, 2 glossy": (1.3, 0.001, 0.0)}, tolerance=0.02)
    assert told.chosen.label == told.lobe_set.name == "ramp, 2 glossy" and told.shown(osl=True) is told.chosen
    assert told.stock.label == told.lobe_set.stock.name == "baked, 2 glossy" and told.shown(osl=False) is told.stock
    assert told.reason == "the cheapest whose error is at most 2 %; stock nodes have baked, 2 glossy, error 1 %"


def test_a_cheaper_ramp_that_is_further_off_in_shape_is_not_taken(offered):
    bakes = {"baked, 1 glossy": (1.1, 0.3, 0.0), "baked, 2 glossy": (1.3, 0.01, 0.0), "ramp, 1 glossy": (1.1, 0.015, 0.0), "ramp, 2 glossy": (1.3, 0.001, 0.0)}
    assert offered({**DEAR_AND_EXACT, **bakes}, tolerance=0.02).chosen.label == "ramp, 1 glossy"
    assert offered({**DEAR_AND_EXACT, **bakes}, tolerance=0.02, shapes={"ramp, 1 glossy": 0.95}).chosen.label == "ramp, 2 glossy"


def test_where_a_ramp_is_no_closer_both_have_the_same(offered):
    bakes = {"baked, 1 glossy": (1.1, 0.3, 0.0), "baked, 2 glossy": (1.3, 0.01, 0.0)}
    told = offered({**DEAR_AND_EXACT, **bakes, "ramp, 1 glossy": (1.1, 0.05, 0.0), "ramp, 2 glossy": (1.3, 0.05, 0.0)}, tolerance=0.02)
    assert told.chosen is told.stock and told.lobe_set.name == "baked, 2 glossy" and told.lobe_set.stock is None


def test_what_stock_nodes_make_of_a_smooth_coat_is_judged_apart():
    """With OSL its Lambert lobe has a ramp, in stock nodes it has none."""
    told = auto.choose(SMOOTH, truth_of(SMOOTH), Options(tolerance=0.001))
    assert told.chosen.label == told.stock.label and told.lobe_set.stock is None
    assert told.chosen.visible <= 0.006 and told.stock.visible >= 0.02 and f"stock nodes have {told.stock.label}, error" in told.reason


def test_what_people_read_of_a_candidate_is_the_worse_of_both_errors():
    candidate = auto.Candidate("analytic", 3, 1.26, albedo=0.004, soft_light=0.031, shape=0.5)
    assert candidate.visible == 0.031
    assert str(candidate) == "analytic, error 3.1 %, cost 1.3x"
    assert auto.Candidate("analytic", 3, 1.26, albedo=0.04, soft_light=0.031, shape=0.5).visible == 0.04


def test_errors_are_the_worst_albedo_and_the_mean_soft_light(offered):
    # no bake follows so many values, so that none is tried
    told = offered({"weidlich_wilkie": (1.2, 0.3, 0.2), "analytic": (3.0, 0.01, 0.012)}, live=MANY)
    worse, better = told.tried
    assert (worse.albedo, worse.soft_light) == (0.3, pytest.approx(0.2)) and (better.albedo, better.soft_light) == (0.01, pytest.approx(0.012))
    assert (better.closures, worse.cost, better.shape) == (2, 1.2, 0.9)


def test_live_values_are_baked_over_where_a_bake_can_follow_them(offered):
    told = offered({**DEAR_AND_EXACT, "over": (1.2, 0.01, 0.01)}, live=(Place(0, "thickness"),))
    assert told.chosen.label == "baked over the thickness of layer 0"
    assert told.lobe_set.live == (Place(0, "thickness"),)
    told = offered(DEAR_AND_EXACT, live=MANY)
    assert told.chosen.label == "analytic" and len(told.tried) == 2
    words = "the roughness of layer 0, the thickness of layer 0, the ior of layer 0, the roughness of the base"
    assert told.reason == f"the cheapest whose error is at most 2 %; a bake cannot follow {words}"


def test_what_is_hopeless_is_not_made_good(offered):
    """Far from the tolerance at a few knots a bake is left out; the last one never is, as something has to be the closest."""
    bakes = {f"baked, {k} glossy": (1.0 + 0.1 * k, 0.5 / k**3, 0.5 / k**3) for k in (1, 2, 3)}
    for glossy, looked_at in ((3, [2, 3]), (1, [1])):
        told = offered({**DEAR_AND_EXACT, **bakes}, least={1: 0.4, 2: 0.01, 3: 0.009}, glossy=glossy)
        assert [candidate.label for candidate in told.tried[2:]] == [f"baked, {k} glossy" for k in looked_at]


@pytest.mark.parametrize("least_of_3, looked_at", [(0.0097, [2]), (0.0095, [2, 3])])
def test_a_lobe_that_gains_nothing_at_a_few_knots_is_not_made_good(offered, least_of_3, looked_at):
    bakes = {f"baked, {k} glossy": (1.0 + 0.1 * k, 0.05, 0.05) for k in (1, 2, 3)}
    told = offered({**DEAR_AND_EXACT, **bakes}, least={1: 0.4, 2: 0.01, 3: least_of_3}, glossy=3)
    assert [candidate.label for candidate in told.tried[2:]] == [f"baked, {k} glossy" for k in looked_at]


@pytest.mark.parametrize("least_of_2, looked_at", [(0.05, [4, 3, 2]), (0.1, [4, 3])], ids=["perhaps", "surely not"])
def test_where_no_bake_is_good_the_hopeless_are_looked_at_while_they_may_be_as_close(offered, least_of_2, looked_at):
    errors, least = {1: 0.3, 2: 0.25, 3: 0.1, 4: 0.102}, {1: 0.05, 2: least_of_2, 3: 0.05, 4: 0.05}
    bakes = {f"baked, {k} glossy": (1.0 + 0.1 * k, error, error) for k, error in errors.items()}
    told = offered({"weidlich_wilkie": (1.2, WORST, WORST), "analytic": (3.0, WORST, WORST), **bakes}, least=least)
    assert [candidate.label for candidate in told.tried[2:]] == [f"baked, {k} glossy" for k in looked_at]
    assert told.chosen.label == "baked, 3 glossy"


@pytest.mark.parametrize("name", ["plastic_grey_0_1", "gold_coat_0_1_metal_0_1", "narrow_over_narrow"])
def test_soft_light_is_never_less_off_than_a_few_knots_say(name):
    tested, views = suite_stack(name), ball_cosines()
    truth = truth_of(tested)
    baker, estimator = Baker(tested, truth), ErrorEstimator(tested, truth, views)
    for count in (1, 2, 3):
        least = baker.least_soft_light(count, views, SOFT_LIGHT_DEG)
        assert 1.1 * least < np.mean(estimator.errors(baker.bake(count).lobe_set).soft_light) < 20.0 * least


def test_progress_grows_to_the_end(offered):
    shares = []
    offered({**DEAR_AND_EXACT, "baked, 1 glossy": (1.1, 0.1, 0.1), "baked, 2 glossy": (1.1, 0.01, 0.01)}, progress=shares.append, glossy=2)
    assert len(shares) == 5 and shares == sorted(shares) and shares[-1] == 1.0


@pytest.mark.parametrize("tolerance", [0.0, -0.01, 1.01, float("nan")])
def test_a_tolerance_that_means_nothing_is_refused(tolerance):
    with pytest.raises(LaminaError, match=r"tolerance .* percent: choose more than 0 and at most 100"):
        auto.choose(COATED, None, Options(tolerance=tolerance))
