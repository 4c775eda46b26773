# SPDX-License-Identifier: GPL-3.0-or-later
"""What a distribution of microfacets is to the models: one class, with the methods that they need."""

import numpy as np

from ..errors import LaminaError


class Distribution:
    """Facets of one statistics (Walter07, Heitz14). Shapes: directions w (n, 3), cosines (...); densities in 1/sr.

    An alpha is a number, or the tuple (alpha_x, alpha_y) of an anisotropic surface, which is an isotropic one stretched (Heitz14).
    `slope2` is the square of a facet's slope in units of alpha. What a class does not say, models that need it refuse.
    """

    name = ""
    mean_slope_per_alpha = 0.0
    """Mean slope of the facets over alpha."""

    def slope_density(self, slope2: np.ndarray) -> np.ndarray:
        """D times pi alpha_x alpha_y cos^4 of the facet."""
        raise self._unknown("no density of slopes, which anisotropic surfaces need")

    def log_slope_density_rate(self, slope2: np.ndarray) -> np.ndarray:
        """Derivative of the logarithm of `slope_density` by slope2."""
        raise self._unknown("no derivative of its density of slopes, which bakes need")

    def slope2_quantile(self, u: np.ndarray) -> np.ndarray:
        """slope2 of the facet normals of density D cos, for uniform u in [0, 1)."""
        raise self._unknown("no quantiles of slopes")

    def smith_lambda(self, a2_tan2: np.ndarray) -> np.ndarray:
        """Lambda of Smith's masking function, as Cycles evaluates it, where alpha^2 tan^2 of the direction is known (Heitz14, eq. 86)."""
        raise self._unknown("no Smith masking")

    def smith_lambda_and_rate(self, a2_tan2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`smith_lambda`, and its derivative by its argument."""
        raise self._unknown("no derivative of Smith masking, which bakes need")

    def projected_area(self, w: np.ndarray, alpha) -> np.ndarray:
        """Area (n,) of the facets seen from w per unit of macrosurface, cos(w) (1 + Lambda(w)), exact; any w_z (Heitz16)."""
        raise self._unknown("no projected area, which walks need")

    def sample_visible_normals(self, w: np.ndarray, alpha, rng: np.random.Generator) -> np.ndarray:
        """Facet normals (n, 3) as they are seen from w; any w_z."""
        raise self._unknown("no samples of visible normals, which walks need")

    def density(self, cos_theta_m: np.ndarray, alpha) -> np.ndarray:
        """D (...) of facets at this cosine to the surface's normal; 0 below."""
        cos2 = np.clip(np.square(cos_theta_m), 1e-16, 1.0)
        alpha2 = np.square(alpha)
        value = self.slope_density((1.0 - cos2) / (cos2 * alpha2)) / (np.pi * alpha2 * np.square(cos2))
        return np.where(cos_theta_m > 0.0, value, 0.0)

    def cosine_quantile(self, u: np.ndarray, alpha: float) -> np.ndarray:
        """Cosine of the facet normals of density D cos, for uniform u in [0, 1)."""
        return 1.0 / np.sqrt(1.0 + np.square(alpha) * self.slope2_quantile(u))

    def _unknown(self, what: str) -> LaminaError:
        return LaminaError(f"distribution {self.name}: {what}")


def axes(alpha) -> tuple:
    """alpha_x and alpha_y of an alpha."""
    return alpha if isinstance(alpha, tuple) else (alpha, alpha)
