# SPDX-License-Identifier: GPL-3.0-or-later
"""The best mixtures of closures at many views at once, by variable projection (Golub and Pereyra 1973).

Outer: Levenberg-Marquardt over (log alpha_x, log alpha_y, tan(tilt) / sin(theta_o)) of every glossy lobe, with exact derivatives.
Inner: the weights, which enter linearly, by non-negative least squares per channel. Points are weighted by 1 / residual, so that
squares measure the L1 distance. Each view is a problem of its own, with its own damping; arrays have the views first.
"""

from dataclasses import dataclass, fields, replace
from functools import cache

import numpy as np

from ..closure import lobe_f
from ..lobe import GlossyLobe
from ..samples import Views
from ..view_table import DiffuseTable
from .glossy_rates import glossy_rates, glossy_values

# The least alpha that fits of rough surfaces use, and the largest that Cycles takes.
LEAST_ALPHA, _LARGEST_ALPHA = 1e-3, 1.0
_MAX_TILT = 1.5
# Cycles bends a normal back from which the view would be mirrored below this.
_LOWEST_REFLECTION = np.radians(88.0)
# Residuals below this share of f, and of the albedo, count alike.
_FLOOR_OF_F, _FLOOR_OF_ALBEDO = 0.02, 0.001
_HIGH = np.array([np.log(_LARGEST_ALPHA)] * 2 + [_MAX_TILT])
_LONGEST_STEP = 0.7
# A lobe of an alpha below this share of the view's cosine has an energy of nearly 1, of which the points see at least so much where they are close to it.
_NARROW, _SEEN = 0.05, 0.7
_FIRST_DAMPING, _LEAST_DAMPING = 1e-2, 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Mixtures:
    """One mixture for each of V views: `shape` (V, k, 3) of the glossy lobes as the optimiser sees them; `weight` (V, C, k + 1) by
    channel, the last that of a Lambert lobe; `error` (V,)."""

    shape: np.ndarray
    weight: np.ndarray
    error: np.ndarray

    def of(self, chosen) -> "Mixtures":
        """The mixtures that an index chooses."""
        return Mixtures(self.shape[chosen], self.weight[chosen], self.error[chosen])

    def where(self, mask: np.ndarray, other: "Mixtures") -> "Mixtures":
        """These where the mask (V,) is true, and `other` elsewhere."""
        wide = mask[:, None, None]
        return Mixtures(np.where(wide, self.shape, other.shape), np.where(wide, self.weight, other.weight), np.where(mask, self.error, other.error))


@dataclass(frozen=True, eq=False, repr=False)
class ViewFits:
    """Fits mixtures to the truth at V views of Q points in C channels, beside a lobe that is not fitted.

    `wo` is (V, 1, 3), `x`, `y`, `z` (V, Q) are the components of wi, `sin_o` is (V,).
    `truth` and `goal` (V, C, Q) are f with and without that lobe, `share` (V, C, Q) is each point's measure over the albedo,
    `floor` (V, C, Q) the residual that no smaller one outweighs, `low` (V, 1, 3) the least shape.
    """

    wo: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    sin_o: np.ndarray
    truth: np.ndarray
    goal: np.ndarray
    share: np.ndarray
    floor: np.ndarray
    low: np.ndarray

    @classmethod
    def at(cls, views: Views, known: GlossyLobe | None, least_alpha: float, base: DiffuseTable | None = None) -> "ViewFits":
        """Fits beside the lobe `known`, or beside none, and the light of a base, by lobes no narrower than `least_alpha`."""
        wo, sin_o = views.wo[:, None], np.hypot(views.wo[:, 0], views.wo[:, 1])
        truth = np.swapaxes(views.f, 1, 2)
        albedo = np.maximum(truth @ views.share[..., None], 1e-9)
        goal = truth
        if known is not None:
            goal = truth - lobe_f(known, np.broadcast_to(wo, views.wi.shape), views.wi)[..., None, :, 0]
        if base is not None:
            goal = goal - np.swapaxes(lobe_f(base.lobe(views.cos_theta_o[:, None]), wo, views.wi), 1, 2)
        away = np.tan(0.5 * np.maximum(_LOWEST_REFLECTION - np.arccos(views.cos_theta_o), 0.0)) / np.maximum(sin_o, 1e-6)
        narrowest = np.full(len(away), np.log(least_alpha))
        low = np.stack([narrowest, narrowest, -np.minimum(away, _MAX_TILT)], axis=-1)[:, None]
        return cls(
            wo,
            *np.ascontiguousarray(np.moveaxis(views.wi, -1, 0)[:2]),
            np.where(views.share > 0.0, views.wi[..., 2], 1.0),  # what has no measure is to have a number in single precision too
            sin_o,
            *map(np.ascontiguousarray, (truth, goal)),
            views.share[:, None] / albedo,
            np.ascontiguousarray(_FLOOR_OF_F * truth + _FLOOR_OF_ALBEDO * albedo),
            low,
        )

    def of(self, chosen) -> "ViewFits":
        """Fits at the views that an index chooses, which may name one several times."""
        return ViewFits(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def thinned(self, step: int) -> "ViewFits":
        """Fits to every so many points."""
        some = {name: getattr(self, name)[..., ::step] for name in ("x", "y", "z", "truth", "goal", "share", "floor")}
        return replace(self, **{name: np.ascontiguousarray(values) for name, values in some.items()})

    def columns(self, distributions: tuple[str, ...], shape: np.ndarray, dtype: type = np.float64) -> np.ndarray:
        """f (V, k + 1, Q) of lobes of these shapes (V, k, 3) and weight 1, computed in this precision, and of the Lambert lobe."""
        result, directions = np.empty((len(shape), len(distributions) + 1, self.x.shape[1])), self._directions(dtype)
        for distribution, places in _alike(distributions):
            result[:, places] = glossy_values(distribution, *self._parameters(shape[:, places], dtype), *directions)
        result[:, -1] = 1.0 / np.pi
        return result

    def fit(self, distributions: tuple[str, ...], start: np.ndarray, iterations: int) -> Mixtures:
        """The best mixtures that are found from `start` (V, k, 3).

        The search has lobes in single precision and sums in double: single does not solve the equations of three lobes that are much alike.
        What it finds is judged in double.
        """
        shape = np.clip(start, self.low, _HIGH)
        if iterations and distributions:
            return self._with_energy(distributions, self._searched(distributions, shape, iterations))
        columns = self.columns(distributions, shape)
        weight = non_negative(*self._moments(columns, self._point_weights(0.1 * self.truth)))
        return self._with_energy(distributions, Mixtures(shape, weight, np.zeros(len(shape))), columns)

    def _searched(self, distributions: tuple[str, ...], shape: np.ndarray, iterations: int) -> Mixtures:
        """The mixtures of least distance that steps from `shape` (V, k, 3) come by."""
        slopes, directions = 3 * len(distributions), self._directions(np.float32)
        rows = self._rows(distributions, shape, directions)
        weight = non_negative(*self._moments(rows[:, slopes:], self._point_weights(0.1 * self.truth)))
        best, distances = self._mixtures(shape, rows[:, slopes:], weight)
        damping = np.full(len(shape), _FIRST_DAMPING)
        for left in reversed(range(iterations)):
            weights = self._point_weights(distances)
            gram, moments = self._moments(rows, weights)
            weight = non_negative(gram[:, :, slopes:, slopes:], moments[:, :, slopes:])
            step = _gauss_newton_step(gram, moments, weight, damping)
            step = np.minimum(np.maximum(step, -_LONGEST_STEP), _LONGEST_STEP)
            trial = np.minimum(np.maximum(shape + step, self.low), _HIGH)
            before = _gained(moments[:, :, slopes:], weight)
            if left:
                trial_rows = self._rows(distributions, trial, directions)
            else:  # nobody asks for derivatives any more
                trial_rows, rows, slopes = self.columns(distributions, trial, np.float32), rows[:, slopes:], 0
            trial_gram, trial_moments = self._moments(trial_rows[:, slopes:], weights)
            trial_weight = non_negative(trial_gram, trial_moments)
            worse = _gained(trial_moments, trial_weight) <= before
            damping = np.where(worse, 8.0 * damping, np.maximum(0.2 * damping, _LEAST_DAMPING))
            trial[worse], trial_rows[worse], trial_weight[worse] = shape[worse], rows[worse], weight[worse]
            shape, rows, weight = trial, trial_rows, trial_weight
            found, distances = self._mixtures(shape, rows[:, slopes:], weight)
            best = found.where(found.error < best.error, best)
        return best

    def errors(self, columns: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cosine-weighted L1 and energy error (V,) of weights (V, C, k + 1), over the truth's albedo, worst channel."""
        residual = self._residual(columns, weight)
        return np.max(np.sum(self.share * np.abs(residual), axis=2), axis=1), np.max(np.abs(np.sum(self.share * residual, axis=2)), axis=1)

    def unseen(self, shape, weight, columns) -> np.ndarray:
        """What lobes send between the points of the truth, (V,), over the albedo, worst channel: of energy 1 is a lobe that is narrow beside the view's height."""
        cos_o = np.sqrt(np.maximum(1.0 - np.square(self.sin_o), 0.0))
        is_narrow = np.exp(np.max(shape[..., :2], axis=2)) < _NARROW * cos_o[:, None]
        some = np.flatnonzero(np.any(is_narrow, axis=1))
        result = np.zeros(len(shape))
        if len(some):
            energy = np.einsum("vcq,vkq->vck", self.share[some], columns[some])
            missed = np.maximum(_SEEN * energy[..., -1:] - energy[..., :-1], 0.0)
            result[some] = np.max(np.sum(np.where(is_narrow[some, None], weight[some, :, :-1] * missed, 0.0), axis=2), axis=1)
        return result

    def gaps(self, distributions: tuple[str, ...], mixtures: Mixtures) -> np.ndarray:
        """What each point sends too little, over the truth's albedo, (V, C, Q)."""
        return self.share * self._residual(self.columns(distributions, mixtures.shape), mixtures.weight)

    def _directions(self, dtype: type) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
        """wo and wi as `glossy_rates` takes them, with an axis for lobes."""
        wo, wi = (self.wo[..., axis, None] for axis in (0, 2)), (axis[:, None] for axis in (self.x, self.y, self.z))
        return tuple(axis.astype(dtype) for axis in wo), tuple(axis.astype(dtype, copy=False) for axis in wi)

    def _parameters(self, shape: np.ndarray, dtype: type) -> tuple[np.ndarray, ...]:
        """alpha_x, alpha_y and tilt, each (V, k, 1), of lobes' shapes (V, k, 3)."""
        parameters = np.exp(shape[..., :1]), np.exp(shape[..., 1:2]), np.arctan(shape[..., 2:] * self.sin_o[:, None, None])
        return tuple(values.astype(dtype, copy=False) for values in parameters)

    def _rows(self, distributions: tuple[str, ...], shape: np.ndarray, directions: tuple) -> np.ndarray:
        """(V, 4 k + 1, Q): the derivatives of the lobes by their shapes, and their columns, in single precision."""
        views, lobes = len(shape), len(distributions)
        result = np.empty((views, 4 * lobes + 1, self.x.shape[1]))
        rates, values = result[:, : 3 * lobes].reshape(views, lobes, 3, -1), result[:, 3 * lobes : -1]
        for distribution, places in _alike(distributions):
            values[:, places], *found = glossy_rates(distribution, *self._parameters(shape[:, places], np.float32), *directions)
            for j, rate in enumerate(found):
                rates[:, places, j] = rate
        rates[:, :, 2] *= (self.sin_o[:, None] / (1.0 + np.square(shape[:, :, 2] * self.sin_o[:, None])))[..., None]
        result[:, -1] = 1.0 / np.pi
        return result

    def _with_energy(self, distributions: tuple[str, ...], found: Mixtures, columns: np.ndarray | None = None) -> Mixtures:
        """With weights scaled to the energy of the goal, as tables are, and errors of these; `columns` are those of the lobes, if they are known."""
        columns = self.columns(distributions, found.shape) if columns is None else columns
        energy, wanted = (np.sum(self.share * f, axis=2) for f in (found.weight @ columns, self.goal))
        scale = np.where(energy > 1e-6, np.maximum(wanted, 0.0) / np.maximum(energy, 1e-6), 1.0)
        weight = found.weight * scale[..., None]
        return Mixtures(found.shape, weight, self.errors(columns, weight)[0] + self.unseen(found.shape, weight, columns))

    def _mixtures(self, shape, columns, weight) -> tuple[Mixtures, np.ndarray]:
        """The mixtures, and what is left of the goal at each point (V, C, Q), without sign."""
        distances = np.abs(self._residual(columns, weight))
        return Mixtures(shape.copy(), weight.copy(), np.max(np.einsum("vcq,vcq->vc", self.share, distances), axis=1)), distances

    def _residual(self, columns, weight):
        return self.goal - weight @ columns

    def _point_weights(self, distances) -> np.ndarray:
        return self.share / np.maximum(distances, self.floor)

    def _moments(self, rows, weights) -> tuple[np.ndarray, np.ndarray]:
        """Weighted products of the rows with each other (V, C, r, r), and with the goal (V, C, r)."""
        across = np.swapaxes(rows, 1, 2)
        gram = np.empty((*weights.shape[:2], rows.shape[1], rows.shape[1]))
        for channel in range(weights.shape[1]):
            np.matmul(rows * weights[:, channel, None], across, out=gram[:, channel])
        return gram, (weights * self.goal) @ across


@cache
def _alike(distributions: tuple[str, ...]) -> tuple[tuple[str, list[int] | slice], ...]:
    """Each distribution and the places of its lobes."""
    if len(set(distributions)) == 1:
        return ((distributions[0], slice(None, len(distributions))),)
    return tuple((one, [i for i, other in enumerate(distributions) if other == one]) for one in dict.fromkeys(distributions))


def _gained(moments, weight) -> np.ndarray:
    """By how much weights (V, C, k + 1) of `non_negative` lower the weighted sums (V,) of squares of what is left of the goal."""
    return np.sum(weight * moments, axis=(1, 2))


def _gauss_newton_step(gram, moments, weight, damping) -> np.ndarray:
    """(V, k, 3): Gauss-Newton's for the shapes, the weights' part projected out (Kaufman 1975), damped."""
    lobes = weight.shape[2] - 1
    size = 3 * lobes
    used = weight > 0.0
    scale = np.repeat(weight[..., :lobes], 3, axis=2)
    among = np.where(used[..., None] & used[..., None, :], gram[:, :, size:, size:], np.eye(lobes + 1))
    across = np.where(used[..., None], gram[:, :, size:, :size], 0.0)
    projected = gram[:, :, :size, :size] - np.swapaxes(across, 2, 3) @ _solve(among, across)
    hessian = np.sum(scale[..., None] * projected * scale[..., None, :], axis=1)
    slope = moments[:, :, :size] - (gram[:, :, :size, size:] @ weight[..., None])[..., 0]
    gradient = np.sum(scale * slope, axis=1)
    diagonal = np.einsum("vii->vi", hessian)  # a view
    diagonal += damping[:, None] * (diagonal + 1e-9)
    return np.linalg.solve(hessian, gradient[..., None]).reshape(len(weight), lobes, 3)


def _solve(gram, right) -> np.ndarray:
    """Solutions for gram matrices (..., m, m), of which columns may be alike."""
    lifted = gram.copy()
    diagonal = np.einsum("...ii->...i", lifted)  # a view
    diagonal += 1e-12 * np.einsum("...ii->...", gram)[..., None]
    return np.linalg.solve(lifted, right)


def non_negative(gram: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Minimisers c >= 0 (..., m) of c G c - 2 b c for gram G (..., m, m) and moments b (..., m): the best of every active set's."""
    count = moments.shape[-1]
    if count == 2:
        return _of_two(gram, moments)
    on, both_on, off = _active_sets(count)
    b = moments.reshape(-1, count).T[:, None]
    c = _eliminated(gram.reshape(-1, count, count).transpose(1, 2, 0)[:, :, None] * both_on, b * on, off)
    # at a minimiser c G c is b c
    value = np.where(np.all(c >= 0.0, axis=0), np.sum(b * c, axis=0), -np.inf)
    return c[:, np.argmax(value, axis=0), np.arange(value.shape[-1])].T.reshape(moments.shape)


def _of_two(gram, moments) -> np.ndarray:
    """`non_negative` of two, by Cramer's rule: one lobe and a Lambert lobe are fitted most often."""
    a, b, d, p, q = gram[..., 0, 0], gram[..., 0, 1], gram[..., 1, 1], moments[..., 0], moments[..., 1]
    shift = 1e-12 * (a + d)
    a, d = a + shift, d + shift
    least = a * d - b * b
    both = (d * p - b * q) / least, (a * q - b * p) / least
    alone = np.maximum(p, 0.0) / a, np.maximum(q, 0.0) / d
    is_first = p * alone[0] >= q * alone[1]
    is_free = (both[0] >= 0.0) & (both[1] >= 0.0)
    c = np.empty(moments.shape)
    c[..., 0] = np.where(is_free, both[0], alone[0] * is_first)
    c[..., 1] = np.where(is_free, both[1], alone[1] * ~is_first)
    return c


@cache
def _active_sets(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where each set has a row (count, sets, 1), a row and a column (count, count, sets, 1), and no row; not to be written to."""
    on = ((np.arange(2**count) >> np.arange(count)[:, None]) & 1).astype(float)[..., None]
    return on, on[:, None] * on, 1.0 - on


def _eliminated(a, b, off) -> np.ndarray:
    """Solutions (m, ...) of systems a (m, m, ...) and b (m, ...) as `_solve` has them, of which rows and columns `off` (m, ...) are those of 1. Overwrites both.

    Of so small ones all at once take a third of LAPACK's time, which solves one after another.
    """
    rows = range(len(b))
    for i in rows:
        a[i, i] += off[i]
    shift = 1e-12 * sum(a[i, i] for i in rows)
    for i in rows:
        a[i, i] += shift
    for i in rows[:-1]:
        share = a[i + 1 :, i] / a[i, i]
        a[i + 1 :, i + 1 :] -= share[:, None] * a[i, i + 1 :]
        b[i + 1 :] -= share * b[i]
    for i in reversed(rows):
        if i < rows[-1]:
            b[i] -= sum(a[i, k] * b[k] for k in rows[i + 1 :])
        b[i] /= a[i, i]
    return b
