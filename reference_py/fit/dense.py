# SPDX-License-Identifier: GPL-3.0-or-later
"""A model at a million pairs of directions, as in a whole MERL table."""

import numpy as np

from ..material.stack import Stack
from ..optics.frame import spherical
from ..registry import make_model

# So many at once stay in a processor's cache.
_CHUNK = 10_000
# Below this count models are asked directly.
_FEW = 20_000
_THETAS, _PHIS = 46, 46


def evaluate_all(model: str, stack: Stack, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """f (n, 3) at directions (n, 3).

    Of `adding` the part in closed form is exact, and the rest, which is smooth, is interpolated linearly in a table of
    2 degrees of theta and 4 of phi; it costs a second per million pairs and channel.
    """
    if len(wo) <= _FEW or model != "adding":
        exact = make_model(model, stack)
        return np.concatenate([exact.f(wo[i : i + _CHUNK], wi[i : i + _CHUNK]) for i in range(0, len(wo), _CHUNK)])
    adding = make_model("adding", stack)
    table = _remainder(adding)
    parts = []
    for i in range(0, len(wo), _CHUNK):
        o, n = wo[i : i + _CHUNK], wi[i : i + _CHUNK]
        parts.append(np.maximum(adding.direct_f(o, n) + _interpolated(table, o, n), 0.0))
    return np.concatenate(parts)


def _remainder(adding) -> np.ndarray:
    """(theta_o, theta_i, phi, 3): f less its part in closed form, which is reciprocal."""
    theta = np.linspace(0.0, 0.5 * np.pi, _THETAS)
    theta[-1] -= 1e-4
    phi = np.linspace(0.0, np.pi, _PHIS)
    o, i = np.triu_indices(_THETAS)
    f = adding.smooth_f(np.repeat(spherical(theta[o], 0.0), _PHIS, axis=0), spherical(theta[i][:, None], phi).reshape(-1, 3))
    table = np.empty((_THETAS, _THETAS, _PHIS, 3))
    table[o, i] = table[i, o] = f.reshape(len(o), _PHIS, 3)
    return table


def _interpolated(table: np.ndarray, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    cos_phi = (wo[:, 0] * wi[:, 0] + wo[:, 1] * wi[:, 1]) / np.maximum(np.hypot(*wo[:, :2].T) * np.hypot(*wi[:, :2].T), 1e-12)
    at = [
        np.arccos(np.clip(wo[:, 2], 0.0, 1.0)) * 2.0 / np.pi,
        np.arccos(np.clip(wi[:, 2], 0.0, 1.0)) * 2.0 / np.pi,
        np.arccos(np.clip(cos_phi, -1.0, 1.0)) / np.pi,
    ]
    low, share = [], []
    for u, n in zip(at, table.shape):
        i = np.minimum((u * (n - 1)).astype(int), n - 2)
        low.append(i)
        share.append(u * (n - 1) - i)
    cells, first = table.reshape(-1, 3), (low[0] * _THETAS + low[1]) * _PHIS + low[2]
    result = np.zeros((len(wo), 3))
    for to, ti, p in np.ndindex(2, 2, 2):
        weight = np.ones(())
        for s, far in zip(share, (to, ti, p)):
            weight = weight * (s if far else 1.0 - s)
        result += weight[:, None] * cells.take(first + (to * _THETAS + ti) * _PHIS + p, axis=0)
    return result
