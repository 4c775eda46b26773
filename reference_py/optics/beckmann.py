# SPDX-License-Identifier: GPL-3.0-or-later
"""Beckmann's distribution: a Gaussian of slopes (Walter07). Visible normals are exact, by rejection."""

from functools import cache
from math import erfc, exp, pi, sqrt

import numpy as np

from .directions import components, vectors
from .distribution import Distribution, axes

_SQRT_PI = sqrt(pi)
# alpha^2 tan^2 up to which masking counts as none: a = 1.6 (Walter07). Cycles has it rounded, .39: there Lambda differs by 6e-5 between the two.
_NO_MASKING = 1.0 / 1.6**2


class Beckmann(Distribution):
    """Facets whose slopes are Gaussian."""

    name = "beckmann"
    mean_slope_per_alpha = 0.5 * _SQRT_PI

    def density(self, cos_theta_m, alpha):
        """D (...): exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4), 0 below (Walter07)."""
        alpha2, cos2 = np.square(alpha), np.clip(np.square(cos_theta_m), 1e-16, 1.0)
        value = np.exp(-(1.0 - cos2) / (cos2 * alpha2)) / (pi * alpha2 * np.square(cos2))
        return np.where(cos_theta_m > 0.0, value, 0.0)

    def slope_density(self, slope2):
        """exp(-slope2)."""
        return np.exp(-slope2)

    def log_slope_density_rate(self, slope2):
        """-1."""
        return np.full_like(slope2, -1.0)

    def slope2_quantile(self, u):
        """-log(1 - u): slope2 is exponentially distributed."""
        return -np.log1p(-u)

    def smith_lambda(self, a2_tan2):
        """The rational approximation of Walter07, which Cycles uses."""
        a = 1.0 / np.sqrt(np.maximum(a2_tan2, _NO_MASKING))
        rational = ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a)
        return np.where(a2_tan2 <= _NO_MASKING, 0.0, rational)

    def smith_lambda_and_rate(self, a2_tan2):
        """Of the rational approximation, by a = 1 / (alpha tan), whose own rate is -a^3 / 2."""
        a = 1.0 / np.sqrt(np.maximum(a2_tan2, _NO_MASKING))
        top, below = (0.396 * a - 1.259) * a + 1.0, (2.181 * a + 3.535) * a
        rational = top / below
        by_a = ((0.792 * a - 1.259) - rational * (4.362 * a + 3.535)) / below
        masked = a2_tan2 > _NO_MASKING
        return rational * masked, (-0.5 * a * a * a) * by_a * masked

    def projected_area(self, w, alpha):
        """Not by the approximation of `smith_lambda`, from which it differs by up to 0.35 %: samples and densities must agree."""
        x, y, z = components(w)
        alpha_x, alpha_y = axes(alpha)
        across = np.sqrt(np.maximum(np.square(alpha_x * x) + np.square(alpha_y * y), 1e-60))
        b = np.abs(z) / across
        return np.maximum(z, 0.0) + across * (np.exp(-np.minimum(b * b, 700.0)) * _tail_table(b))

    def sample_visible_normals(self, w, alpha, rng):
        """Normals (n, 3), exact, by rejection of slopes."""
        return _visible_normals(w, alpha, rng)


def _tail(b: float) -> float:
    """(1 / sqrt(pi) - b erfcx(b)) / 2, the projected area of a Gaussian surface seen from below, over exp(-b^2)."""
    if b > 20.0:
        b2 = b * b
        return (0.5 - 0.75 / b2 + 1.875 / b2**2) / (2.0 * _SQRT_PI * b2)
    return 0.5 * (1.0 / _SQRT_PI - b * exp(b * b) * erfc(b))


_TAIL_CELLS = 8192


@cache
def _tail_cells() -> tuple[np.ndarray, np.ndarray]:
    """The tail at evenly spread 1 / (1 + b) and its rise to the next, (_TAIL_CELLS + 1,) each. numpy has no erf, and a linear table is good to 1e-8."""
    tail = np.array([0.0] + [_tail(_TAIL_CELLS / i - 1.0) for i in range(1, _TAIL_CELLS + 1)])
    return tail, np.diff(tail, append=tail[-1])


def _tail_table(b: np.ndarray) -> np.ndarray:
    tail, rise = _tail_cells()
    # np.interp searches its grid and takes four times as long
    place = _TAIL_CELLS / (1.0 + b)
    cell = place.astype(np.intp)
    return tail.take(cell) + (place - cell) * rise.take(cell)


def _visible_normals(w: np.ndarray, alpha, rng: np.random.Generator) -> np.ndarray:
    """Normals seen from w: slopes along and across w, in units of alpha (Jakob14, Heitz14)."""
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
