# SPDX-License-Identifier: GPL-3.0-or-later
"""GGX, the distribution of Trowbridge and Reitz (Walter07)."""

from math import pi

import numpy as np

from .directions import components, vectors
from .distribution import Distribution, axes


class Ggx(Distribution):
    """Facets with long tails; the rms of their slopes is infinite."""

    name = "ggx"
    mean_slope_per_alpha = 0.5 * pi

    def density(self, cos_theta_m, alpha):
        """D (...): alpha^2 / (pi (sin^2 + alpha^2 cos^2)^2), 0 below (Walter07)."""
        cos2, alpha2 = np.minimum(np.square(cos_theta_m), 1.0), np.square(alpha)
        return np.where(cos_theta_m > 0.0, alpha2 / (pi * np.square((1.0 - cos2) + alpha2 * cos2)), 0.0)

    def slope_density(self, slope2):
        """1 / (1 + slope2)^2."""
        return 1.0 / np.square(1.0 + slope2)

    def log_slope_density_rate(self, slope2):
        """-2 / (1 + slope2)."""
        return -2.0 / (1.0 + slope2)

    def slope2_quantile(self, u):
        """u / (1 - u)."""
        return u / (1.0 - u)

    def smith_lambda(self, a2_tan2):
        """(sqrt(1 + alpha^2 tan^2) - 1) / 2 (Heitz14)."""
        return 0.5 * (np.sqrt(1.0 + a2_tan2) - 1.0)

    def smith_lambda_and_rate(self, a2_tan2):
        """The rate is 1 / (4 sqrt(1 + alpha^2 tan^2))."""
        root = np.sqrt(1.0 + a2_tan2)
        return 0.5 * (root - 1.0), 0.25 / root

    def projected_area(self, w, alpha):
        """(cos + sqrt(cos^2 + alpha^2 sin^2)) / 2, (n,); any w_z."""
        x, y, z = components(w)
        alpha_x, alpha_y = axes(alpha)
        return 0.5 * (z + np.sqrt(z * z + (np.square(alpha_x * x) + np.square(alpha_y * y))))

    def sample_visible_normals(self, w, alpha, rng):
        """Normals (n, 3), by a cap of directions (Dupuy23)."""
        return ggx_visible_normals(w, alpha, rng.random(len(w)), rng.random(len(w)))


def ggx_visible_normals(w: np.ndarray, alpha, u1: np.ndarray, u2: np.ndarray) -> np.ndarray:
    """GGX normals (n, 3) seen from w for uniform u1, u2 (n,)."""
    return vectors(*ggx_visible_columns(*components(w), *axes(alpha), u1, *turn_of(u2)))


def turn_of(u2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines and sines of u2 turns."""
    phi = (2.0 * pi) * u2
    return np.cos(phi), np.sin(phi)


def ggx_visible_columns(x, y, z, alpha_x, alpha_y, u1, cos_turn, sin_turn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The columns of `ggx_visible_normals`, of which u2 is given as `turn_of` has it; what is given by columns is broadcast.

    GGX is a stretched hemisphere (Heitz18). Seen from w, its normals mirror w into directions that fill a
    spherical cap evenly (Dupuy23), whatever the sign of w_z.
    """
    ax, ay = alpha_x * x, alpha_y * y
    scale = 1.0 / np.sqrt(ax * ax + ay * ay + z * z)
    ax, ay, az = ax * scale, ay * scale, z * scale
    height = (1.0 - u1) * (1.0 + az)  # z of the half vector, free of cancellation
    cap_z = height - az
    sin = np.sqrt(np.maximum(1.0 - cap_z * cap_z, 0.0))
    hx = alpha_x * (sin * cos_turn + ax)
    hy = alpha_y * (sin * sin_turn + ay)
    scale = 1.0 / np.sqrt(hx * hx + hy * hy + height * height)
    return hx * scale, hy * scale, height * scale
