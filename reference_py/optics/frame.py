# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions and conventions of the whole reference.

- Local frame: z is the surface normal. `wo` points to the viewer, `wi` to the light; both leave the surface.
- Arrays: directions are (..., 3) float64 and broadcast over the leading axes; colours have RGB as last axis.
- `f` is the BRDF in 1/sr and excludes the cosine. `albedo(wo)` is its cosine-weighted integral over wi.
- Angles are in radians; degrees appear only in user interfaces and in names that end in `_deg`.
- Layer 0 is the top. `eta` is relative, n_below / n_above; absolute indices are called `ior` or `n_...`.
"""

import numpy as np


def normalize(v: np.ndarray) -> np.ndarray:
    """Unit vectors along the last axis; a null vector stays null."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length > 0.0, length, 1.0)


def azimuth(w: np.ndarray) -> np.ndarray:
    """Angle (...) in radians of directions (..., 3) from x; 0 along z."""
    return np.arctan2(w[..., 1], w[..., 0])


def spherical(theta, phi) -> np.ndarray:
    """Unit directions (..., 3) from polar angle theta (from z) and azimuth phi, in radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    sin_theta = np.sin(theta)
    return np.stack([sin_theta * np.cos(phi), sin_theta * np.sin(phi), np.cos(theta)], axis=-1)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Dot product over the last axis."""
    return np.sum(a * b, axis=-1)


def reflect(w: np.ndarray, wm: np.ndarray) -> np.ndarray:
    """Mirror direction of w about the facet normal wm; both leave the surface."""
    return 2.0 * dot(w, wm)[..., None] * wm - w


def rotate_z(w: np.ndarray, angle) -> np.ndarray:
    """Directions w turned about z by angles (...) in radians, from x towards y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[..., 0] - s * w[..., 1], s * w[..., 0] + c * w[..., 1], w[..., 2]], axis=-1)


def half_vector(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Unit half vector; the normal where it is undefined (wi = -wo, both on the horizon)."""
    h = np.asarray(wi, float) + np.asarray(wo, float)
    length = np.linalg.norm(h, axis=-1, keepdims=True)
    return np.where(length > 1e-12, h / np.where(length > 1e-12, length, 1.0), np.array([0.0, 0.0, 1.0]))
