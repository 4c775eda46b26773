# SPDX-License-Identifier: GPL-3.0-or-later
"""The half space that scatters alike in all directions, in closed form but for one function (Chandrasekhar, "Radiative Transfer", 1960, sections 37 to 39)."""

from functools import lru_cache

import numpy as np

_NODES, _ROUNDS, _CLOSE = 400, 20_000, 1e-13


@lru_cache(maxsize=8)
def _solved(single: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    mu, weights = 0.5 * (x + 1.0), 0.5 * weights
    h = np.ones(_NODES)
    for _ in range(_ROUNDS):
        new = _h_of(single, mu, mu, weights, h)
        if np.max(np.abs(new - h)) < _CLOSE:
            break
        h = 0.5 * (new + h)
    return mu, weights, h


def _h_of(single, cosines, mu, weights, h):
    return 1.0 / (np.sqrt(1.0 - single) + 0.5 * single * (mu * h * weights / (np.asarray(cosines)[..., None] + mu)).sum(axis=-1))


def h_function(single: float, cos_theta) -> np.ndarray:
    """H (...) of a single-scattering albedo, by iteration of its integral equation."""
    return _h_of(single, cos_theta, *_solved(single))


def f(single: float, cos_o, cos_i) -> np.ndarray:
    """f (...) in 1/sr."""
    return single / (4.0 * np.pi) * h_function(single, cos_o) * h_function(single, cos_i) / (cos_o + cos_i)


def albedo(single: float, cos_theta) -> np.ndarray:
    """Directional albedo (...)."""
    return 1.0 - np.sqrt(1.0 - single) * h_function(single, cos_theta)


def spherical_albedo(single: float) -> float:
    """Share of uniform light that comes back."""
    mu, weights, _ = _solved(single)
    return float(np.sum(2.0 * mu * weights * albedo(single, mu)))
