# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies that baselines need: directional albedo as a function of the view, means over it, and facets that a view sees."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from ...optics.frame import spherical
from ...optics.gauss import gauss_legendre
from ...optics.ggx import ggx_visible_columns, turn_of
from ...optics.microfacet import GGX, masking_g1, masking_g2
from ...optics.quadrature import directional_albedo
from .parts import Fresnel

# Of `facet_points`.
_RINGS_AND_TURNS = 96, 24


class Curve:
    """A function of the view's cosine, (N,) to (N, channels), tabulated once and read linearly.

    Nodes are dense towards grazing; views below the lowest, 89.994 degrees, read that one.
    """

    COSINES = np.linspace(0.01, 1.0, 128) ** 2

    def __init__(self, function: Callable[[np.ndarray], np.ndarray]):
        self._values = function(self.COSINES)

    def __call__(self, cos_o: np.ndarray) -> np.ndarray:
        """Values (..., channels) at the view's cosines (...)."""
        return np.stack([np.interp(cos_o, self.COSINES, column) for column in self._values.T], axis=-1)

    @property
    def mean(self) -> np.ndarray:
        """Cosine-weighted mean over the hemisphere, (channels,)."""
        cos = self.COSINES
        weighted = 2.0 * self._values * cos[:, None]
        return np.sum(0.5 * (weighted[1:] + weighted[:-1]) * np.diff(cos)[:, None], axis=0)


def albedo_curve(f: Callable, widths: Sequence[tuple[str, float]], specular_albedo: Callable) -> Curve:
    """Directional albedo (3 channels) of f(wo, wi) and of its mirror-like part over the view's cosine."""

    def albedo(cos_o):
        return directional_albedo(f, spherical(np.arccos(cos_o), 0.0), widths, count=2048) + specular_albedo(cos_o)

    return Curve(albedo)


@cache
def facet_points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """u1, u2 and weights (n,) of facets for `facets_seen`: Gauss points, dense where the mirrored light meets the horizon.

    What depends on facets smoothly is closer by them than by four times as many `points`.
    """
    rings, turns = ((0.5 * (x + 1.0), 0.5 * w) for x, w in map(gauss_legendre, _RINGS_AND_TURNS))
    u1, weight = 1.0 - np.square(1.0 - rings[0]), 2.0 * (1.0 - rings[0]) * rings[1]
    return np.repeat(u1, len(turns[0])), np.tile(turns[0], len(u1)), np.outer(weight, turns[1]).ravel()


def facets_seen(cos_o: np.ndarray, alpha: np.ndarray, u1: np.ndarray, u2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """GGX facets that views at cosines (N,) see, alpha (N,), at uniform u1, u2 (n,): their cosine to the view and that of the mirrored light.

    Both (N, n). A mirrored light below the horizon has a negative cosine.
    """
    # the far half of the azimuth mirrors the near one
    cos_o, alpha = cos_o[:, None], alpha[:, None]
    sin_o = np.sqrt(np.maximum(1.0 - cos_o * cos_o, 0.0))
    x, _, z = ggx_visible_columns(sin_o, 0.0, cos_o, alpha, alpha, u1, *turn_of(0.5 * u2))
    cos_om = sin_o * x + cos_o * z
    return np.clip(cos_om, 0.0, 1.0), 2.0 * cos_om * z - cos_o


def reflected_share(cos_i: np.ndarray, cos_o: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """Share (N, M) of the light from such facets that leaves: 0 below the horizon, else not masked again."""
    safe, view, alpha = np.maximum(cos_i, 1e-8), cos_o[:, None], alpha[:, None]
    return np.where(cos_i > 0.0, masking_g2(safe, view, alpha, GGX) / masking_g1(view, alpha, GGX), 0.0)


def mean_fresnel(fresnel: Fresnel) -> np.ndarray:
    """Cosine-weighted mean of a curve over the hemisphere, (channels,); a critical angle does no harm."""
    cos = (np.arange(8192) + 0.5) / 8192
    return np.mean(2.0 * cos[:, None] * fresnel(cos), axis=0)
