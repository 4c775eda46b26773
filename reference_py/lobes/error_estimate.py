# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a lobe set is from the truth, as a camera would notice it.

The error that is seen is the worse of two: the albedo's at any view, and, on average over the pixels of a ball, that of
the light which soft lights `SOFT_LIGHT_DEG` wide send, wherever they stand. A uniform sky would see the first alone, a point
light the whole L1 distance.
"""

from dataclasses import dataclass

import numpy as np

from ..material.stack import Stack
from ..optics.frame import spherical
from ..optics.optical_stack import rough_surfaces
from .closure import lobe_energy, lobe_f
from .samples import View, truth_at

SOFT_LIGHT_DEG = 40.0
_PIXELS = 8
_RINGS, _AROUND = 9, 12


def ball_cosines() -> np.ndarray:
    """View cosines that split the pixels of a ball evenly."""
    return np.sqrt(1.0 - (np.arange(_PIXELS) + 0.5) / _PIXELS)


@dataclass(frozen=True)
class Errors:
    """Shares of the truth's albedo per view (n,); albedo and shape of the worst channel."""

    albedo: np.ndarray
    soft_light: np.ndarray
    shape: np.ndarray

    @property
    def visible(self) -> float:
        """The error that is seen: the worst view's of albedo, or the views' mean in soft light if that is larger."""
        return float(max(np.max(self.albedo), np.mean(self.soft_light)))


class ErrorEstimator:
    """Knows the truth of one stack at view cosines (n,)."""

    def __init__(self, stack: Stack, truth, cosines: np.ndarray, light_deg: float = SOFT_LIGHT_DEG):
        self._cosines = np.asarray(cosines, float)
        self._views = truth_at(truth, self._cosines, [alpha for _, alpha in rough_surfaces(stack)])
        self._albedo = np.maximum(truth.albedo(np.stack([v.wo for v in self._views])), 1e-9)
        self._lights = [_soft_lights(view, light_deg) for view in self._views]

    def errors(self, lobe_set) -> Errors:
        """Errors of a lobe set of the stack."""
        albedo = np.max(np.abs(sum(lobe_energy(lobe, self._cosines) for lobe in lobe_set.lobes(self._cosines)) - self._albedo) / self._albedo, axis=-1)
        soft, shape = np.zeros(len(self._views)), np.zeros(len(self._views))
        for i, view in enumerate(self._views):
            wo = np.broadcast_to(view.wo, view.wi.shape)
            f = sum(lobe_f(lobe, wo, view.wi) for lobe in lobe_set.lobes(np.full(len(view.wi), view.cos_theta_o)))
            shape[i] = np.max(view.share @ np.abs(f - view.f) / self._albedo[i])
            soft[i] = np.sum(np.abs(self._lights[i] @ (f - view.f))) / np.sum(self._albedo[i])
        return Errors(albedo, soft, shape)


def _soft_lights(view: View, light_deg: float) -> np.ndarray:
    """(lights, q): what each point adds to what each light sends, scaled so that a point's lights sum to its measure."""
    theta = np.arccos(1.0 - (np.arange(_RINGS) + 0.5) / _RINGS)
    phi = 2.0 * np.pi * (np.arange(_AROUND) + 0.5) / _AROUND
    centers = spherical(theta[:, None], phi).reshape(-1, 3)
    inside = np.cos(np.radians(0.5 * light_deg))
    other_half = view.wi * np.array([1.0, -1.0, 1.0])
    lit = 0.5 * ((centers @ view.wi.T > inside).astype(float) + (centers @ other_half.T > inside))
    return lit * view.share / np.maximum(lit.sum(axis=0), 0.5)
