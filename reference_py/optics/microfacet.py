# SPDX-License-Identifier: GPL-3.0-or-later
"""Microfacet distributions and Smith masking, as Cycles evaluates them (Walter07, Heitz14), by the distribution's name.

The classes behind the names are in `ggx`, `beckmann` and `blinn`; `DISTRIBUTIONS` is the one place that lists them.
"""

import numpy as np

from ..errors import LaminaError
from .beckmann import Beckmann
from .blinn import Blinn
from .distribution import Distribution
from .ggx import Ggx

GGX, BECKMANN, BLINN = Ggx.name, Beckmann.name, Blinn.name
DISTRIBUTIONS: dict[str, Distribution] = {d.name: d for d in (Ggx(), Beckmann(), Blinn())}

# Below this alpha Cycles treats a lobe as a mirror (alpha_x * alpha_y <= 2e-10).
SPECULAR_ALPHA = 2e-10**0.5


def distribution_of(name: str) -> Distribution:
    """The distribution of a name. Raises LaminaError on an unknown one."""
    if name not in DISTRIBUTIONS:
        raise LaminaError(f"unknown distribution {name!r}; choose {', '.join(DISTRIBUTIONS)}")
    return DISTRIBUTIONS[name]


def is_specular(alpha: float) -> bool:
    """Whether Cycles treats a lobe of this alpha as a mirror."""
    return alpha <= SPECULAR_ALPHA


def distribution(cos_theta_m: np.ndarray, alpha, name: str) -> np.ndarray:
    """D(wm) in 1/sr; cos_theta_m is the cosine of the facet normal to the surface normal."""
    return distribution_of(name).density(cos_theta_m, alpha)


def facet_distribution(wm: np.ndarray, alpha, name: str) -> np.ndarray:
    """D (...) in 1/sr of facet normals wm (..., 3); alpha a number or (alpha_x, alpha_y)."""
    if not isinstance(alpha, tuple):
        return distribution(wm[..., 2], alpha, name)
    return anisotropic_distribution(name, *alpha, wm[..., 0], wm[..., 1], wm[..., 2])


def anisotropic_distribution(name: str, alpha_x, alpha_y, x, y, z) -> np.ndarray:
    """D in 1/sr (Heitz14, eqs. 84 and 85) of the half vector (x, y, z) in the surface's frame; 0 below."""
    z2 = np.maximum(np.square(z), 1e-20)
    slope2 = (np.square(x / alpha_x) + np.square(y / alpha_y)) / z2
    scale = 1.0 / (np.pi * alpha_x * alpha_y * np.maximum(np.square(z2), 1e-40))
    return np.where(z > 0.0, scale * distribution_of(name).slope_density(slope2), 0.0)


def smith_lambda(cos_theta: np.ndarray, alpha, name: str) -> np.ndarray:
    """Lambda of Smith's masking function for a direction above the surface."""
    cos2 = np.maximum(np.square(cos_theta), 1e-30)
    return smith_lambda_stretched(np.square(alpha) * np.maximum(1.0 / cos2 - 1.0, 0.0), name)


def smith_lambda_stretched(a2_tan2: np.ndarray, name: str) -> np.ndarray:
    """Lambda where alpha^2 tan^2 of the direction is known, as for anisotropic surfaces (Heitz14, eq. 86)."""
    return distribution_of(name).smith_lambda(a2_tan2)


def masking_g1(cos_theta: np.ndarray, alpha, name: str) -> np.ndarray:
    """Masking of one direction above the surface."""
    return 1.0 / (1.0 + smith_lambda(cos_theta, alpha, name))


def masking_g2(cos_theta_i: np.ndarray, cos_theta_o: np.ndarray, alpha, name: str) -> np.ndarray:
    """Height-correlated masking and shadowing (Heitz14, eq. 99)."""
    return 1.0 / (1.0 + smith_lambda(cos_theta_i, alpha, name) + smith_lambda(cos_theta_o, alpha, name))


def masking_v_cavity(cos_i, cos_o, cos_m, cos_mi) -> np.ndarray:
    """Geometric attenuation of symmetric V cavities (Torrance67; Weidlich07, eq. 1)."""
    safe = np.maximum(cos_mi, 1e-12)
    return np.clip(2.0 * cos_m * np.minimum(cos_i, cos_o) / safe, 0.0, 1.0)


def alpha_from_roughness(roughness):
    """alpha = roughness^2: the one place where roughness is squared. A float stays one, which numpy's square would not leave it."""
    return roughness * roughness


def roughness_from_slope_deg(slope_deg, name: str):
    """Roughness of a surface whose mean microfacet slope is tan(slope_deg), as Weidlich07 gives it.

    The mean slope is alpha * sqrt(pi) / 2 for Beckmann and alpha * pi / 2 for GGX, whose rms slope is infinite.
    """
    return np.sqrt(np.tan(np.radians(slope_deg)) / distribution_of(name).mean_slope_per_alpha)


def slope_deg_from_roughness(roughness, name: str):
    """Mean microfacet slope in degrees; the inverse of `roughness_from_slope_deg`."""
    return np.degrees(np.arctan(alpha_from_roughness(roughness) * distribution_of(name).mean_slope_per_alpha))
