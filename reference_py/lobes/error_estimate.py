# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a lobe set is from the truth, as a camera would notice it.

The error that is seen is the worse of two: the albedo's at any view, and, on average over the pixels of a ball, that of
the light which soft lights `SOFT_LIGHT_DEG` wide send, wherever they stand. A uniform sky would see the first alone, a point
light the whole L1 distance.
"""

from dataclasses import dataclass

import numpy as np

from ..material.stack import Stack
from ..optics.error_measure import albedo_error, worst_share
from ..optics.frame import spherical
from ..optics.optical_stack import rough_surfaces
from .closure import lobe_energy, lobe_f
from .samples import Views, truth_at

SOFT_LIGHT_DEG = 40.0
_PIXELS = 8
# Points of each strategy at a view.
_POINTS = 200
_RINGS, _AROUND = 9, 12


def ball_cosines() -> np.ndarray:
    """View cosines that split the pixels of a ball evenly."""
    return np.sqrt(1.0 - (np.arange(_PIXELS) + 0.5) / _PIXELS)


@dataclass(frozen=True, eq=False, repr=False)
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
        self._views = truth_at(truth, self._cosines, [alpha for _, alpha in rough_surfaces(stack)], _POINTS)
        self._albedo = truth.albedo(self._views.wo)
        self._lights = soft_lights(self._views, light_deg)

    def errors(self, lobe_set) -> Errors:
        """Errors of a lobe set of the stack."""
        albedo = albedo_error(sum(lobe_energy(lobe, self._cosines) for lobe in lobe_set.lobes(self._cosines)), self._albedo)
        views = self._views
        f = sum(lobe_f(lobe, views.wo[:, None], views.wi) for lobe in lobe_set.lobes(views.cos_theta_o[:, None]))
        gap = views.share[..., None] * (f - views.f)
        shape = worst_share(np.sum(np.abs(gap), axis=1), self._albedo)
        soft = worst_share(np.sum(np.abs(self._lights @ gap), axis=(1, 2))[:, None], np.sum(self._albedo, axis=1, keepdims=True))
        return Errors(albedo, soft, shape)


def soft_lights(views: Views, light_deg: float) -> np.ndarray:
    """(V, lights, Q): the part of what each point sends that each light lights; a point's lights sum to 1."""
    theta = np.arccos(1.0 - (np.arange(_RINGS) + 0.5) / _RINGS)
    phi = 2.0 * np.pi * (np.arange(_AROUND) + 0.5) / _AROUND
    centers = spherical(theta[:, None], phi).reshape(-1, 3)
    inside = np.cos(np.radians(0.5 * light_deg))
    lit = centers @ np.swapaxes(views.wi, 1, 2) > inside
    # of a point's mirror image in the plane of incidence, which lights the lights' images
    mirrored = lit.reshape(len(lit), _RINGS, _AROUND, -1)[:, :, ::-1].reshape(lit.shape)
    lit = 0.5 * lit + 0.5 * mirrored
    return lit / np.maximum(lit.sum(axis=1, keepdims=True), 0.5)
