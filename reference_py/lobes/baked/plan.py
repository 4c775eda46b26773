# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits at every knot of the view that change slowly along it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from ..lobe import GlossyLobe
from ..samples import Views
from ..view_table import KNOTS, DiffuseTable
from .fit_lobes import Mixtures, ViewFits

# Starts are tried at these knots, and branches filled in from them.
COARSE = np.array([0, 4, 8, 12, 16, 20, 23])
_NEAREST = np.argmin(np.abs(np.arange(KNOTS)[:, None] - COARSE), axis=1)
# Trials look at every so many points.
STRIDE = 2
# Of each coarse knot its neighbours, and how often fits begin at what these found.
_BEFORE, _AFTER, _PASSES = np.maximum(np.arange(len(COARSE)) - 1, 0), np.minimum(np.arange(len(COARSE)) + 1, len(COARSE) - 1), 2
# Steps of a trial, of the best half of the trials, of a branch at every knot, and of fits to a truth much like the one before.
_TRIAL, _MORE, _FILL, _CONTINUED = 5, 8, 5, 5
# How often knots of a path begin anew between their neighbours: one pass leaves gold by three lobes a jump of 4 %.
_SMOOTHED = 2
# Between two knots a path jumps where its error is so many times as large as those at both together; knots that begin anew on either side of it, and
# how often what is left of it is looked at: with lobes that are much alike it moves along the view until it is small.
_JUMP, _MENDED, _MENDS = 4.0, 4, 4
# Branches that a path may take.
_BRANCHES = 3
# Widths that starts are chosen from.
_WIDTHS = 5
# A wrong energy between knots weighs so much more than a wrong shape. Errors of these sizes count twice, as eyes see the worst view.
_ENERGY_COUNTS, _ENERGY_HURTS, _SHAPE_HURTS = 3.0, 0.0015, 0.15


@dataclass(frozen=True, eq=False, repr=False)
class Branches:
    """Mixtures of lobes of `distributions` at the coarse knots, the best branch first, and their mean error where each is the best."""

    distributions: tuple[str, ...]
    mixtures: tuple[Mixtures, ...]

    @property
    def error(self) -> float:
        """Mean over the coarse knots, at each that of the best branch."""
        return float(np.mean(np.min([branch.error for branch in self.mixtures], axis=0)))


class Fitter:
    """Fits at some views, which remembers what each start led to: passes along the view try most of them again."""

    def __init__(self, fits: ViewFits):
        self.fits = fits
        self._found: dict[tuple, tuple] = {}

    def __call__(self, distributions: tuple[str, ...], starts: list[np.ndarray], iterations: int) -> list[Mixtures]:
        """What is found from each of some starts (V, k, 3)."""
        views, every = len(self.fits.sin_o), np.concatenate(starts)
        keys = [(distributions, iterations, i % views, start.tobytes()) for i, start in enumerate(every)]
        new = {key: i for i, key in enumerate(keys) if key not in self._found}
        if new:
            chosen = np.array(list(new.values()))
            found = self.fits.of(chosen % views).fit(distributions, every[chosen], iterations)
            self._found |= zip(new, zip(found.shape, found.weight, found.error))
        all_ = Mixtures(*(np.stack(values) for values in zip(*(self._found[key] for key in keys))))
        return [all_.of(slice(i, i + views)) for i in range(0, len(every), views)]


class Plan:
    """Fits beside one known lobe, or none, by lobes no narrower than `least_alpha`. `views` are at the knots, `middles` half-way between them.

    `base` is the light of a base, with its ramp, of which fits are to have nothing, in the channels of the views.
    """

    def __init__(
        self,
        known: GlossyLobe | None,
        surfaces: list[tuple[str, float]],
        views: Views,
        middles: Views,
        least_alpha: float,
        base: DiffuseTable | None = None,
    ):
        self.known = known
        self._distributions = sorted({distribution for distribution, _ in surfaces})
        self._alphas = _widths(surfaces)
        self.fits, self.middles = (ViewFits.at(some, known, least_alpha, base) for some in (views, middles))
        self.fitted, self._coarse_fitted = Fitter(self.fits), Fitter(self.fits.of(COARSE).thinned(STRIDE))
        self._found: dict[int, Branches] = {}

    def branches(self, free: int) -> Branches:
        """The best branches of `free` fitted glossy lobes; none where the stack has no rough surface.

        A wide lobe for how a smooth coat shapes the light of paint was tried: its mean error fell from 5.5 to 4.7 %, its
        worst view's did not, and a picture of it came out no closer.
        """
        free = free if self._distributions else 0
        if free not in self._found:
            fewer = self.branches(free - 1) if free else None
            distributions = [(*fewer.distributions, distribution) for distribution in self._distributions] if fewer else [()]
            trials = [(k, self._trials(k, fewer)) for k in distributions]
            self._found[free] = self._continued(*min(trials, key=lambda trial: float(np.mean(trial[1][0].error))))
        return self._found[free]

    def gaps(self, branches: Branches) -> np.ndarray:
        """What each of the points that trials look at, at the coarse knots, sends too little of the albedo by the best of all branches, (coarse, C, Q)."""
        return self._coarse_fitted.fits.gaps(branches.distributions, branches.mixtures[0])

    def _trials(self, distributions: tuple[str, ...], fewer: Branches | None) -> list[Mixtures]:
        """A few steps from all starts at the coarse knots; the best half of them."""
        starts = self._starts(fewer) if fewer else [np.zeros((len(COARSE), 0, 3))]
        return _best(self._coarse_fitted(distributions, starts, _TRIAL), max(len(starts) // 2, _BRANCHES))

    def _continued(self, distributions: tuple[str, ...], trials: list[Mixtures]) -> Branches:
        """The branches that trials lead to; then each knot begins at what its neighbours found."""
        if distributions:
            trials = _best(self._coarse_fitted(distributions, [trial.shape for trial in trials], _MORE), _BRANCHES)
            for _ in range(_PASSES):
                best = trials[0].shape
                trials = _best(trials + self._coarse_fitted(distributions, [best[_BEFORE], best[_AFTER]], _MORE), _BRANCHES)
        return Branches(distributions, tuple(_in_order(distributions, trials)))

    def _starts(self, fewer: Branches) -> list[np.ndarray]:
        """Shapes (coarse, k, 3) to start from: one more lobe beside what fewer found, and for two also every pair of widths.

        Of different ones: two lobes that are alike take every step together.
        """
        lobes = [np.array([[np.log(a), np.log(a), 0.0]]) for a in self._alphas]
        every = (len(COARSE), 1, 1)
        starts = [np.concatenate([branch.shape, np.tile(lobe, every)], axis=1) for branch in fewer.mixtures[:1] for lobe in lobes]
        if len(fewer.distributions) == 1:
            starts += [np.tile(np.concatenate([a, b]), every) for i, a in enumerate(lobes) for b in lobes[i + 1 :]]
        return starts


def _best(trials: list[Mixtures], count: int) -> list[Mixtures]:
    """The trials of least mean error; the first is at every knot the best of all."""
    order = sorted(trials, key=lambda trial: float(np.mean(trial.error)))
    mixed = order[0]
    for trial in order[1:]:
        mixed = trial.where(trial.error < mixed.error, mixed)
    return [mixed, *order[: count - 1]] if len(order) > 1 else order


def _in_order(distributions: tuple[str, ...], branches: list[Mixtures]) -> list[Mixtures]:
    """The branches with their lobes in an order that tables may interpolate: along the first from the normal on, and at each knot as there."""
    first = branches[0]
    parts = [first.of(slice(-1, None))]
    for k in reversed(range(len(first.error) - 1)):
        parts.append(_in_order_of(distributions, parts[-1], first.of(slice(k, k + 1))))
    first = Mixtures(*(np.concatenate(values) for values in zip(*((m.shape, m.weight, m.error) for m in reversed(parts)))))
    return [first, *(_in_order_of(distributions, first, branch) for branch in branches[1:])]


def _in_order_of(distributions: tuple[str, ...], other: Mixtures, mixtures: Mixtures) -> Mixtures:
    """Mixtures with their lobes in whichever order is nearest to the other ones at each view, lobes of little weight last."""
    orders = [order for order in permutations(range(len(distributions))) if all(distributions[i] == distributions[j] for i, j in enumerate(order))]
    weight, other_weight = mixtures.weight.mean(axis=1), other.weight.mean(axis=1)

    def distance(order) -> np.ndarray:
        apart = np.sum(np.abs(mixtures.shape[:, order] - other.shape), axis=2)
        mine, its = weight[:, order], other_weight[:, :-1]
        return np.sum(np.abs(mine - its) + apart * np.minimum(mine, its), axis=1)

    best = np.array(orders, dtype=int)[np.argmin([distance(np.array(order, dtype=int)) for order in orders], axis=0)]
    views = np.arange(len(best))[:, None]
    shares = np.concatenate([best, np.full((len(best), 1), len(distributions))], axis=1)
    return Mixtures(
        mixtures.shape[views, best], mixtures.weight[views[..., None], np.arange(mixtures.weight.shape[1])[:, None], shares[:, None]], mixtures.error
    )


def _widths(surfaces: list[tuple[str, float]]) -> list[float]:
    """Alphas of the surfaces and of what pairs of them blur to, at most `_WIDTHS`."""
    alphas = {alpha for _, alpha in surfaces}
    alphas |= {min(1.0, float(np.hypot(a, b))) for a in alphas for b in alphas}
    chosen = sorted(alphas)
    return chosen if len(chosen) <= _WIDTHS else list(np.geomspace(chosen[0], chosen[-1], _WIDTHS))


@dataclass(frozen=True, eq=False, repr=False)
class Path:
    """One mixture per knot and its errors at the knots, and, as a table interpolates it, between them."""

    distributions: tuple[str, ...]
    mixtures: Mixtures
    cost: float


def best_path(plan: Plan, found: Branches) -> Path:
    """Mixtures of whichever branch, or of fits that begin between their neighbours on the best path: least sum of errors."""
    branches = plan.fitted(found.distributions, [branch.shape[_NEAREST] for branch in found.mixtures], _FILL)
    return _settled(plan, _joined(plan, found.distributions, branches))


def _settled(plan: Plan, path: Path) -> Path:
    """The path with fits that begin between their neighbours, and without its jumps, as far as it gets better."""
    for _ in range(_SMOOTHED if path.distributions else 0):
        ends = np.concatenate([path.mixtures.shape[1:2], path.mixtures.shape, path.mixtures.shape[-2:-1]])
        between = plan.fitted(path.distributions, [0.5 * (ends[:-2] + ends[2:])], _FILL)
        path = _joined(plan, path.distributions, [path.mixtures, *between])
    for _ in range(_MENDS):
        mended = _mended(plan, path)
        if mended.cost >= path.cost:
            break
        path = mended
    return path


def _mended(plan: Plan, path: Path) -> Path:
    """The path without its jumps, if knots to either side of one that begin one after the other, each where the one before ended, are better."""
    knots, felt = path.mixtures, _felt(path.mixtures.error)
    between = _half_way(plan.middles, path.distributions, knots.of(slice(0, -1)), knots.of(slice(1, None)))
    # where the view grazes there is little light to be wrong about
    jumps = np.flatnonzero(between[1:] > _JUMP * (felt[1:-1] + felt[2:])) + 1
    if not len(jumps):
        return path
    sides = [Mixtures(knots.shape.copy(), knots.weight.copy(), knots.error.copy()) for _ in range(2)]
    for step in range(_MENDED):
        # both sides at once: fits of few views take nearly as long as those of twice as many
        ats = [at[(at >= 0) & (at < KNOTS)] for at in (jumps - step, jumps + 1 + step)]
        starts = [side.shape[at + before] for side, at, before in zip(sides, ats, (1, -1))]
        found = plan.fits.of(np.concatenate(ats)).fit(path.distributions, np.concatenate(starts), _FILL)
        for side, at, own in zip(sides, ats, (slice(None, len(ats[0])), slice(len(ats[0]), None))):
            side.shape[at], side.weight[at], side.error[at] = found.shape[own], found.weight[own], found.error[own]
    return _joined(plan, path.distributions, [knots, *sides])


def _joined(plan: Plan, distributions: tuple[str, ...], branches: list[Mixtures]) -> Path:
    """The path over the branches of least sum of the errors at the knots and between them."""
    joined = _symmetric_at_normal(plan, distributions, branches)
    errors = _felt(joined.error).reshape(len(branches), KNOTS)
    between = _between(plan, distributions, joined)
    cost, came_from = errors[:, 0], []
    for k in range(KNOTS - 1):
        through = cost[:, None] + between[:, :, k]
        came_from.append(np.argmin(through, axis=0))
        cost = np.min(through, axis=0) + errors[:, k + 1]
    at = int(np.argmin(cost))
    path = [at]
    for previous in reversed(came_from):
        at = int(previous[at])
        path.append(at)
    chosen = np.array(path[::-1]) * KNOTS + np.arange(KNOTS)
    return Path(distributions, joined.of(chosen), float(np.min(cost)))


def _between(plan: Plan, distributions: tuple[str, ...], joined: Mixtures) -> np.ndarray:
    """Errors (B, B, KNOTS - 1) between the knots of B branches one after the other, from the first's to the second's."""
    count, cells = len(joined.error) // KNOTS, KNOTS - 1
    found = np.concatenate([joined.shape.reshape(count, KNOTS, -1), joined.weight.reshape(count, KNOTS, -1)], axis=2)
    # branches have much in common, which is looked at once
    first = np.argmax(np.all(found[:, None] == found, axis=-1), axis=1)
    pairs = (first[:, None, :-1] * count + first[:, 1:]) * cells + np.arange(cells)
    distinct, place = np.unique(pairs, return_inverse=True)
    left, right, cell = distinct // (count * cells), distinct // cells % count, distinct % cells
    errors = _half_way(plan.middles.of(cell), distributions, joined.of(left * KNOTS + cell), joined.of(right * KNOTS + cell + 1))
    return errors[place].reshape(pairs.shape)


def continued_path(plan: Plan, path: Path, wider: Sequence[float] = (1.0,)) -> Path:
    """The path to another truth that is much like the one it was found for: every fit begins where the other ended, with lobes so many times as wide.

    Of several such widths the path is taken that changes least along the view.
    """
    found = [plan.fits.fit(path.distributions, path.mixtures.shape + np.log([ratio, ratio, 1.0]), _CONTINUED) for ratio in wider]
    if len(found) > 1:
        return _settled(plan, _joined(plan, path.distributions, found))
    mixtures = _symmetric_at_normal(plan, path.distributions, found)
    return Path(path.distributions, mixtures, float(np.sum(mixtures.error)))


def _symmetric_at_normal(plan: Plan, distributions: tuple[str, ...], branches: list[Mixtures]) -> Mixtures:
    """Branches one after the other, the last mixture of each made symmetric, from its own shape or its neighbour's, whichever suits both.

    At the normal no direction is along the plane of incidence, and a tilt has no effect there: the neighbour's stays.
    """
    joined = Mixtures(*(np.concatenate([getattr(branch, name) for branch in branches]) for name in ("shape", "weight", "error")))
    last = np.arange(1, len(branches) + 1) * KNOTS - 1
    shape = joined.shape[np.stack([last - 1, last], axis=1).ravel()]
    alpha = np.mean(shape[:, :, :2], axis=2, keepdims=True)
    tilt = np.repeat(joined.shape[last - 1, :, 2:], 2, axis=0)
    tried = plan.fits.of(np.full(len(shape), KNOTS - 1)).fit(distributions, np.concatenate([alpha, alpha, tilt], axis=2), 0)
    neighbours = joined.of(np.repeat(last - 1, 2))
    cost = tried.error + _half_way(plan.middles.of(np.full(len(shape), KNOTS - 2)), distributions, neighbours, tried)
    best = tried.of(2 * np.arange(len(branches)) + np.argmin(cost.reshape(-1, 2), axis=1))
    for name in ("shape", "weight", "error"):
        getattr(joined, name)[last] = getattr(best, name)
    return joined


def _half_way(middles: ViewFits, distributions: tuple[str, ...], left: Mixtures, right: Mixtures) -> np.ndarray:
    """Errors (V,) of what a table makes of neighbouring mixtures between them, where a wrong energy counts more than a wrong shape."""
    widths = np.log(0.5 * (np.exp(left.shape[..., :2]) + np.exp(right.shape[..., :2])))
    shape = np.concatenate([widths, 0.5 * (left.shape[..., 2:] + right.shape[..., 2:])], axis=2)
    columns, weight = middles.columns(distributions, shape, np.float32), 0.5 * (left.weight + right.weight)
    distance, energy = middles.errors(columns, weight)
    return _felt(distance + middles.unseen(shape, weight, columns)) + _ENERGY_COUNTS * energy * (1.0 + energy / _ENERGY_HURTS)


def _felt(error: np.ndarray) -> np.ndarray:
    """What an error of shape counts."""
    return error * (1.0 + error / _SHAPE_HURTS)
