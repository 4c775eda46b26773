# SPDX-License-Identifier: GPL-3.0-or-later
"""Artist-friendly conductor: Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", JCGT 3(4), 64-72."""

import numpy as np

from ...errors import LaminaError


def artist_index(reflectance: np.ndarray, edge_tint: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Complex index (n, k), relative to the medium above, of a metal given by two colours.

    reflectance: (...,) at normal incidence, 0 <= r < 1; edge_tint: (...,) g in [0, 1], 1 gives the smallest n
    that has the reflectance. Broadcasts. Gulbrandsen 2014, eqs. for n(r, g) and k(n, r).
    Raises LaminaError outside these ranges (r = 1 has no finite index).
    """
    r, g = np.asarray(reflectance, float), np.asarray(edge_tint, float)
    if not np.all((r >= 0.0) & (r < 1.0)):
        raise LaminaError(f"Metal reflectance {r.tolist()} is outside the range 0 <= r < 1")
    if not np.all((g >= 0.0) & (g <= 1.0)):
        raise LaminaError(f"Metal edge tint {g.tolist()} is outside the range 0 to 1")
    n_min, n_max = _n_range(r)
    n = g * n_min + (1.0 - g) * n_max
    # rounding may leave a tiny negative k^2 at g = 0, where k is 0
    k_squared = (r * np.square(n + 1.0) - np.square(n - 1.0)) / (1.0 - r)
    return n, np.sqrt(np.maximum(k_squared, 0.0))


def artist_color(n: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance r at normal incidence and edge tint g of a complex index (n, k); inverse of `artist_index`.

    n > 0 and k >= 0: (...,), broadcast. Where r = 0 (n = 1, k = 0) every g is the same metal: g is 0 there.
    Raises LaminaError for other n or k.
    """
    n, k = np.broadcast_arrays(np.asarray(n, float), np.asarray(k, float))
    if not np.all((n > 0.0) & (k >= 0.0) & np.isfinite(n) & np.isfinite(k)):
        raise LaminaError(f"Complex index n {n.tolist()}, k {k.tolist()}: n must be above 0, k at least 0, both finite")
    r = (np.square(n - 1.0) + np.square(k)) / (np.square(n + 1.0) + np.square(k))
    n_min, n_max = _n_range(r)
    width = n_max - n_min
    g = np.divide(n_max - n, width, out=np.zeros_like(r), where=width > 0.0)
    return r, np.clip(g, 0.0, 1.0)


def _n_range(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest n with normal reflectance r."""
    root = np.sqrt(r)
    return (1.0 - r) / (1.0 + r), (1.0 + root) / (1.0 - root)
