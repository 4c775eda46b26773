# SPDX-License-Identifier: GPL-3.0-or-later
"""From samples of a stack to the stack: solver, selection, what is determined, and the models that we compare with."""

from dataclasses import replace

import numpy as np
import pytest
from support.measured import paint

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.fit import certainty as certainties
from lamina.reference_py.fit import fitting, layer_count
from lamina.reference_py.fit.baseline_fits import BASELINE_MODELS, fit_baseline
from lamina.reference_py.fit.certainty import certainty, independent_pairs, noise_and_misfit
from lamina.reference_py.fit.dense import evaluate_all
from lamina.reference_py.fit.fitting import Fit, Start, corrected, fit_structure, nearest, subsampled
from lamina.reference_py.fit.forward import QUICK
from lamina.reference_py.fit.layer_count import select
from lamina.reference_py.fit.metric import Metric, shape_error
from lamina.reference_py.fit.outcome import outcome
from lamina.reference_py.fit.parameters import Parameters, Structure
from lamina.reference_py.fit.profile_likelihood import COHERENT_ERROR
from lamina.reference_py.fit.readers.measurement import checked, spread_pairs
from lamina.reference_py.fit.readers.sampled import sample_model
from lamina.reference_py.fit.solve import Solution, least_squares
from lamina.reference_py.fit.stand_in import stand_in
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import half_vector
from lamina.reference_py.registry import make_model
from lamina.study.fit_recovery import SETTINGS, data_of, random_stack, random_structure, recovery

COATED = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "ior": 1.6, "roughness": 0.45, "tint": [0.9, 0.6, 0.5]}],
        "base": {"kind": "lambert", "color": [0.3, 0.5, 0.7]},
    }
)


def differences(residual):
    def jacobian(x, r):
        return np.stack([(residual(x + h) - residual(x - h)) / 2e-6 for h in 1e-6 * np.eye(len(x))], axis=1)

    return jacobian


T = np.linspace(0.0, 4.0, 60)
WAVE = 2.0 * np.exp(-0.7 * T) * np.cos(3.0 * T) + 0.02 * np.sin(17.0 * T)
PROBLEMS = {
    "rosenbrock": (lambda x: np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]), [-1.2, 1.0], [-2.0, -2.0], [2.0, 2.0]),
    "rosenbrock at a bound": (lambda x: np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]), [-1.2, 1.0], [-2.0, 1.5], [2.0, 2.0]),
    "a wave": (lambda x: x[0] * np.exp(-x[1] * T) * np.cos(x[2] * T) - WAVE, [1.0, 0.3, 2.6], [0.0] * 3, [5.0] * 3),
    "a wave at a bound": (lambda x: x[0] * np.exp(-x[1] * T) * np.cos(x[2] * T) - WAVE, [1.0, 0.2, 2.6], [0.0] * 3, [5.0, 0.4, 5.0]),
    "one value says nothing": (lambda x: np.array([x[0] - 0.3, 2.0 * x[0] - 0.7, 0.0 * x[1]]), [0.9, 0.4], [0.0] * 2, [1.0] * 2),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_solver_ends_where_scipy_does(name):
    optimize = pytest.importorskip("scipy.optimize")
    residual, start, low, high = PROBLEMS[name]
    start, low, high = np.array(start), np.array(low), np.array(high)
    ours = least_squares(residual, differences(residual), start, low, high, 300, 1e-12)
    theirs = optimize.least_squares(residual, np.clip(start, low + 1e-9, high - 1e-9), bounds=(low, high), xtol=1e-12, ftol=1e-12)
    assert ours.cost <= 2.0 * theirs.cost * (1.0 + 1e-5) + 1e-12
    assert np.all((ours.x >= low) & (ours.x <= high))


def test_coordinates_are_the_inverse_of_the_stack():
    for number in range(5):
        structure = random_structure(2, number)
        stack = random_stack(structure, np.random.default_rng(number))
        parameters = Parameters(structure, 3)
        again = parameters.stack(parameters.coordinates(stack))
        assert parameters.coordinates(again) == pytest.approx(parameters.coordinates(stack))
        assert [e.kind for e in again.layers] == [e.kind for e in stack.layers] and again.base.kind == stack.base.kind
        # the ends of the cube are the schema's bounds: Stack checks them
        for x in (np.zeros(parameters.size), np.ones(parameters.size)):
            parameters.stack(x)


def test_the_papers_model_is_found_again_exactly():
    data = sample_model("weidlich_wilkie", COATED, pairs=800)
    fit = fit_structure(data, Structure.of(1, "lambert"), "weidlich_wilkie")
    assert fit.error < 1e-4
    assert fit.stack.layers[0]["ior"] == pytest.approx(1.6, abs=2e-3)
    assert fit.stack.layers[0]["roughness"] == pytest.approx(0.45, abs=1e-3)


def test_the_truth_is_found_again():
    structure = random_structure(1, 0)
    stack = random_stack(structure, np.random.default_rng(0))
    clean, _ = recovery(stack, structure, "adding", 0.0, 0)
    assert clean.shape < 0.01 and clean.error < 0.01 and clean.worst < 0.03 and clean.determined >= 3
    # the truth is slow: it is asked a few times and for its derivatives once; the tier analytic does the search (13 measured)
    assert clean.evaluations <= 16


def test_fewest_layers_that_the_data_support():
    bare = sample_model("weidlich_wilkie", replace(COATED, layers=()), pairs=400, noise=0.05)
    assert select(bare, base="lambert", model="weidlich_wilkie").best.structure == Structure.of(0, "lambert")
    coated = sample_model("weidlich_wilkie", COATED, pairs=400, noise=0.05)
    chosen = select(coated, model="weidlich_wilkie")
    assert chosen.best.structure == Structure.of(1, "lambert")
    assert "one more layer would bring the error from" in chosen.reason
    # not the data's noise is fitted but what is below it
    clean = sample_model("weidlich_wilkie", COATED, pairs=2000, seed=9)
    f = make_model("weidlich_wilkie", chosen.best.stack).f(clean.wo, clean.wi)
    assert shape_error(f, clean.f, clean.wi[:, 2]) < 0.03


def test_same_seed_same_stack():
    data = sample_model("weidlich_wilkie", COATED, pairs=300)
    stacks = [select(data, 1, "lambert", "weidlich_wilkie", 200, seed=3).best.stack for _ in range(2)]
    assert stacks[0] == stacks[1]


def test_what_data_do_not_determine_is_named():
    # behind a strong tint nothing is seen of the base
    dark = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.4, "tint": [1e-4] * 3}], "base": {"kind": "lambert"}})
    data = sample_model("weidlich_wilkie", dark, pairs=400, noise=0.02)
    values = {v.name: v for v in certainty(fit_structure(data, Structure.of(1, "lambert"), "weidlich_wilkie"))}
    assert values["roughness of layer 0"].determined and values["ior of layer 0"].determined
    assert not values["red color of the base"].determined or not values["red tint of layer 0"].determined
    assert values["roughness of layer 0"].value == pytest.approx(0.4, abs=4.0 * values["roughness of layer 0"].standard_error)


def test_what_data_say_nothing_of_stays_usual():
    hidden = Stack.from_dict(
        {
            "layers": [{"kind": "dielectric", "roughness": 0.4, "tint": [1e-4] * 3}],
            "base": {"kind": "conductor", "reflectance": [0.99] * 3, "edge_color": [0.01] * 3},
        }
    )
    fit = fit_structure(sample_model("weidlich_wilkie", hidden, pairs=300), Structure.of(1, "conductor"), "weidlich_wilkie")
    assert fit.error < 1e-3
    assert fit.stack.base["edge_color"] == pytest.approx((0.65,) * 3, abs=0.1)
    assert not any(v.determined for v in certainty(fit) if "edge_color" in v.name)


def test_what_good_fits_disagree_on_is_not_called_determined(monkeypatch):
    # a metal below two layers has several valleys; here all else claims to know everything
    monkeypatch.setattr(certainties, "straight", lambda jacobian, deviation: np.full(jacobian.shape[1], 1e-4))
    monkeypatch.setattr(certainties, "_profile_error", lambda *about: 0.0)
    structure = random_structure(2, 1)
    stack = random_stack(structure, np.random.default_rng(201))
    data, _ = data_of(stack, "adding", 0.05, np.random.default_rng(1))
    parameters = Parameters(structure, 3)
    fit = corrected(subsampled(data, 150), Start(structure, parameters.coordinates(stack)), "adding", 0, options=SETTINGS["adding"])
    known = {v.name for v in certainty(fit) if v.determined}
    assert "roughness of layer 0" in known
    assert not any(name.endswith("edge_color of the base") for name in known)


def coated_metal(pairs=150):
    """A fit at the truth of a metal below one layer, noise 5 %, whose edge colors make up for each other."""
    structure = random_structure(1, 16)
    stack = random_stack(structure, np.random.default_rng(116))
    data, _ = data_of(stack, "adding", 0.05, np.random.default_rng(16))
    begin = Start(structure, Parameters(structure, 3).coordinates(stack))
    return corrected(subsampled(data, pairs), begin, "adding", 0, options=SETTINGS["adding"])


def test_a_value_that_may_as_well_be_another_has_a_large_error():
    fit = coated_metal()
    coarse, _ = stand_in("adding", fit.parameters, fit.metric, fit.discrepancy)
    for i, (name, value) in enumerate(zip(fit.parameters.names, fit.parameters.values(fit.x))):
        error = certainties._profile_error(coarse, fit, i, COHERENT_ERROR) / value
        if name.endswith("edge_color of the base"):
            assert error > 0.1
        if name.endswith("of layer 0") and "tint" not in name:
            assert error < 0.02


def test_derivatives_that_are_sure_of_all_are_not_believed(monkeypatch):
    # derivatives at two places, or updates of a last short step, added up, know everything
    monkeypatch.setattr(certainties, "_disagreement", lambda *about: 0.0)
    monkeypatch.setattr(certainties, "_profile_error", lambda *about: 0.0)
    fit = coated_metal()
    values = certainty(replace(fit, jacobian=1e3 * np.eye(len(fit.residual), fit.count)))
    known = {v.name for v in values if v.determined}
    assert {"ior of layer 0", "roughness of layer 0"} <= known
    assert not any(name.endswith("edge_color of the base") for name in known)


def test_a_fit_begins_where_the_model_itself_is_near():
    metric = subsampled(sample_model("adding", COATED, pairs=60))
    structure = Structure.of(1, "lambert")
    right = Parameters(structure, 3).coordinates(COATED)
    # the stand-in's best is far from the data, its second is the truth
    found = [(structure, Solution(x, np.full(1, residual), 1)) for x, residual in ((0.5 * right, 1.0), (right, 1.2))]
    start = nearest(metric, found, "adding", QUICK["adding"])
    assert start.x is right and np.sqrt(np.mean(np.square(start.value - metric.target.ravel()))) < 0.01
    assert nearest(metric, [found[0], (structure, Solution(right, np.full(1, 3.0), 1))], "adding", QUICK["adding"]).x is found[0][1].x


def test_a_fit_follows_the_place_that_first_steps_bring_nearest_and_others_where_no_noise_is_left(monkeypatch):
    data = sample_model("adding", COATED, pairs=60)
    structure = Structure.of(1, "lambert")
    smooth = np.repeat(np.cos(data.wi[:, 2]) - 0.5, 3)
    smooth /= np.sqrt(np.mean(np.square(smooth)))
    noise = np.random.default_rng(0).standard_normal(180)

    def followed(begun, ended):
        """The error, and the places that are followed to their ends, whose residuals are `ended`; `begun` those of first steps."""
        places = [np.full(Parameters(structure, 3).size, 0.2 * i) for i in range(3)]
        taken = []

        def fit_at(x, residual):
            return Fit("adding", Parameters(structure, 3), subsampled(data), x, residual, np.zeros((180, x.size)), 1, residual)

        def number_of(x):
            return round(float(x[0]) / 0.2)

        def polished_from(fit, *more, **options):
            taken.append(number_of(fit.x))
            return fit_at(fit.x, ended[taken[-1]])

        # the last place is where the first is, and not begun from again
        monkeypatch.setattr(fitting, "rough_fits", lambda *given: [(structure, Solution(x, np.ones(1), 1)) for x in (*places, places[0] + 1e-3)])
        monkeypatch.setattr(fitting, "corrected", lambda metric, start, *more: fit_at(start.x, begun[number_of(start.x)]))
        monkeypatch.setattr(fitting, "polished", polished_from)
        fit = fit_structure(data, structure)
        assert fit.evaluations == 3, "one of each place"
        return fit.error, taken

    begun = [0.03 * smooth, 0.02 * smooth, 0.025 * smooth]
    assert followed(begun, begun) == (pytest.approx(0.02), [1, 2, 0])
    assert followed(begun, [begun[0], begun[1], 0.0005 * smooth]) == (pytest.approx(0.0005), [1, 2])
    assert followed(begun, [begun[0], 0.0009 * smooth, begun[2]]) == (pytest.approx(0.0009), [1]), "explained"
    assert followed([0.4 * smooth, 0.3 * smooth, 0.5 * smooth], [smooth, 0.3 * smooth, smooth]) == (pytest.approx(0.3), [1]), "no stack does"
    assert followed(begun, [begun[0], 0.03 * noise, begun[2]])[1] == [1], "noise"


def test_a_choice_that_leaves_no_noise_and_does_not_explain_the_data_begins_elsewhere(monkeypatch):
    data, structure = sample_model("adding", COATED, pairs=60), Structure.of(1, "lambert")
    metric, parameters = subsampled(data), Parameters(structure, 3)
    smooth = np.repeat(np.cos(data.wi[:, 2]) - 0.5, 3)
    smooth /= np.sqrt(np.mean(np.square(smooth)))
    begins = [np.full(parameters.size, 0.2 * i) for i in range(3)]

    def fit_at(x, residual):
        return Fit("adding", parameters, metric, x, residual, np.zeros((180, x.size)), 1, residual)

    def ends(residual, others):
        tried = []
        monkeypatch.setattr(layer_count, "rough_fits", lambda *given: [(structure, Solution(x, np.ones(1), 1)) for x in begins])
        monkeypatch.setattr(layer_count, "corrected", lambda metric, start, *more, **options: tried.append(start) or fit_at(start.x, others[len(tried) - 1]))
        monkeypatch.setattr(layer_count, "polished", lambda fit, **options: fit)
        found = layer_count._Search(metric, "adding", np.random.default_rng(0)).unstuck(fit_at(np.full(parameters.size, 0.9), residual))
        return found.error, len(tried)

    assert ends(0.02 * smooth, [0.03 * smooth, 0.004 * smooth, 0.01 * smooth]) == (pytest.approx(0.004), 3)
    assert ends(0.02 * smooth, [0.03 * smooth, 0.04 * smooth, 0.05 * smooth]) == (pytest.approx(0.02), 3), "none is nearer"
    assert ends(0.3 * smooth, [])[1] == 0, "no stack explains it"
    assert ends(0.03 * np.random.default_rng(0).standard_normal(180), [])[1] == 0, "noise"


def test_the_bar_goes_on_to_the_end():
    metal = replace(COATED, layers=(), base=Stack.from_dict({"layers": [], "base": {"kind": "conductor", "metal": "gold", "roughness": 0.5}}).base)
    shares: list[float] = []
    select(sample_model("adding", metal, pairs=60, noise=0.05), 0, "conductor", "adding", 60, progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0
    # the last part is the longest: the model's own settings
    assert any(0.5 < share < 1.0 for share in shares)


def test_what_a_model_cannot_say_counts_less_than_noise():
    noisy = sample_model("weidlich_wilkie", COATED, pairs=400, noise=0.05)
    fitted = fit_structure(noisy, Structure.of(1, "lambert"), "weidlich_wilkie")
    lacking = fit_structure(sample_model("weidlich_wilkie", COATED, pairs=400), Structure.of(0, "oren_nayar"), "weidlich_wilkie")
    assert independent_pairs(fitted) > 0.7 * 400
    assert independent_pairs(lacking) < 0.5 * 400
    for fit, larger in ((fitted, 0), (lacking, 1)):
        parts = noise_and_misfit(fit)
        assert np.hypot(*parts) == pytest.approx(fit.error) and parts[larger] > parts[1 - larger]
    assert noise_and_misfit(fitted)[0] == pytest.approx(0.05, abs=0.015), "the noise that was put in"


def test_a_larger_stack_is_never_worse_than_one_that_it_contains():
    metric = subsampled(sample_model("weidlich_wilkie", COATED, pairs=400, noise=0.05))
    structure, larger = Structure.of(1, "lambert"), Structure.of(2, "lambert")
    less = corrected(metric, Start(structure, Parameters(structure, 3).coordinates(COATED)), "weidlich_wilkie")
    x = Parameters(larger, 3).without_effect(less.parameters, less.x)
    wi, wo = spread_pairs(50, np.random.default_rng(0))
    one, two = (make_model("weidlich_wilkie", fit.stack(at)).f(wo, wi) for fit, at in ((less.parameters, less.x), (Parameters(larger, 3), x)))
    np.testing.assert_allclose(two, one, rtol=1e-9)
    stuck = replace(less, parameters=Parameters(larger, 3), x=np.full(Parameters(larger, 3).size, 0.5), residual=2.0 * less.residual)
    better = layer_count._containing(stuck, less)
    assert better.structure == larger and better.error == less.error and "gains nothing" in layer_count._reason(less, [less, better], "auto")
    # a place to begin: what follows is no worse either
    search = layer_count._Search(metric, "weidlich_wilkie", np.random.default_rng(0))
    assert search.closer(better).error <= less.error * (1.0 + 1e-9)
    assert layer_count._containing(less, stuck) is less and layer_count._containing(stuck, None) is stuck


def test_a_metal_must_gain_more_than_noise():
    metric = subsampled(sample_model("weidlich_wilkie", COATED, pairs=400, noise=0.05))
    structure = Structure.of(1, "lambert")
    plain = corrected(metric, Start(structure, Parameters(structure, 3).coordinates(COATED)), "weidlich_wilkie")
    metal = replace(plain, parameters=Parameters(Structure.of(1, "conductor"), 3), residual=0.9 * plain.residual)
    assert layer_count.criterion(metal) < layer_count.criterion(plain)
    assert layer_count.preferred([plain, metal]) is plain
    assert layer_count.preferred([plain, replace(metal, residual=0.1 * plain.residual)]).structure.base == "conductor"
    assert layer_count.preferred([metal]) is metal, "a metal that was asked for"


def test_a_measurement_that_no_stack_explains():
    wi, wo = spread_pairs(400, np.random.default_rng(0))
    f = np.where(np.sin(25.0 * wo[:, :1]) > 0.0, 3.0, 0.01) * np.ones(3)
    data = checked(wi, wo, f, "stripes")
    told = outcome(data, select(data, 1, "lambert", "weidlich_wilkie"))
    assert not told["explains"] and told["error"] > 0.5
    # a brushed metal: the derivatives alone would be sure of its one roughness
    angle = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 400)
    wi, wo = ((np.einsum("ijn,nj->ni", [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]], w[:, :2]), w[:, 2:]) for w in (wi, wo))
    wi, wo = np.hstack(wi), np.hstack(wo)
    wh = half_vector(wi, wo)
    f = np.exp(-(np.square(wh[:, 0] / 0.08) + np.square(wh[:, 1] / 0.35)) / np.square(wh[:, 2])) / (0.1 * wi[:, 2] * wo[:, 2])
    brushed = checked(wi, wo, f[:, None] + 0.02, "brushed")
    told = outcome(brushed, select(brushed, 0, "conductor", "weidlich_wilkie"))
    assert not told["explains"] and len(told["not_determined"]) == len(told["parameters"])
    good = sample_model("weidlich_wilkie", COATED, pairs=400)
    told = outcome(good, select(good, 1, "lambert", "weidlich_wilkie"))
    assert told["explains"] and Stack.from_dict(told["stack"]).layers


def test_the_color_below_a_mirror_like_highlight_is_found():
    paint = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.08}], "base": {"kind": "lambert", "color": [0.5, 0.2, 0.1]}})
    glossy = make_model("weidlich_wilkie", paint)
    wi, wo = spread_pairs(400, np.random.default_rng(1))
    # most pairs are at the highlight, whose f is hundreds of times the color's
    kept = (half_vector(wi, wo)[:, 2] > np.cos(np.radians(12.0))) | (np.arange(400) % 6 == 0)
    wi, wo = wi[kept], wo[kept]
    found = make_model("weidlich_wilkie", select(checked(wi, wo, glossy.f(wo, wi), "gloss"), model="weidlich_wilkie").best.stack)
    wi, wo = spread_pairs(300, np.random.default_rng(9))
    off = half_vector(wi, wo)[:, 2] < np.cos(np.radians(25.0))
    # .5 % measured; 22 % with a floor of a tenth of the mean
    assert found.f(wo[off], wi[off]) == pytest.approx(glossy.f(wo[off], wi[off]), rel=0.02)


def test_what_a_highlight_hides_is_told():
    wi, wo = spread_pairs(300, np.random.default_rng(0))
    bright = wi[:, 2] > np.cos(np.radians(35.0))
    f = np.where(bright, 3000.0, 0.004)[:, None]
    metric = Metric(checked(wi, wo, f, "hidden"))
    black = np.where(bright, 3000.0, 0.0)[:, None]
    assert metric.error(black) < 0.02  # which says nothing of the rest
    share, factor = metric.hidden(black)
    assert share == pytest.approx(1.0 - bright.mean()) and factor > 20.0
    assert metric.hidden(1.3 * f)[0] == 0.0


def test_two_values_that_do_the_same_do_not_stop_the_solver():
    found = least_squares(lambda x: np.array([(x[0] + x[1]) ** 3]), lambda x, r: np.full((1, 2), 3.0 * (x[0] + x[1]) ** 2),
                          np.ones(2), -2.0 * np.ones(2), 2.0 * np.ones(2), 100, 0.0)  # fmt: skip
    assert abs(found.residual[0]) < 1e-12


def test_one_wavelength_gives_a_grey_stack():
    data = sample_model("lafortune", presets.load("blue_wall_paint"), 550.0, pairs=300)
    assert data.channels == 1
    stack = fit_structure(data, Structure.of(1, "lambert"), "weidlich_wilkie").stack
    assert len(set(stack.base["color"])) == 1


def test_bad_choices_are_named():
    data = sample_model("weidlich_wilkie", COATED, pairs=60)
    for options, word in (({"model": "position_free"}, "adding"), ({"base": "gold"}, "conductor"), ({"layers": 9}, "0 to 8"), ({"samples": 3}, "50")):
        with pytest.raises(LaminaError, match=word):
            select(data, **options)


@pytest.mark.parametrize("baseline", BASELINE_MODELS, ids=lambda p: p.name)
def test_baselines_find_themselves(baseline):
    low, high = baseline.bounds(1)
    usual = np.array([0.5 * sum(t.usual) if t.name != "diffuse" else 0.3 for t in baseline.terms])
    if baseline.name == "lafortune":
        usual = np.array([0.3, -0.9, 0.9, 30.0, -0.4, 0.1, 3.0, 0.85, 0.8, 20.0])
    wi, wo = spread_pairs(300, np.random.default_rng(1))
    f = baseline.f(baseline.values(usual, 1), wi, wo)
    fit = fit_baseline(baseline, subsampled(checked(wi, wo, f, baseline.name)))
    assert fit.count == len(low) == baseline.count(1)
    assert fit.error < 0.01


def test_millions_of_directions_cost_little():
    grey = COATED.layers[0].with_values(tint=(1.0,) * 3)
    stack = replace(COATED, layers=(grey,), base=COATED.base.with_values(color=(0.5,) * 3))
    wi, wo = spread_pairs(1000, np.random.default_rng(2))
    exact = make_model("adding", stack).f(wo, wi)
    many = 25
    quick = evaluate_all("adding", stack, np.tile(wo, (many, 1)), np.tile(wi, (many, 1)))[:1000]
    assert shape_error(quick, exact, wi[:, 2]) < 0.01


def test_the_metric_reads_as_a_relative_error():
    wi, wo = spread_pairs(500, np.random.default_rng(3))
    data = checked(wi, wo, paint(wi, wo), "paint")
    assert Metric(data).error(1.02 * data.f) == pytest.approx(0.02, rel=0.15)
    assert Metric(data).error(data.f) == 0.0
