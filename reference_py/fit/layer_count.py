# SPDX-License-Identifier: GPL-3.0-or-later
"""How many layers, over which base: the fewest that the data support.

Structures are judged by the Bayesian information criterion (Schwarz 1978, "Estimating the Dimension of a Model"),
n log(error^2) + p log(n). n counts pairs of directions as far as their residuals are independent, since what no stack can
say would ask for ever more layers otherwise. No error counts as less than `MODEL_ERROR`: below the model's own accuracy
there is nothing to explain. Layers are added as long as the criterion falls; the first that it does not ask for is fitted
too, to say what it gains. All that is at the model's quick settings, unless their discrepancy could pass for a layer.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.schema import CONDUCTOR, DIELECTRIC
from . import AUTO
from .certainty import independent_pairs, noise_and_misfit
from .fitting import (
    SAMPLES,
    STARTS,
    Fit,
    Progress,
    Start,
    corrected,
    may_be_stuck,
    nearest,
    polished,
    rough_fits,
    share_of,
    space_mapping_step,
    subsampled,
)
from .forward import CLOUDY_MODEL, DEFAULT_MODEL, MODEL_ERROR, QUICK, require_fittable
from .metric import Metric, percent
from .parameters import BASES, Parameters, Structure
from .readers.measurement import Measurement
from .solve import Solution
from .stand_in import stand_in

DISTRIBUTIONS = DIELECTRIC.parameter("distribution").choices
MOST_LAYERS, LEAST_SAMPLES = 8, 50
_AUTO_LAYERS = 3
# Of fits with a medium that scatters, and the bases that are tried below it.
_CLOUDY_STARTS, _BELOW_CLOUDS = 2, ("lambert", CONDUCTOR.name)
_LOOKED_AT, _LOOK_STEPS, _STARTS, _MORE_STARTS, _ROUGH_STEPS = 2, 1, 3, 2, 12
# Further steps of the best base before counts of layers are compared, and the most of the chosen fit.
_COMPARED_STEPS, _LAST_STEPS = 2, 4
# The discrepancy of quick settings is at most about half of the first, and cannot pass for a gain as large as the second (a part of the error).
_CLEAR_ERROR, _CLEAR_GAIN = 0.05, 0.2
# Bases whose squared rough error is so many times the best's so far are not looked at more closely.
_FAR = 6.0
# Bases whose error is so many times the best's are not looked at under more layers.
_HOPELESS = 1.5
# Part of the cost below which another distribution, judged by the stand-in, is worth a fit.
_BETTER = 0.93
# A fit above this error explains too little to be called one.
UNEXPLAINED = 0.25

Report = Callable[[str], None]


@dataclass(frozen=True)
class Selection:
    """The chosen fit, the best fit of every count of layers that was tried, and why."""

    best: Fit
    tried: tuple[Fit, ...]
    reason: Sentence


def criterion(fit: Fit, against: Fit | None = None) -> float:
    """Bayesian information criterion of a fit, less is better; with the count of independent residuals of `against`."""
    independent = independent_pairs(against or fit)
    return independent * float(np.log(fit.error**2 + MODEL_ERROR**2)) + fit.count * float(np.log(independent))


def supported(more: Fit, less: Fit) -> bool:
    """Whether the data ask for the larger of two fits."""
    return criterion(more) < criterion(less, more)


def preferred(found: Collection[Fit], against: Fit | None = None) -> Fit:
    """The fit of least `criterion`, but a metal only where it gains more than the data's noise and the model's error.

    A metal's colors and edge follow what no stack says better than others do, and would be chosen for plastics.
    """
    best = min(found, key=lambda fit: criterion(fit, against))
    others = [fit for fit in found if fit.structure.base != CONDUCTOR.name]
    if best.structure.base != CONDUCTOR.name or not others:
        return best
    other = min(others, key=lambda fit: criterion(fit, against))
    gain = float(np.sqrt(max(other.error**2 - best.error**2, 0.0)))
    return best if gain > max(noise_and_misfit(best)[0], MODEL_ERROR) else other


def require_choices(layers: int | str, base: str, model: str, samples: int, cloudy: bool = False) -> None:
    """Raise LaminaError for what `select` does not take."""
    require_fittable(model)
    if layers != AUTO and not (isinstance(layers, int) and 0 <= layers <= MOST_LAYERS):
        raise LaminaError("layers {layers!r}: choose {auto} or 0 to {most}", layers=layers, auto=AUTO, most=MOST_LAYERS)
    if base not in (AUTO, *BASES):
        raise LaminaError("unknown base {base!r}; choose {choices}", base=base, choices=", ".join((AUTO, *BASES)))
    if cloudy and (model != CLOUDY_MODEL or layers == 0):
        raise LaminaError(
            "a cloudy layer goes with the model {wanted} and at least one layer, not with {model} and {layers} layers",
            wanted=CLOUDY_MODEL,
            model=model,
            layers=layers,
        )
    if samples < LEAST_SAMPLES:
        raise LaminaError("samples {samples}: choose at least {least}", samples=samples, least=LEAST_SAMPLES)


def select(
    measurement: Measurement,
    layers: int | str = AUTO,
    base: str = AUTO,
    model: str = DEFAULT_MODEL,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Progress | None = None,
    report: Report | None = None,
    cloudy: bool = False,
) -> Selection:
    """Fit a measurement. `layers` and `base` are chosen where they are "auto"; `cloudy` tries a medium that scatters above the base as well, which takes minutes.

    `progress` gets the share that is done, `report` sentences. Raises LaminaError on a bad choice.
    """
    require_choices(layers, base, model, samples, cloudy)
    if len(measurement.f) < LEAST_SAMPLES:
        raise LaminaError(
            "{source}: {pairs} pairs of directions are too few to fit; at least {least}",
            source=measurement.source,
            pairs=len(measurement.f),
            least=LEAST_SAMPLES,
        )
    search = _Search(subsampled(measurement, samples, seed), model, np.random.default_rng(seed))
    say, done = report or (lambda text: None), share_of(progress, 0.0, 0.5 if cloudy else 1.0) or (lambda share: None)
    last = _AUTO_LAYERS if layers == AUTO else layers
    bases = BASES if base == AUTO else (base,)
    # few layers that were not asked for are fitted as well: more are found from them
    tried: list[Fit] = []
    for count in range(last + 1):
        found = search.look(count, bases, layers != AUTO)
        bases = search.promising(count, found, bases)
        best = preferred(found.values(), tried[-1] if tried else None)
        tried.append(_containing(search.closer(best) if layers in (AUTO, count) else best, tried[-1] if tried else None))
        if layers == AUTO and count and not _is_clear(*tried[-2:]):
            tried[-2:] = [search.at_own_settings(fit) for fit in tried[-2:]]
            tried[-1] = _containing(*tried[:-3:-1])
        begun = (count + 1) / (last + 2)
        done(begun)
        say(f"{tried[-1].structure.name}: error {percent(tried[-1].error)}")
        if layers == AUTO and count and not supported(tried[-1], tried[-2]):
            break
    chosen = tried[-1]
    if layers == AUTO and len(tried) > 1 and not supported(tried[-1], tried[-2]):
        chosen = tried[-2]
    best = search.unstuck(polished(search.with_best_surfaces(chosen), share_of(done, begun, 1.0), steps=_LAST_STEPS))
    done(1.0)
    tried = [best if fit is chosen else _containing(fit, best) for fit in tried]
    plain = Selection(best, tuple(tried), _reason(best, tried, layers))
    return search.cloudy(plain, bases if base != AUTO else _BELOW_CLOUDS, share_of(progress, 0.5, 1.0)) if cloudy else plain


def _containing(more: Fit, less: Fit | None) -> Fit:
    """A fit or, where one of a layer less came closer, that one with a layer more that does nothing, as a place to begin."""
    if less is None or less.structure.layers != more.structure.layers - 1 or less.structure.base != more.structure.base:
        return more
    if more.error <= less.error:
        return more
    structure = Structure(more.structure.layers, more.structure.base, (more.structure.distributions[0], *less.structure.distributions))
    parameters = Parameters(structure, less.parameters.channels)
    return replace(more, parameters=parameters, x=parameters.without_effect(less.parameters, less.x), residual=less.residual)


def _is_clear(fewer: Fit, more: Fit) -> bool:
    """Whether quick settings tell if the data support more layers."""
    small = more.error > (1.0 - _CLEAR_GAIN) * fewer.error
    return fewer.error > _CLEAR_ERROR and not (small and supported(more, fewer))


@dataclass
class _Search:
    """Fits of growing structures, each begun from those before."""

    metric: Metric
    model: str
    rng: np.random.Generator

    def __post_init__(self):
        self._by_base: dict[str, Fit] = {}

    def look(self, count: int, bases: tuple[str, ...], contained: bool) -> dict[str, Fit]:
        """Quick fits by base, under `count` layers, of those that the stand-in brings near the data; `contained`: none worse than with a layer less."""
        before, rough = self._by_base, {}
        for base in bases:
            known = []
            if base in before:
                old = before[base]
                known += [(old.parameters, old.x, 0), (old.parameters, old.x, 1)]
            if base == "oren_nayar" and "lambert" in rough:
                structure, solution = rough["lambert"][0]
                known.append((Parameters(structure, self.metric.measurement.channels), solution.x, 0))
            structures = [Structure(count, base, distributions) for distributions in _surfaces(count, base, before.get(base))]
            rough[base] = rough_fits(self.metric, structures, self.model, _MORE_STARTS if known else _STARTS, self.rng, known, _ROUGH_STEPS)
        least = min(found[0][1].cost for found in rough.values())
        self._by_base = {base: self._begun(found) for base, found in rough.items() if found[0][1].cost <= _FAR * least}
        if contained:
            self._by_base = {base: _containing(fit, before.get(base)) for base, fit in self._by_base.items()}
        return self._by_base

    def _begun(self, found: Sequence[tuple[Structure, Solution]]) -> Fit:
        options = QUICK.get(self.model, {})
        start = nearest(self.metric, found, self.model, options, _LOOKED_AT)
        return corrected(self.metric, start, self.model, _LOOK_STEPS, options=options)

    def cloudy(self, plain: Selection, bases: tuple[str, ...], progress: Progress | None) -> Selection:
        """The choice with a medium that scatters above the base, where the data ask for one; else the plain one, and what could not be told."""
        best, found = plain.best, []
        for number, base in enumerate(bases):
            top = best.structure.distributions[0] if best.structure.distributions else DISTRIBUTIONS[0]
            structure = Structure.of(max(best.structure.layers, 1), base, top, cloudy=True)
            known = [(best.parameters, best.x, structure.layers - best.structure.layers)]
            rough = rough_fits(self.metric, [structure], self.model, _CLOUDY_STARTS, self.rng, known)
            found.append(corrected(self.metric, nearest(self.metric, rough, self.model), self.model))
            if progress is not None:
                progress((number + 1) / len(bases))
        clouds = min(found, key=lambda fit: fit.error)
        tried = (*plain.tried, *found)
        errors = {"before": percent(best.error), "after": percent(clouds.error)}
        if supported(clouds, best):
            return Selection(clouds, tried, Sentence("a medium that scatters above the base brings the error from {before} to {after}", **errors))
        reason = Sentence(
            "{reason}; a cloudy layer cannot be told from a plain one by these data: {structure} brings the error from {before} to {after}",
            reason=plain.reason,
            structure=clouds.structure.name,
            **errors,
        )
        return Selection(best, tried, reason)

    def closer(self, fit: Fit) -> Fit:
        """A quick fit continued; more layers begin from it."""
        self._by_base[fit.structure.base] = fit = corrected(
            self.metric, Start(fit.structure, fit.x, fit.value), self.model, _COMPARED_STEPS, options=fit.options
        )
        return fit

    def unstuck(self, fit: Fit) -> Fit:
        """The fit or, where that may be stuck, one from another start that comes nearer even at quick settings."""
        if not may_be_stuck(fit):
            return fit
        found = rough_fits(self.metric, [fit.structure], self.model, STARTS, self.rng)
        starts, options = [Start(fit.structure, solution.x) for _, solution in found], QUICK.get(self.model, {})
        other = min((corrected(self.metric, start, self.model, _LAST_STEPS, options=options) for start in starts), key=lambda each: each.error)
        return polished(other, steps=_LAST_STEPS) if other.error < fit.error else fit

    def at_own_settings(self, fit: Fit) -> Fit:
        """The fit continued at the model's own settings, if it is not one already."""
        return corrected(self.metric, Start(fit.structure, fit.x), self.model, _COMPARED_STEPS) if fit.options else fit

    @staticmethod
    def promising(count: int, found: dict[str, Fit], bases: tuple[str, ...]) -> tuple[str, ...]:
        """The bases worth more layers; without layers nothing is told yet about what would be below them."""
        if not count:
            return bases
        least = min(fit.error for fit in found.values())
        return tuple(base for base in found if found[base].error <= _HOPELESS * least)

    def with_best_surfaces(self, fit: Fit) -> Fit:
        """The fit, or that with another distribution of one surface after the other where that comes closer."""
        if fit.error < 2.0 * MODEL_ERROR:
            return fit
        for i, kind in enumerate(fit.structure.distributions):
            other = tuple(_other(k) if j == i else k for j, k in enumerate(fit.structure.distributions))
            structure = replace(fit.structure, distributions=other)
            coarse, _ = stand_in(self.model, Parameters(structure, fit.parameters.channels), self.metric)
            guess = space_mapping_step(coarse, fit.discrepancy, np.zeros(fit.jacobian.shape), fit.x, 0.3)
            if guess.cost < _BETTER * float(fit.residual @ fit.residual):
                trial = corrected(self.metric, Start(structure, guess.x), self.model, _COMPARED_STEPS, options=fit.options)
                fit = min(fit, trial, key=lambda f: f.error)
        return fit


def _surfaces(count: int, base: str, before: Fit | None) -> list[tuple[str, ...]]:
    """Distributions worth a try: what fewer layers have, with either on top; all alike where nothing is known."""
    alike = [Structure.of(count, base, kind).distributions for kind in DISTRIBUTIONS]
    if before is None or before.structure.layers != count - 1:
        return sorted(set(alike))
    return sorted({(kind, *before.structure.distributions)[: len(alike[0])] for kind in DISTRIBUTIONS})


def _other(kind: str) -> str:
    return next(k for k in DISTRIBUTIONS if k != kind)


def _reason(best: Fit, tried: list[Fit], layers) -> Sentence:
    if layers != AUTO:
        return Sentence("as many layers as asked for")
    more = next((f for f in tried if f.structure.layers == best.structure.layers + 1), None)
    if more is None:
        return Sentence("the most layers that auto tries; choose --layers {layers} for more", layers=best.structure.layers + 1)
    if more.residual is best.residual:
        return Sentence("one more layer gains nothing: it stays at {error}", error=percent(best.error))
    return Sentence(
        "one more layer would bring the error from {before} to {after} with {parameters:+d} parameters: the criterion rises by {change:.0f}",
        before=percent(best.error),
        after=percent(more.error),
        parameters=more.count - best.count,
        change=criterion(more) - criterion(best, more),
    )
