# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit of one structure to one measurement.

Guesses are improved on the stand-in of a slow model (`forward`), then the model itself is asked: the stand-in plus its
discrepancy at the last point is fitted (Bandler et al. 2004, "Space Mapping: The State of the Art"), where the discrepancy is kept as a linear
function that every evaluation corrects by one rank (Broyden 1965, "A Class of Methods for Solving Nonlinear
Simultaneous Equations"). So the truth is evaluated about once per step.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from ..material.stack import Stack
from .forward import DEFAULT_MODEL, MODEL_ERROR, SMOOTH, Forward, ModelForward, require_fittable
from .likeness import likeness
from .metric import Metric, percent, rms
from .parameters import Parameters, Structure
from .prior import FINE, POLISHED, ROUGH, pulled
from .profile_likelihood import pinned, straight, weakly_determined
from .readers.measurement import Measurement, subsample
from .solve import Ask, Solution, search
from .stand_in import stand_in
from .starts import are_apart, best_starts

SAMPLES, STEPS = 500, 8
# Fits of a stand-in, and of a model that is fitted itself, whose best is the result.
STARTS, DIRECT_STARTS = 4, 8
# Steps before the model's own derivatives are worth their time.
_FIRST_STEPS = 5
_ROUGH_SAMPLES, _ROUGH_STEPS, _ROUGH_TOLERANCE = 200, 32, 3e-3
# Fits of the stand-in within this many times the least cost are looked at with the model itself, at most so many.
_AS_NEAR, _MOST_NEAR = 2.0, 3
_DIRECT_STEPS, _CORRECTED_STEPS = 60, 8
# Trust region of the first corrected step, in coordinates, and the least move that counts.
_RADIUS, _STILL, _LEAST_RADIUS = 0.25, 2e-5, 1e-3
# A step that gains less than this part of the error is idle; so many in a row are enough.
_IDLE, _PATIENCE = 1e-2, 2
# Further beginnings: where weakly determined coordinates are pinned, or None for where the fit ended, as its derivatives have changed.
_BEGINNINGS = (None, 1.0, None)
# A fit within this is begun again from another place, as there may be a better one; noise and what no stack explains are more.
_NEAR = 2.0 * MODEL_ERROR
# Residuals of neighbours that are more alike than this are misfit rather than noise; between these errors there may be a stack without.
_ALIKE, _LEAST_MISFIT, _EXPLAINED = 0.5, 0.2 * MODEL_ERROR, 10.0 * MODEL_ERROR
# Good enough, as a residual: far below the accuracy of `adding`.
_EXACT = 1e-4

Progress = Callable[[float], None]


def share_of(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """What a part of the work, between two shares of the whole, tells its progress to."""
    return None if progress is None else lambda share: progress(begin + (end - begin) * share)


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """A stack, how far it is from the data, and how well they determine it. `x` (p,) is in coordinates of the parameters."""

    model: str
    parameters: Parameters
    metric: Metric
    x: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    evaluations: int
    discrepancy: np.ndarray
    """The stand-in's model discrepancy here, (m,): what it lacks to the model."""
    options: Mapping = field(default_factory=dict)
    """Those of the model, such as `QUICK`; none are its own settings."""

    @property
    def value(self) -> np.ndarray:
        """(m,) what the model says, compressed."""
        return self.residual + self.metric.target.ravel()

    @property
    def error(self) -> float:
        """RMS residual on the data that were fitted."""
        return rms(self.residual)

    @property
    def structure(self) -> Structure:
        """Layers, base and distributions that were fitted."""
        return self.parameters.structure

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.parameters.size

    @property
    def stack(self) -> Stack:
        """The fitted stack; its source names the data, the error and the model."""
        source = self.metric.measurement.source
        text = f"Fitted to {source}: error {percent(self.error)} of model {self.model}"
        return self.parameters.stack(self.x, self.structure.name.capitalize(), text)


@dataclass(frozen=True, eq=False, repr=False)
class Start:
    """Where a fit of the model itself begins: coordinates (p,), and what the model says there, (m,) compressed, if it was asked."""

    structure: Structure
    x: np.ndarray
    value: np.ndarray | None = None


def subsampled(measurement: Measurement, samples: int = SAMPLES, seed: int = 0) -> Metric:
    """The metric on at most `samples` pairs."""
    return Metric(subsample(measurement, samples, np.random.default_rng(seed)))


def rough_fits(
    metric: Metric,
    structures: Sequence[Structure],
    model: str,
    starts: int,
    rng: np.random.Generator,
    known: Sequence[tuple[Parameters, np.ndarray, int]] = (),
    steps: int = _ROUGH_STEPS,
) -> list[tuple[Structure, Solution]]:
    """Fits of the stand-in, best first. `structures` differ in their distributions: the first is fitted from several starts
    (`best_starts`), the others from where these end."""
    few = Metric(subsample(metric.measurement, _ROUGH_SAMPLES, rng), metric.kind)
    found, begun = [], None
    for structure in structures:
        forward, _ = stand_in(model, Parameters(structure, metric.measurement.channels), few)
        solved = rough_solutions(forward, begun or best_starts(forward, starts, rng, known), steps=steps)
        begun = begun or [solution.x for solution in solved]
        found += [(structure, solution) for solution in solved]
    return sorted(found, key=lambda option: option[1].cost)


def rough_solutions(forward: Forward, starts: Sequence[np.ndarray], pull: float = ROUGH, steps: int = _ROUGH_STEPS) -> list[Solution]:
    """A fit of a stand-in from each start (p,), best first."""
    return sorted(_solved(forward, starts, pull, _ROUGH_TOLERANCE, steps), key=lambda solution: solution.cost)


def nearest(metric: Metric, found: Sequence[tuple[Structure, Solution]], model: str, options: Mapping = MappingProxyType({}), most: int = _MOST_NEAR) -> Start:
    """Of fits of the stand-in, best first, that whose values bring the model itself nearest to the data: its own best need not. At most so many are asked."""
    channels, near = metric.measurement.channels, list[Start]()
    for structure, solution in found:
        parameters = Parameters(structure, channels)
        if not stand_in(model, parameters, metric)[1]:
            return Start(structure, solution.x)
        is_new = all(structure != other.structure or are_apart(solution.x, other.x) for other in near)
        if is_new and solution.cost <= _AS_NEAR * found[0][1].cost and len(near) < most:
            value = ModelForward(parameters, metric, model, options).compressed(solution.x)
            near.append(Start(structure, solution.x, value))
    return min(near, key=lambda start: rms(start.value - metric.target.ravel()))


def _solved(forward: Forward, starts: Sequence[np.ndarray], pull: float, tolerance: float, steps: int) -> list[Solution]:
    return pulled(forward.parameters, pull, forward.answers, [search(x, np.zeros(len(x)), np.ones(len(x)), steps, tolerance) for x in starts])


def corrected(
    metric: Metric,
    start: Start,
    model: str,
    steps: int = STEPS,
    progress: Progress | None = None,
    options: Mapping = MappingProxyType({}),
    slopes: np.ndarray | None = None,
) -> Fit:
    """The fit of the model itself from a start; `options` are those of a slow model, such as `QUICK`.

    `slopes` (m, p) is the model's own Jacobian there, if it is known; else the stand-in's serves.
    """
    parameters, x = Parameters(start.structure, metric.measurement.channels), start.x
    coarse, is_other = stand_in(model, parameters, metric)
    if not is_other:
        (solved,) = _solved(coarse, [x], POLISHED, 1e-6, _DIRECT_STEPS)
        slopes = coarse.jacobian(solved.x, solved.residual + coarse.target)
        return Fit(model, parameters, metric, solved.x, solved.residual, slopes, solved.steps, np.zeros(len(solved.residual)))
    fine = ModelForward(parameters, metric, model, options)
    radius, pull = (_RADIUS, FINE) if slopes is None else (0.5 * _RADIUS, POLISHED)
    at, value, base = x, fine.compressed(x) if start.value is None else start.value, coarse.compressed(x)
    target = coarse.target
    first_slopes = discrepancy_slopes = np.zeros((len(value), parameters.size)) if slopes is None else slopes - coarse.jacobian(x, base)
    evaluations, idle = 1, 0
    for step in range(steps):
        discrepancy = value - base
        solved = space_mapping_step(coarse, discrepancy, discrepancy_slopes, at, radius, pull)
        moved = solved.x - at
        if np.max(np.abs(moved)) < _STILL:
            break
        new, new_base = fine.compressed(solved.x), coarse.compressed(solved.x)
        evaluations += 1
        change = (new - new_base) - discrepancy - discrepancy_slopes @ moved
        discrepancy_slopes = discrepancy_slopes + np.outer(change, moved) / (moved @ moved)
        before, after = rms(value - target), rms(new - target)
        if after < before:
            at, value, base = solved.x, new, new_base
            radius = min(2.0 * radius, 0.5)
            idle = 0 if before - after > _IDLE * before else idle + 1
            if after < _EXACT:
                break
        else:
            radius = 0.4 * float(np.max(np.abs(moved)))
            # a step too far is no sign of the end; one that changes nothing is
            idle += after - before < _IDLE * before
        if idle == _PATIENCE or radius < _LEAST_RADIUS:
            break
        if progress is not None:
            progress((step + 1) / steps)
    # updates of one rank say nothing of directions not taken, and those of the last short steps are noise over hardly any way
    jacobian = coarse.jacobian(at, base) + first_slopes
    return Fit(model, parameters, metric, at, value - target, jacobian, evaluations, value - base, options)


def polished(
    fit: Fit,
    progress: Progress | None = None,
    options: Mapping = MappingProxyType({}),
    steps: int = STEPS,
) -> Fit:
    """The fit continued with the model's own derivatives, which are then those of the result.

    They cost as much as a third of their number of evaluations, since tints and colors share what their surfaces do. A
    fit that explains the data, but not to the last, is begun again, there and where weak values are pinned, as there may be a better one.
    """
    if not stand_in(fit.model, fit.parameters, fit.metric)[1]:
        return fit
    quick = ModelForward(fit.parameters, fit.metric, fit.model, {**SMOOTH.get(fit.model, {}), **options})

    def continued(x: np.ndarray, turn: int, known: Fit) -> Fit:
        part = share_of(progress, turn / (1 + len(_BEGINNINGS)), (turn + 1) / (1 + len(_BEGINNINGS)))
        value, here = (known.value if x is known.x and known.options == asked else None for asked in (options, quick.options))
        more = corrected(fit.metric, Start(fit.structure, x, value), fit.model, steps, part, options, quick.jacobian(x, here))
        if part is not None:
            part(1.0)
        return replace(more, evaluations=more.evaluations + len(fit.parameters.groups) + 1)

    best = continued(fit.x, 0, fit)
    evaluations = fit.evaluations + best.evaluations
    for turn, place in enumerate(_BEGINNINGS, start=1):
        if not 2.0 * _EXACT < best.error < _NEAR:
            break
        which = weakly_determined(straight(best.jacobian))
        coarse, _ = stand_in(fit.model, fit.parameters, fit.metric, best.discrepancy)
        x = best.x if place is None else pinned(coarse, best.x, [(which, place)])[0].x
        other = continued(x, turn, best)
        evaluations += other.evaluations
        best = min(best, other, key=lambda f: f.error)
    return replace(best, evaluations=evaluations)


def space_mapping_step(
    coarse: Forward,
    discrepancy: np.ndarray,
    discrepancy_slopes: np.ndarray,
    at: np.ndarray,
    radius: float,
    pull: float = FINE,
) -> Solution:
    """Fit of the stand-in plus its `discrepancy` (m,) at coordinates `at` (p,), which changes by `discrepancy_slopes` (m, p), near them."""

    def lacking(y: np.ndarray) -> np.ndarray:
        return discrepancy + discrepancy_slopes @ (y - at)

    def answers(asks: list[Ask]) -> list[np.ndarray]:
        plain = coarse.answers([ask if ask.r is None else Ask(ask.x, ask.r - lacking(ask.x)) for ask in asks])
        return [own + (lacking(ask.x) if ask.r is None else discrepancy_slopes) for ask, own in zip(asks, plain)]

    near = search(at, np.maximum(at - radius, 0.0), np.minimum(at + radius, 1.0), _CORRECTED_STEPS, 1e-5)
    return pulled(coarse.parameters, pull, answers, [near])[0]


def fit_structure(
    measurement: Measurement,
    structure: Structure,
    model: str = DEFAULT_MODEL,
    samples: int = SAMPLES,
    starts: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    options: Mapping = MappingProxyType({}),
) -> Fit:
    """The best stack of one structure: a few steps of the model itself from every place that the stand-in ends in tell which to follow.

    Where that one nearly explains the data and leaves no noise, the others are followed to their ends too.
    `options` as in `corrected`. Raises LaminaError for a model that cannot be fitted.
    """
    require_fittable(model)
    metric = subsampled(measurement, samples, seed)
    _, is_other = stand_in(model, Parameters(structure, measurement.channels), metric)
    if starts is None:
        starts = STARTS if is_other else DIRECT_STARTS
    found = [solution.x for _, solution in rough_fits(metric, [structure], model, starts, np.random.default_rng(seed))]
    places = [x for i, x in enumerate(found) if all(are_apart(x, other) for other in found[:i])] if is_other else found[:1]
    begun: list[Fit] = []
    for i, x in enumerate(places):
        part = share_of(progress, 0.5 * i / len(places), 0.5 * (i + 1) / len(places))
        begun.append(corrected(metric, Start(structure, x), model, _FIRST_STEPS, part, options))
    first, *others = sorted(begun, key=lambda fit: fit.error)
    best = polished(first, share_of(progress, 0.5, 1.0), options)
    evaluations = best.evaluations + sum(fit.evaluations for fit in others)
    for begun_elsewhere in others:
        if not may_be_stuck(best):
            break
        other = polished(begun_elsewhere, options=options)
        evaluations += other.evaluations - begun_elsewhere.evaluations
        best = min(best, other, key=lambda fit: fit.error)
    return replace(best, evaluations=evaluations)


def may_be_stuck(fit: Fit) -> bool:
    """Whether what is left is misfit and no noise, so that another place may be better. Far off, no stack explains the data.

    A model that has no stand-in is fitted from many starts itself.
    """
    if not stand_in(fit.model, fit.parameters, fit.metric)[1]:
        return False
    return _LEAST_MISFIT < fit.error < _EXPLAINED and likeness(fit.metric, fit.residual) > _ALIKE
