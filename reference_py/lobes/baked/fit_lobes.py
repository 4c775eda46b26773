# SPDX-License-Identifier: GPL-3.0-or-later
"""The best mixture of closures at one view, by variable projection (Golub and Pereyra 1973).

Outer: Levenberg-Marquardt over (log alpha_x, log alpha_y, tan(tilt) / sin(theta_o)) of every glossy lobe. Inner: the
weights, which enter linearly, by non-negative least squares per channel. Points are weighted by 1 / residual, so that
squares measure the L1 distance.
"""

from dataclasses import dataclass

import numpy as np

from ..closure import unit_glossy
from ..samples import View

ITERATIONS = 12
# Cycles takes no alpha above 1.
_ALPHA_RANGE = (1e-3, 1.0)
_MAX_TILT = 1.5
# Cycles bends a normal back from which the view would be mirrored below this.
_LOWEST_MIRROR = np.radians(88.0)
# Residuals below this share of f, and of the albedo, count alike.
_FLOOR_OF_F, _FLOOR_OF_ALBEDO = 0.02, 0.001
_STEP, _LONGEST_STEP = 1e-3, 0.7


@dataclass(frozen=True)
class Mixture:
    """`shape` (k, 3) of the glossy lobes as the optimiser sees them; `weight` (3, k + 1), the last that of a Lambert lobe."""

    shape: np.ndarray
    weight: np.ndarray
    error: float


class ViewFit:
    """Fits mixtures to the truth at one view, beside lobes `known` (q, 3) that are not fitted."""

    def __init__(self, view: View, known: np.ndarray):
        self.view = view
        self._albedo = np.maximum(view.share @ view.f, 1e-9)
        self._goal = view.f - known
        self._floor = _FLOOR_OF_F * view.f + _FLOOR_OF_ALBEDO * self._albedo
        self._sin_o = np.sqrt(max(1.0 - view.cos_theta_o**2, 0.0))
        away = np.tan(0.5 * max(_LOWEST_MIRROR - np.arccos(view.cos_theta_o), 0.0)) / max(self._sin_o, 1e-6)
        self._low = np.array([np.log(_ALPHA_RANGE[0])] * 2 + [-min(away, _MAX_TILT)])
        self._high = np.array([np.log(_ALPHA_RANGE[1])] * 2 + [_MAX_TILT])

    def lobe(self, kind: str, shape: np.ndarray) -> np.ndarray:
        """f (q,) of one glossy lobe of weight 1."""
        alpha_x, alpha_y = np.exp(shape[:2])
        tilt = np.arctan(shape[2] * self._sin_o)
        return unit_glossy(kind, alpha_x, alpha_y, tilt, self.view.wo, self.view.wi)[0]

    def columns(self, kinds: tuple[str, ...], shape: np.ndarray) -> np.ndarray:
        """f (k + 1, q) of the lobes of weight 1."""
        lobes = [self.lobe(kind, s) for kind, s in zip(kinds, shape)]
        return np.stack([*lobes, np.full(len(self.view.wi), 1.0 / np.pi)])

    def fit(self, kinds: tuple[str, ...], start: np.ndarray, iterations: int = ITERATIONS) -> Mixture:
        """The best mixture that is found from `start` (k, 3)."""
        shape = np.clip(np.array(start, float), self._low, self._high)
        columns = self.columns(kinds, shape)
        c = self._solve(columns, self._point_weights(0.1 * self.view.f))
        best = self._mixture(shape, columns, c)
        damping = 1e-2
        for _ in range(iterations):
            weights = self._point_weights(self._residual(columns, c))
            c = self._solve(columns, weights)
            hessian, gradient = self._normal_equations(kinds, shape, columns, c, weights)
            before = np.sum(weights * np.square(self._residual(columns, c)))
            for _ in range(6):
                step = -np.linalg.solve(hessian + damping * np.diag(np.diag(hessian) + 1e-9), gradient)
                trial = np.clip(shape + np.clip(step.reshape(shape.shape), -_LONGEST_STEP, _LONGEST_STEP), self._low, self._high)
                trial_columns = self.columns(kinds, trial)
                trial_c = self._solve(trial_columns, weights)
                if np.sum(weights * np.square(self._residual(trial_columns, trial_c))) < before:
                    break
                damping *= 6.0
            else:
                break
            damping = max(0.2 * damping, 1e-6)
            shape, columns, c = trial, trial_columns, trial_c
            mixture = self._mixture(shape, columns, c)
            if mixture.error < best.error:
                best = mixture
        return best

    def errors(self, columns: np.ndarray, c: np.ndarray) -> tuple[float, float]:
        """Cosine-weighted L1 and energy error of weights c (3, k + 1), over the truth's albedo, worst channel."""
        residual = self._residual(columns, c)
        distance, energy = self.view.share @ np.abs(residual), np.abs(self.view.share @ residual)
        return float(np.max(distance / self._albedo)), float(np.max(energy / self._albedo))

    def _mixture(self, shape, columns, c) -> Mixture:
        return Mixture(shape.copy(), c, self.errors(columns, c)[0])

    def _residual(self, columns, c):
        return self._goal - (c @ columns).T

    def _point_weights(self, residual) -> np.ndarray:
        return self.view.share[:, None] / np.maximum(np.abs(residual), self._floor) / self._albedo

    def _solve(self, columns, weights) -> np.ndarray:
        weighted = columns[None] * weights.T[:, None]
        return non_negative(weighted @ columns.T, np.einsum("cmq,qc->cm", weighted, self._goal))

    def _normal_equations(self, kinds, shape, columns, c, weights):
        """Gauss-Newton's for the shape, the weights' part projected out (Kaufman 1975)."""
        slopes = np.zeros((shape.size, columns.shape[1]))
        for i, j in np.ndindex(shape.shape):
            moved = shape[i].copy()
            moved[j] += _STEP
            slopes[3 * i + j] = (self.lobe(kinds[i], moved) - columns[i]) / _STEP
        hessian, gradient = np.zeros((shape.size,) * 2), np.zeros(shape.size)
        root, residual = np.sqrt(weights), self._residual(columns, c)
        for channel in range(3):
            jacobian = -slopes * np.repeat(c[channel, :-1], 3)[:, None] * root[:, channel]
            used = c[channel] > 0.0
            if used.any():
                q, _ = np.linalg.qr((columns[used] * root[:, channel]).T)
                jacobian -= (jacobian @ q) @ q.T
            hessian += jacobian @ jacobian.T
            gradient += jacobian @ (root[:, channel] * residual[:, channel])
        return hessian, gradient


def non_negative(gram: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Minimiser c >= 0 (3, m) of c G c - 2 b c for gram G (3, m, m) and moments b (3, m), by trying every active set."""
    count = moments.shape[-1]
    on = (np.arange(1, 2**count)[:, None] >> np.arange(count)) & 1 == 1
    identity = np.eye(count)
    ridge = 1e-12 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * identity
    systems = np.where((on[:, :, None] & on[:, None, :])[:, None], gram + ridge, identity)
    c = np.linalg.solve(systems, np.where(on[:, None], moments, 0.0)[..., None])[..., 0]
    value = np.einsum("sci,cij,scj->sc", c, gram, c) - 2.0 * np.sum(moments * c, axis=-1)
    value = np.where(np.all(c >= 0.0, axis=-1), value, 0.0)
    best = np.argmin(value, axis=0)
    channels = np.arange(len(moments))
    return np.where((value[best, channels] < 0.0)[:, None], c[best, channels], 0.0)
