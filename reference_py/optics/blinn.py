# SPDX-License-Identifier: GPL-3.0-or-later
"""Blinn's distribution as eq. 7 of Weidlich07 writes it, for the paper's own readings: no masking and no visible normals."""

import numpy as np

from .distribution import Distribution


class Blinn(Distribution):
    """A power of the facet's cosine, with the exponent that matches a Beckmann alpha for small angles."""

    name = "blinn"

    def density(self, cos_theta_m, alpha):
        """D (...): (m + 2) / (2 pi) cos^m, 0 below (Weidlich07, eq. 7)."""
        m = blinn_exponent(alpha)
        value = (m + 2.0) / (2.0 * np.pi) * np.maximum(np.minimum(np.square(cos_theta_m), 1.0), 1e-300) ** (0.5 * m)
        return np.where(cos_theta_m > 0.0, value, 0.0)

    def cosine_quantile(self, u, alpha):
        """(1 - u)^(1 / (m + 2))."""
        return np.power(1.0 - u, 1.0 / (blinn_exponent(alpha) + 2.0))


def blinn_exponent(alpha):
    """Blinn's m that matches a Beckmann alpha for small angles: m = 2 / alpha^2 - 2."""
    return 2.0 / np.square(alpha) - 2.0
