# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells people about values that a highlight hides."""

from importlib import import_module

import numpy as np
import pytest
from support.stacks import coat, lambert, stack

from lamina.reference_py.fit.fitting import Fit
from lamina.reference_py.fit.layer_count import Selection
from lamina.reference_py.fit.metric import Metric
from lamina.reference_py.fit.parameters import Parameters, Structure
from lamina.reference_py.fit.readers.measurement import checked, spread_pairs
from lamina.reference_py.registry import make_model

STRUCTURE = Structure.of(1, "lambert")
COLOR = 0.012


def glossy(color):
    return stack(coat(0.03), base=lambert(color))


def told(wi, wo, f, monkeypatch):
    """The outcome of a fit whose stack has a base of `COLOR` below a highlight, for these data."""
    module = import_module("lamina.reference_py.fit.outcome")
    # how sure values are is not asked here, and takes most of the time
    monkeypatch.setattr(module, "certainty", lambda fit: [])
    data = checked(wi, wo, f, "glossy")
    metric, parameters = Metric(data), Parameters(STRUCTURE, data.channels)
    residual = metric.residual(measured((wi, wo), COLOR)[:, : data.channels]).ravel()
    fit = Fit("weidlich_wilkie", parameters, metric, parameters.coordinates(glossy(COLOR)), residual, np.zeros((0, 0)), 1, np.zeros(0))
    return module.outcome(data, Selection(fit, (fit,), "as many layers as asked for"))


@pytest.fixture(scope="module")
def pairs():
    return spread_pairs(400, np.random.default_rng(1))


def measured(pairs, color):
    wi, wo = pairs
    return make_model("weidlich_wilkie", glossy(color)).f(wo, wi)


@pytest.mark.parametrize("factor", [3.0, 10.0])
def test_a_color_that_is_off_beside_a_highlight_is_warned_of(pairs, factor, monkeypatch):
    wi, wo = pairs
    f, ours = (np.mean(measured(pairs, color), axis=1) for color in (factor * COLOR, COLOR))
    result = told(wi, wo, f[:, None], monkeypatch)
    # by hand: what is off by more than two, but too dim to count
    off = (f / ours > 2.0) & (f * wi[:, 2] < 0.1 * np.mean(f * wi[:, 2])) & (f > 1e-3)
    assert off.mean() > 0.2
    (warning,) = result["warnings"]
    percent, words = warning.split(" % of the values are off by more than a factor of two ")
    assert float(percent) == pytest.approx(100.0 * off.mean(), abs=2.0)
    median, rest = words.removeprefix("(").split(" in the median) ")
    assert float(median) == pytest.approx(np.median((f / ours)[off]), rel=0.1)
    assert rest == "but hardly count, as they are dim beside the highlight"


@pytest.mark.parametrize("factor", [1.0, 1.5])
def test_within_a_factor_of_two_nothing_is_said(pairs, factor, monkeypatch):
    assert told(*pairs, measured(pairs, factor * COLOR), monkeypatch)["warnings"] == []


@pytest.mark.parametrize("share, warns", [(0.04, False), (0.07, True)])
def test_a_twentieth_of_the_values_is_worth_a_warning(pairs, share, warns, monkeypatch):
    wi, wo = pairs
    f = measured(pairs, COLOR)[:, :1]
    dim = np.flatnonzero((f * wi[:, 2:] < 0.02 * np.mean(f * wi[:, 2:]))[:, 0] & (f[:, 0] > 1e-3))
    f[dim[: int(share * len(f))]] *= 4.0
    assert len(dim) > share * len(f)
    assert bool(told(wi, wo, f, monkeypatch)["warnings"]) == warns


def test_nothing_is_hidden_where_nothing_is_bright(monkeypatch):
    """A base that is off by four is seen by the error itself, without a highlight."""
    wi, wo = spread_pairs(200, np.random.default_rng(2))
    result = told(wi, wo, np.full((200, 1), 4.0 * COLOR / np.pi), monkeypatch)
    assert result["warnings"] == [] and not result["explains"]
