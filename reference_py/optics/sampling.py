# SPDX-License-Identifier: GPL-3.0-or-later
"""Visible facet normals of Smith microsurfaces: their density and exact samples (Heitz14, Heitz16).

A direction `w` leaves the surface. Unlike elsewhere it may point below the horizon (w_z < 0): a ray inside a
rough surface sees facets from there too. Arrays are (n, 3); (3, n).T is the layout that computes fastest. An alpha is
a number, or the tuple (alpha_x, alpha_y) of an anisotropic surface, which is an isotropic one stretched (Heitz14).
"""

from math import erfc, exp, pi, sqrt

import numpy as np

from .microfacet import GGX, axes, facet_distribution

_SQRT_PI = sqrt(pi)


def components(w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The three columns (n,) of w (n, 3)."""
    return w[:, 0], w[:, 1], w[:, 2]


def vectors(x, y, z) -> np.ndarray:
    """The (n, 3) array of three columns, each of them contiguous in memory."""
    out = np.empty((3, len(z)))
    out[0], out[1], out[2] = x, y, z
    return out.T


def _tail(b: float) -> float:
    """(1 / sqrt(pi) - b erfcx(b)) / 2, the projected area of a Gaussian surface seen from below, over exp(-b^2)."""
    if b > 20.0:
        b2 = b * b
        return (0.5 - 0.75 / b2 + 1.875 / b2**2) / (2.0 * _SQRT_PI * b2)
    return 0.5 * (1.0 / _SQRT_PI - b * exp(b * b) * erfc(b))


def take(w: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Rows of w (n, m) in the layout that computes fastest."""
    return w.T.take(index, axis=1).T


# numpy has no erf; this tail is smooth in 1 / (1 + b), so a linear table is good to 1e-8.
_TAIL_CELLS = 8192
_TAIL = np.array([0.0] + [_tail(_TAIL_CELLS / i - 1.0) for i in range(1, _TAIL_CELLS + 1)])
_TAIL_RISE = np.diff(_TAIL, append=_TAIL[-1])


def _tail_table(b: np.ndarray) -> np.ndarray:
    # np.interp searches its grid and takes four times as long
    place = _TAIL_CELLS / (1.0 + b)
    cell = place.astype(np.intp)
    return _TAIL.take(cell) + (place - cell) * _TAIL_RISE.take(cell)


def projected_area(w: np.ndarray, alpha, kind: str) -> np.ndarray:
    """Area (n,) of the facets seen from w per unit of macrosurface, cos(w) (1 + Lambda(w)) (Heitz16).

    Exact for both distributions: Beckmann's is not the rational approximation of Walter07, from which it
    differs by up to 0.35 %, because samples and densities must agree.
    """
    x, y, z = components(w)
    alpha_x, alpha_y = axes(alpha)
    across2 = np.square(alpha_x * x) + np.square(alpha_y * y)
    if kind == GGX:
        return 0.5 * (z + np.sqrt(z * z + across2))
    across = np.sqrt(np.maximum(across2, 1e-60))
    b = np.abs(z) / across
    tail = np.exp(-np.minimum(b * b, 700.0)) * _tail_table(b)
    return np.maximum(z, 0.0) + across * tail


def visible_normal_density(w: np.ndarray, wm: np.ndarray, alpha, kind: str) -> np.ndarray:
    """Density (n,) in 1/sr of the facet normals wm seen from w (Heitz14)."""
    cos = np.maximum(np.einsum("ij,ij->i", w, wm), 0.0)
    return cos * facet_distribution(wm, alpha, kind) / projected_area(w, alpha, kind)


def sample_visible_normals(w: np.ndarray, alpha, kind: str, rng: np.random.Generator) -> np.ndarray:
    """Facet normals (n, 3) of density `visible_normal_density`; any w_z."""
    if kind == GGX:
        return ggx_visible_normals(w, alpha, rng.random(len(w)), rng.random(len(w)))
    return _beckmann_visible_normals(w, alpha, rng)


def ggx_visible_normals(w: np.ndarray, alpha, u1: np.ndarray, u2: np.ndarray) -> np.ndarray:
    """GGX normals seen from w for uniform u1, u2 (n,).

    GGX is a stretched hemisphere (Heitz18). Seen from w, its normals mirror w into directions that fill a
    spherical cap evenly (Dupuy23), whatever the sign of w_z.
    """
    x, y, z = components(w)
    alpha_x, alpha_y = axes(alpha)
    ax, ay = alpha_x * x, alpha_y * y
    scale = 1.0 / np.sqrt(ax * ax + ay * ay + z * z)
    ax *= scale
    ay *= scale
    az = z * scale
    height = (1.0 - u1) * (1.0 + az)  # z of the half vector, free of cancellation
    cap_z = height - az
    sin = np.sqrt(np.maximum(1.0 - cap_z * cap_z, 0.0))
    phi = (2.0 * pi) * u2
    hx = alpha_x * (sin * np.cos(phi) + ax)
    hy = alpha_y * (sin * np.sin(phi) + ay)
    scale = 1.0 / np.sqrt(hx * hx + hy * hy + height * height)
    return vectors(hx * scale, hy * scale, height * scale)


def _beckmann_visible_normals(w: np.ndarray, alpha, rng: np.random.Generator) -> np.ndarray:
    """Beckmann normals seen from w: slopes along and across w, in units of alpha (Jakob14, Heitz14)."""
    x, y, z = components(w)
    alpha_x, alpha_y = axes(alpha)
    x, y = alpha_x * x, alpha_y * y
    sin = np.sqrt(x * x + y * y)
    toward = _visible_slopes(z / np.maximum(sin, 1e-30), rng)
    across = rng.normal(0.0, sqrt(0.5), len(z))
    flat = sin < 1e-18
    safe = np.where(flat, 1.0, sin)
    cos_phi, sin_phi = np.where(flat, 1.0, x / safe), np.where(flat, 0.0, y / safe)
    mx = alpha_x * (toward * cos_phi - across * sin_phi)
    my = alpha_y * (toward * sin_phi + across * cos_phi)
    scale = 1.0 / np.sqrt(mx * mx + my * my + 1.0)
    return vectors(mx * scale, my * scale, scale)


def _visible_slopes(a: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Samples t (n,) of the density max(a + t, 0) exp(-t^2): facets inclined by t towards a view of cotangent a.

    Exact by rejection, where Jakob14 inverts the distribution numerically.
    """
    t = np.empty(len(a))
    todo = np.arange(len(a))
    while len(todo):
        from_above = a[todo] > 0.0
        for index, draw in ((todo[from_above], _slopes_from_above), (todo[~from_above], _slopes_from_below)):
            if len(index):
                t[index] = draw(a[index], rng)
        todo = todo[np.isnan(t[todo])]
    return t


def _slopes_from_above(a: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """One trial for a > 0; nan where rejected.

    |t| has the density (2a + max(|t| - a, 0)) exp(-t^2): a half Gaussian and a Rayleigh tail.
    """
    n = len(a)
    gaussian, tail = a * _SQRT_PI, 0.5 * np.exp(-np.minimum(a * a, 700.0))
    use_tail = rng.random(n) * (gaussian + tail) >= gaussian
    rayleigh = np.sqrt(rng.standard_exponential(n))
    size = np.where(use_tail, a + rayleigh, np.abs(rng.normal(0.0, sqrt(0.5), n)))
    u = rng.random(n)
    negative = ~use_tail & (size < a) & (2.0 * a * u >= a + size)
    rejected = use_tail & (u >= np.exp(-2.0 * a * rayleigh))
    return np.where(rejected, np.nan, np.where(negative, -size, size))


def _slopes_from_below(a: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """One trial for a <= 0; nan where rejected. With t = s - a the density is s exp(-s^2 + 2 a s)."""
    n = len(a)
    steep = a < -0.8
    gamma = rng.standard_gamma(2.0, n) / np.where(steep, -2.0 * a, 1.0)
    s = np.where(steep, gamma, np.sqrt(rng.standard_exponential(n)))
    accept = np.where(steep, np.exp(-s * s), np.exp(2.0 * a * s))
    return np.where(rng.random(n) < accept, s - a, np.nan)
