# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `baked`: the truth of a stack, computed once and fitted by few closures at every knot of the view.

Energy is exact at the knots by construction: the fitted weights are scaled to what `adding` says.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.error_measure import worst_share
from ...optics.microfacet import GGX
from ...optics.optical_stack import OpticalStack, rough_surfaces
from ..closure import lobe_f, unit_energy
from ..error_estimate import soft_lights
from ..lobe import GlossyLobe
from ..own_normals import has_own_normals
from ..samples import Views, truth_at
from ..view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes, knot_cosines, middle_cosines
from .base_ramp import reciprocal
from .fit_lobes import LEAST_ALPHA
from .knot_energies import left_over, top_lobe
from .plan import COARSE, STRIDE, Branches, Path, Plan, best_path, continued_path

DEFAULT_GLOSSY, MAX_GLOSSY = 2, 4
# Points of each strategy at a view.
_POINTS = 96
# No lobe is narrower than this share of what a medium scatters: light that leaves it towards grazing is squeezed.
_OF_MEDIUM = 0.4
# A lobe that nowhere carries more than this share of the albedo is left out.
_NEGLIGIBLE = 1e-3
# With one lobe less a path is worth a look where its first error is at most so many times as large.
_CLOSE = 2.0
# Where a known lobe does so many times better than a fitted one in its place, it keeps that place with one lobe more: of 82 stacks one would lose it, for 3 % less error.
_WORTH_ITS_PLACE = 2.2
# Of the energy that is left for the fitted lobes, what they have in every channel before all is scaled.
_LEAST_SHARE = 1e-3

# The least energy of the fitted lobes where they are to be scaled to another.
_LEAST_SAMPLED = 1e-5


@dataclass(frozen=True, eq=False, repr=False)
class Bake:
    """`lobe_set` in tables; `shape_error` (KNOTS,) is its cosine-weighted L1 at each knot, worst channel."""

    lobe_set: TableLobes
    shape_error: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Found:
    """What was fitted: the number of the plan, and its path."""

    plan: int
    path: Path


class Baker:
    """Bakes one stack with ever more lobes; what fewer lobes found is where more begin.

    `truth` is a model with f, albedo and specular_albedo, of three channels or, with weights of as many, more. `progress` is called with the share done; an exception that
    it raises cancels. Where lobes are to be scaled to other energies, `samples` of its f (`samples_of`) do, and the albedo is theirs, which takes no time.
    """

    def __init__(self, stack: Stack, truth, progress: Callable[[float], None] | None = None, samples: Views | None = None):
        self._report = progress or (lambda share: None)
        cosines, surfaces = knot_cosines(), _surfaces(stack)
        # nothing under smooth surfaces is narrower than what media scatter: such a lobe would stand between two points of the truth
        least_alpha = LEAST_ALPHA if rough_surfaces(stack) or not surfaces else _OF_MEDIUM * min(alpha for _, alpha in surfaces)
        self.truth, self._specular = truth, truth.specular_albedo(cosines)
        views = samples_of(stack, truth) if samples is None else samples
        seen = views.of(slice(KNOTS))
        self._albedo = truth.albedo(seen.wo) if samples is None else np.sum(seen.share[..., None] * seen.f, axis=1) + self._specular
        self.stack, self._seen = stack, seen
        # channels that are alike are fitted once
        views, self._channels = _distinct(views)
        self.top = top_lobe(stack)
        known = [None] if self.top is None else [None, self.top]

        def plan(lobe: GlossyLobe | None, base: DiffuseTable | None = None) -> Plan:
            return Plan(lobe, surfaces, views.of(slice(KNOTS)), views.of(slice(KNOTS, None)), least_alpha, base and self._in_distinct_channels(base))

        # samples may have less than the top reflects, and lobes that have nothing together have no shares
        self._rest = [np.maximum(left_over(self._albedo, self._specular, lobe), 0.0 if samples is None else _LEAST_SAMPLED) for lobe in known]
        self._plans, self.plan = [plan(lobe) for lobe in known], plan
        self._top_apart, self._coarse = has_own_normals(stack), views.of(COARSE).thinned(STRIDE)
        self.most_glossy = MAX_GLOSSY if surfaces else 1
        self._own: dict[int, Found] = {}
        self._lit: dict[float, np.ndarray] = {}
        self.is_smooth = not surfaces
        self._report(0.3)

    def bake(self, glossy: int) -> Bake:
        """The best that at most `glossy` glossy lobes and a Lambert lobe do."""
        found = self.path(glossy)
        return Bake(self.lobe_set(found), found.path.mixtures.error)

    def shape_error(self, lobe_set: TableLobes) -> float:
        """The cosine-weighted L1 of a lobe set of the stack over the albedo, worst channel, mean of the knots."""
        seen = self._seen
        f = sum(lobe_f(lobe, seen.wo[:, None], seen.wi) for lobe in lobe_set.lobes(seen.cos_theta_o[:, None]))
        return float(np.mean(worst_share(np.sum(seen.share[..., None] * np.abs(f - seen.f), axis=1), self._albedo)))

    def least_soft_light(self, glossy: int, cosines: np.ndarray, light_deg: float) -> float:
        """What an `ErrorEstimator`'s error in soft light at views (n,) is at least, by what is found at a few knots before fits are made good at every one.

        Bakes of a hundred stacks have 1.18 times as much and more, half of them twice as much; those that are off by 1 to 4 % have at least 1.4 times as much.
        """
        number, branches = self._best_plan(glossy)
        if light_deg not in self._lit:
            self._lit[light_deg] = soft_lights(self._coarse, light_deg)
        sent = np.abs(self._lit[light_deg] @ np.swapaxes(self._plans[number].gaps(branches), 1, 2))
        at_knots = np.mean(np.sum(sent, axis=1), axis=1)
        return float(np.mean(np.interp(cosines, self._coarse.cos_theta_o, at_knots)))

    def path(self, glossy: int, known: bool = False) -> Found:
        """The fits behind `bake`. Only what is `known` of fewer lobes is compared, or all."""
        if glossy not in self._own:
            number, branches = self._best_plan(glossy)
            self._own[glossy] = Found(number, best_path(self._plans[number], branches))
            self._report(0.9)
        found, fewer = self._own[glossy], glossy - 1
        is_close = fewer and self._best_plan(fewer)[1].error < _CLOSE * self._best_plan(glossy)[1].error
        if is_close and (fewer in self._own or not known):
            # more lobes fit each knot better, but may change more between knots
            return min(found, self.path(fewer, known), key=lambda one: one.path.cost)
        return found

    def _best_plan(self, glossy: int) -> tuple[int, Branches]:
        """The number of the plan that does best with at most so many glossy lobes, and its branches."""
        spare = glossy - bool(np.any(self._specular > 0.0))
        free = [spare - (plan.known is not None) for plan in self._plans]
        numbers = [number for number, count in enumerate(free) if count >= 0]
        if self._top_apart and len(numbers) > 1 and free[-1] > 0:
            numbers = numbers[-1:]  # its normal is not that of what comes from below
        elif glossy > 2 and self._best_plan(glossy - 1)[0]:
            numbers = numbers[-1:]  # where the known lobe was worth its place it stays so: of 82 stacks in all
        elif len(numbers) > 1 and free[-1] > 0:
            alone, beside = (plan.branches(free[-1]).error for plan in self._plans)
            numbers = numbers[-1:] if alone > _WORTH_ITS_PLACE * beside else numbers
        trials = [(number, self._plans[number].branches(free[number])) for number in numbers]
        return min(trials, key=lambda trial: trial[1].error) if trials else (0, self._plans[0].branches(0))

    def continued(self, found: Found, wider: Sequence[float] = (1.0,)) -> Found:
        """The fits to this stack's truth that begin at those of a stack much like it, with lobes so many times as wide: the best of these."""
        return replace(found, path=continued_path(self._plans[found.plan], found.path, wider))

    @property
    def known(self) -> tuple[list[GlossyTable], np.ndarray]:
        """The tables that need no fits, of mirrors and of the top, and the energy (KNOTS, c) that is left."""
        return self._known_tables(self.top), self._rest[-1]

    def _known_tables(self, known: GlossyLobe | None) -> list[GlossyTable]:
        tables = []
        if np.any(self._specular > 0.0):
            tables.append(GlossyTable(GGX, self._specular, np.zeros((KNOTS, 3))))
        if known is not None:
            shape = np.tile([known.alpha_x, known.alpha_y, 0.0], (KNOTS, 1))
            tables.append(GlossyTable(known.distribution, np.ones_like(self._albedo), shape, known.fresnel))
        return tables

    def _in_distinct_channels(self, table: DiffuseTable) -> DiffuseTable:
        first = [self._channels.index(place) for place in range(max(self._channels) + 1)]
        return replace(table, weight=table.weight[:, first], ramp=table.ramp[:, first])

    def lobe_set(self, found: Found, keep: tuple[type, ...] = ()) -> TableLobes:
        """The tables of fits. Lobes that carry next to nothing are left out, but those of the kinds `keep`."""
        tables = self._known_tables(self._plans[found.plan].known)
        fitted = self.fitted(found.path, self._rest[found.plan], keep, at_least=not tables)
        # through smooth layers comes the base's light alone
        is_reciprocal = self.is_smooth and isinstance(OpticalStack.of(self.stack).base, DiffuseBase)
        return TableLobes((*tables, *(map(reciprocal, fitted) if is_reciprocal else fitted)))

    def fitted(self, path: Path, rest: np.ndarray, keep: tuple[type, ...], at_least: bool) -> list[GlossyTable | DiffuseTable]:
        """Those of a path, scaled to the energy (KNOTS, c) that they are to have together; the Lambert lobe is the last, and stays where there is to be `at_least` one."""
        distributions, mixtures = path.distributions, path.mixtures
        weights = mixtures.weight[:, self._channels]
        cosines, ones = knot_cosines(), np.ones_like(self._albedo)
        fitted = []
        for i, distribution in enumerate(distributions):
            shape, weight = mixtures.shape[:, i], weights[:, :, i]
            # where a lobe has next to nothing its shape is anything, on the way to which it would send light astray
            seen = np.flatnonzero(np.any(weight > _NEGLIGIBLE * self._albedo, axis=1))
            if len(seen):
                shape = np.stack([np.interp(np.arange(KNOTS), seen, column[seen]) for column in shape.T], axis=-1)
            table = GlossyTable(distribution, weight, np.concatenate([np.exp(shape[:, :2]), shape[:, 2:]], axis=1))
            fitted.append((table, unit_energy(table.lobe(cosines), cosines)[:, :1]))
        fitted.append((DiffuseTable(weights[:, :, -1]), ones[:, :1]))
        seen = [(table, unit) for table, unit in fitted if isinstance(table, keep) or np.any(table.weight * unit > _NEGLIGIBLE * self._albedo)]
        # what is black altogether keeps a lobe, as a shader has to have one
        return _with_energy(seen if seen or not at_least else fitted[-1:], rest)


def _with_energy(fitted: list[tuple[GlossyTable | DiffuseTable, np.ndarray]], rest: np.ndarray) -> list:
    """The fitted tables, scaled to carry `rest` (KNOTS, c) together; each comes with its energy (KNOTS, 1) at weight 1.

    A channel that no lobe was fitted for gets its energy as the others have it.
    """
    usual = [np.mean(table.weight * unit, axis=1, keepdims=True) + 1e-12 for table, unit in fitted]
    floors = [_LEAST_SHARE * rest * share / sum(usual) for share in usual]
    total = sum((table.weight * unit + floor for (table, unit), floor in zip(fitted, floors)), np.zeros_like(rest))
    scale = rest / np.maximum(total, 1e-12)
    return [replace(table, weight=(table.weight + floor / np.maximum(unit, 1e-3)) * scale) for (table, unit), floor in zip(fitted, floors)]


def _distinct(views: Views) -> tuple[Views, list[int]]:
    """The views with each of their channels that are alike but once, and for each channel its place there."""
    kept, places = {}, []
    for channel in np.moveaxis(views.f, -1, 0):
        places.append(kept.setdefault(channel.tobytes(), (len(kept), channel))[0])
    return replace(views, f=np.stack([channel for _, channel in kept.values()], axis=-1)), places


def samples_of(stack: Stack, truth) -> Views:
    """What a `Baker` asks of the truth: f at the knots, and half-way between them."""
    return truth_at(truth, np.concatenate([knot_cosines(), middle_cosines()]), [alpha for _, alpha in _surfaces(stack)], _POINTS)


def _surfaces(stack: Stack) -> list[tuple[str, float]]:
    """(distribution, alpha) of the rough surfaces, or, without any, of what media scatter."""
    return rough_surfaces(stack) or _media(stack)


def _media(stack: Stack) -> list[tuple[str, float]]:
    """(distribution, alpha) of lobes that are about as wide as what media scatter, which fits of a stack without rough surfaces begin with."""
    return [(GGX, float(np.sqrt(1.0 - abs(s.scattering.g)))) for s in OpticalStack.of(stack).interfaces if s.scattering is not None]
