# SPDX-License-Identifier: GPL-3.0-or-later
"""How well data determine parameters: standard errors, and the names of those that are not determined.

The Jacobian tells how far values may move in a straight line. Valleys are curved, so each value that may move far is also
pinned at other places while the others are fitted again, on the stand-in plus its discrepancy (a profile likelihood), and so
is each value that would be called determined, unless its error is too small for any curve: an edge color near 1 changes a metal so
fast that derivatives there are sure of it, and .4 may fit as well. There may also be several valleys: what fits from other starts disagree on, though they are as good, is not
determined either: else wrong ones are called determined below two layers (tests/reference_py/test_fit.py, "disagree").
"""

from dataclasses import dataclass

import numpy as np

from .fitting import Fit, rough_solutions
from .forward import MODEL_ERROR, Forward
from .likeness import likeness
from .metric import rms
from .prior import POLISHED
from .profile_likelihood import COHERENT_ERROR, pinned, straight, weakly_determined
from .stand_in import stand_in
from .starts import best_starts

# A value is not determined when its standard error exceeds this part of it.
OF_VALUE = 0.05
_AT_BOUND = 1e-4
# Where weakly determined coordinates are pinned.
_PLACES = (0.1, 0.5, 0.9, 1.0)
# Starts of other fits.
_STARTS = 8
# Parts of its value where one that would be called determined is pinned; below this part of `OF_VALUE` a number that is no color needs none.
_PARTS, _CERTAIN = (0.8, 0.5, 1.25), 0.2


@dataclass(frozen=True)
class Value:
    """One fitted number in the schema's units."""

    name: str
    value: float
    standard_error: float
    determined: bool
    at_bound: bool


def independent_pairs(fit: Fit) -> float:
    """How many independent pairs the residuals are worth: n (1 - r) / (1 + r), r being the correlation of neighbours."""
    r = likeness(fit.metric, fit.residual)
    return len(fit.metric.measurement.f) * (1.0 - r) / (1.0 + r)


def noise_and_misfit(fit: Fit) -> tuple[float, float]:
    """The parts of a fit's error, whose squares add up to its: what differs from pair to pair, and what neighbours share."""
    r = likeness(fit.metric, fit.residual)
    return fit.error * float(np.sqrt(1.0 - r)), fit.error * float(np.sqrt(r))


def certainty(fit: Fit) -> list[Value]:
    """Every parameter's value and standard error, of as many independent residuals as those found are worth."""
    p = fit.parameters
    rows, pairs = len(fit.residual), len(fit.metric.measurement.f)
    alike = pairs / independent_pairs(fit)
    deviation = np.sqrt(alike * rows / max(rows - p.size, 1)) * fit.error
    deviation = max(deviation, COHERENT_ERROR)
    coarse, _ = stand_in(fit.model, p, fit.metric, fit.discrepancy)
    # derivatives of the model at one place and of the stand-in at another, together, are sure of what neither knows
    error = np.maximum(straight(fit.jacobian, deviation), straight(coarse.jacobian(fit.x), deviation))
    error = np.maximum(error, _reach(coarse, fit, error))
    values, widths = p.values(fit.x), p.ranges()
    curved = np.repeat([g.is_color for g in p.groups], [len(g.index) for g in p.groups])
    spread = np.minimum(p.slopes(fit.x) * error + np.where(curved, widths * np.square(error), 0.0), widths)
    bound = (fit.x <= _AT_BOUND) | (fit.x >= 1.0 - _AT_BOUND)
    spread = np.maximum(spread, _disagreement(coarse, fit))
    for i in np.flatnonzero((spread <= OF_VALUE * np.abs(values)) & (curved | (spread > _CERTAIN * OF_VALUE * np.abs(values)))):
        spread[i] = max(spread[i], _profile_error(coarse, fit, int(i), deviation))
    known = spread <= OF_VALUE * np.abs(values)
    return [Value(*row) for row in zip(p.names, values.tolist(), spread.tolist(), known.tolist(), bound.tolist())]


def _reach(coarse: Forward, fit: Fit, error: np.ndarray) -> np.ndarray:
    """(p,) how far coordinates move where weakly determined ones are pinned and the data are met as well, as far as models go."""
    weak = [np.intersect1d(weakly_determined(error), group.index) for group in fit.parameters.groups]
    pins = [(which, place) for which in weak if len(which) for place in _PLACES]
    as_good = [found.x for found in pinned(coarse, fit.x, pins) if rms(found.residual) <= np.hypot(fit.error, MODEL_ERROR)]
    return np.max([np.zeros(len(error)), *(np.abs(x - fit.x) for x in as_good)], axis=0)


def _profile_error(coarse: Forward, fit: Fit, i: int, deviation: float) -> float:
    """The standard error of value i by how much worse the data are met where it is pinned elsewhere, of residuals of some deviation.

    The largest of a few places; past the bound of what is determined no further place is looked at.
    """
    group = next(g for g in fit.parameters.groups if i in g.index)
    value, worst = float(fit.parameters.values(fit.x)[i]), 0.0
    for place in value * np.array(_PARTS):
        if group.range[0] <= place <= group.range[1] and worst <= OF_VALUE * abs(value):
            (found,) = pinned(coarse, fit.x, [(np.array([i]), float(group.coordinate(place)))])
            rise = found.cost - float(fit.residual @ fit.residual)
            worst = max(worst, abs(place - value) * min(deviation / np.sqrt(max(rise, 1e-30)), 1.0))
    return worst


def _disagreement(coarse: Forward, fit: Fit) -> np.ndarray:
    """(p,) how far values of the fit and of fits of the stand-in plus its discrepancy from several starts lie apart, of those that are as good.

    As far as the stand-in can tell, since its discrepancy changes from place to place. The prior hardly pulls, or all would agree on what it says.
    """
    found = rough_solutions(coarse, best_starts(coarse, _STARTS, np.random.default_rng(0)), POLISHED)
    as_good = np.hypot(rms(found[0].residual), max(rms(fit.discrepancy), MODEL_ERROR))
    near = [fit.x, *(other.x for other in found if rms(other.residual) <= as_good)]
    return np.ptp([fit.parameters.values(x) for x in near], axis=0)
