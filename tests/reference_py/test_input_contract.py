# SPDX-License-Identifier: GPL-3.0-or-later
"""What every model of the registry does with its input (`optics.frame`): unit vectors, NaN, nothing at all, seeds, batches."""

import inspect
from functools import cache

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics import beckmann
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import MODELS, make_model, model_options

TINTED = {
    "layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.5, "tint": [0.5, 0.8, 1.0]}],
    "base": {"kind": "lambert", "color": [0.8, 0.5, 0.2]},
}
COVERED = {**TINTED, "layers": [{**TINTED["layers"][0], "coverage": 0.5}]}
OPTIONS = {"adding": {"nodes": 8, "modes": 8}, "position_free": {"walks": 16}, "closure_model": {"method": "analytic"}}
UP = np.array([0.0, 0.0, 1.0])
WO = spherical(np.radians([0.0, 20.0, 50.0, 80.0, 120.0]), [0.0, 1.0, 2.0, 3.0, 4.0])
WI = spherical(np.radians([70.0, 40.0, 10.0, 60.0, 30.0]), [2.0, 3.0, 5.0, 1.0, 0.5])


@cache
def model_of(name, covered=False):
    return make_model(name, Stack.from_dict(COVERED if covered else TINTED), **OPTIONS.get(name, {}))


SAMPLED = [name for name in MODELS if hasattr(MODELS[name], "sample")]
every_model = pytest.mark.parametrize("name", MODELS)
with_and_without_patches = pytest.mark.parametrize("covered", [False, True])


def calls(model):
    """Every method of a model that takes a view, or a view and a light, as functions of just these."""
    found = {"f": model.f, "albedo": lambda wo, _: model.albedo(wo)}
    if model.name in SAMPLED:
        found |= {"pdf": model.pdf, "sample": lambda wo, _: model.sample(wo, 1)[0], "valid": lambda wo, _: model.sample(wo, 1)[1]}
    if model.stochastic:
        found |= {"f_stderr": lambda wo, wi: model.f_stderr(wo, wi)[1], "albedo_stderr": lambda wo, _: model.albedo_stderr(wo)[1]}
    return found.items()


@every_model
@pytest.mark.parametrize("length", [0.0, 1.0 - 1e-5, 1.0 + 1e-5, 2.0, np.inf])
def test_what_is_no_unit_vector_is_refused(name, length):
    with np.errstate(invalid="ignore"):
        bad = np.where(UP > 0.0, length, 0.0)
    for method, call in calls(model_of(name)):
        with pytest.raises(LaminaError, match=r"wo has a direction of length .*unit vectors, to within 1e-06"):
            call(np.array([UP, bad]), UP)
    with pytest.raises(LaminaError, match="wi has a direction of length"):
        model_of(name).f(UP, bad)


@every_model
def test_rounding_of_single_precision_is_no_fault(name):
    for method, call in calls(model_of(name)):
        assert np.all(np.isfinite(call(WO.astype(np.float32), WI.astype(np.float32))))
        call(UP * (1.0 + 0.9e-6), UP)


@every_model
@pytest.mark.parametrize(("wo", "said"), [("up", "choose directions"), ([1.0, 0.0], "three numbers"), (1.0, "three numbers"), (WO[:2], "do not broadcast")])
def test_what_is_no_direction_is_refused_in_one_line(name, wo, said):
    with pytest.raises(LaminaError, match=said) as caught:
        model_of(name).f(wo, WI)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@with_and_without_patches
@every_model
def test_a_direction_with_a_nan_gives_nan_and_harms_no_other(name, covered):
    model = model_of(name, covered)
    wo = WO.copy()
    wo[1, 0] = np.nan
    for method, call in calls(model):
        value, whole = call(wo, WI), call(WO, WI)
        assert value.shape == whole.shape
        assert not value[1] if method == "valid" else np.all(np.isnan(value[1]))
        if not model.stochastic and method not in ("sample", "valid"):
            assert np.delete(value, 1, axis=0) == pytest.approx(np.delete(whole, 1, axis=0), rel=1e-12, abs=1e-15)
        assert np.all(np.isfinite(np.delete(value, 1, axis=0)))
    assert np.all(np.isnan(model.f(WO[:, None], wo)[:, 1])) and np.all(np.isnan(model.f(np.full(3, np.nan), UP)))


@with_and_without_patches
@every_model
def test_no_directions_give_an_empty_result(name, covered):
    model = model_of(name, covered)
    for method, call in calls(model):
        empty, one = call(np.empty((2, 0, 3)), UP), call(UP, UP)
        assert empty.shape == (2, 0, *np.shape(one)) and empty.dtype == one.dtype


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MODELS if not MODELS[name].stochastic])
def test_a_value_does_not_depend_on_its_batch(name):
    model = model_of(name)
    for method, call in calls(model):
        if method not in ("sample", "valid"):
            alone = np.array([call(wo, wi) for wo, wi in zip(WO, WI)])
            assert call(WO, WI) == pytest.approx(alone, rel=1e-12, abs=1e-15)


@with_and_without_patches
@pytest.mark.parametrize("name", SAMPLED)
def test_seeds_and_generators_are_both_taken(name, covered):
    model, wo = model_of(name, covered), np.repeat(WO, 20, axis=0)
    wi, valid = model.sample(wo, 7)
    again = model.sample(wo, np.random.default_rng(7))
    assert np.array_equal(wi, again[0]) and np.array_equal(valid, again[1])
    assert np.linalg.norm(wi, axis=-1) == pytest.approx(1.0, abs=1e-6)  # so that f and pdf take them
    assert np.all(np.isfinite(model.f(wo, wi))) and np.any(model.sample(wo, 8)[0] != wi)
    for bad in (None, -1, 1.5, True, "7"):
        with pytest.raises(LaminaError, match="choose a seed, a whole number from 0, or a numpy.random.Generator"):
            model.sample(wo, bad)


def test_walks_take_seeds_and_generators():
    model = model_of("position_free")
    first = model.f_stderr(WO, WI, rng=7)
    assert np.array_equal(first, model.f_stderr(WO, WI, rng=np.random.default_rng(7)))
    assert np.array_equal(model.albedo(WO), model.albedo_stderr(WO, rng=0)[0])  # the model's own seed


@every_model
def test_a_nan_among_a_stacks_values_is_refused(name):
    stack = Stack.from_dict(TINTED)
    layer = stack.layers[0]
    for values, said in (({"ior": np.nan}, "layer 0: ior is nan"), ({"tint": (0.5, np.nan, 0.5)}, r"layer 0: tint is \(0.5, nan, 0.5\)")):
        with pytest.raises(LaminaError, match=said):
            make_model(name, Stack((layer.with_values(**values),), stack.base), **OPTIONS.get(name, {}))


@every_model
def test_options_are_in_the_signature(name):
    parameters = inspect.signature(MODELS[name]).parameters
    assert list(parameters)[0] == "stack" and model_options(name) == tuple(parameters)[1:]
    assert all(p.kind is p.POSITIONAL_OR_KEYWORD and p.default is not p.empty for p in list(parameters.values())[1:])


def test_beckmanns_masking_begins_where_its_formula_does():
    at = 1.0 / 1.6**2
    lam = beckmann.Beckmann().smith_lambda(np.array([at * (1.0 - 1e-12), at, np.nextafter(at, 1.0), 0.3902]))
    assert np.array_equal(lam[[0, 1, 3]], np.zeros(3)) and lam[2] == pytest.approx(-5.7e-5, rel=0.01)
