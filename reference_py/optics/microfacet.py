# SPDX-License-Identifier: GPL-3.0-or-later
"""Microfacet distributions and Smith masking, as Cycles evaluates them (Walter07, Heitz14).

Beckmann's Lambda is the rational approximation of Walter07, which Cycles uses, so that the reference
and the render share one definition. Blinn's distribution is eq. 7 of Weidlich07.
"""

import numpy as np

GGX, BECKMANN, BLINN = "ggx", "beckmann", "blinn"

# Below this alpha Cycles treats a lobe as a mirror (alpha_x * alpha_y <= 2e-10).
SPECULAR_ALPHA = 2e-10**0.5


def is_specular(alpha: float) -> bool:
    return alpha <= SPECULAR_ALPHA


def blinn_exponent(alpha):
    """Blinn's m that matches a Beckmann alpha for small angles: m = 2 / alpha^2 - 2."""
    return 2.0 / np.square(alpha) - 2.0


def distribution(cos_theta_m: np.ndarray, alpha, kind: str) -> np.ndarray:
    """D(wm) in 1/sr; cos_theta_m is the cosine of the facet normal to the surface normal."""
    cos2 = np.minimum(np.square(cos_theta_m), 1.0)
    alpha2 = np.square(alpha)
    if kind == GGX:
        density = alpha2 / (np.pi * np.square((1.0 - cos2) + alpha2 * cos2))
    elif kind == BECKMANN:
        safe = np.maximum(cos2, 1e-16)
        density = np.exp(-(1.0 - safe) / (safe * alpha2)) / (np.pi * alpha2 * np.square(safe))
    else:
        m = blinn_exponent(alpha)
        density = (m + 2.0) / (2.0 * np.pi) * np.maximum(cos2, 1e-300) ** (0.5 * m)
    return np.where(cos_theta_m > 0.0, density, 0.0)


def axes(alpha):
    """alpha_x and alpha_y of an alpha, which anisotropic surfaces give as a tuple of both."""
    return alpha if isinstance(alpha, tuple) else (alpha, alpha)


def facet_distribution(wm: np.ndarray, alpha, kind: str) -> np.ndarray:
    """D (...) in 1/sr of facet normals wm (..., 3), GGX or Beckmann; alpha a number or (alpha_x, alpha_y)."""
    if not isinstance(alpha, tuple):
        return distribution(wm[..., 2], alpha, kind)
    return anisotropic_distribution(kind, *alpha, wm[..., 0], wm[..., 1], wm[..., 2])


def anisotropic_distribution(kind: str, alpha_x, alpha_y, x, y, z) -> np.ndarray:
    """D in 1/sr (Heitz14, eqs. 84 and 85) of the half vector (x, y, z) in the surface's frame; 0 below."""
    z2 = np.maximum(np.square(z), 1e-20)
    slope2 = (np.square(x / alpha_x) + np.square(y / alpha_y)) / z2
    scale = 1.0 / (np.pi * alpha_x * alpha_y * np.maximum(np.square(z2), 1e-40))
    density = scale / np.square(1.0 + slope2) if kind == GGX else scale * np.exp(-slope2)
    return np.where(z > 0.0, density, 0.0)


def smith_lambda(cos_theta: np.ndarray, alpha, kind: str) -> np.ndarray:
    """Lambda of Smith's masking function for a direction above the surface."""
    cos2 = np.maximum(np.square(cos_theta), 1e-30)
    return smith_lambda_stretched(np.square(alpha) * np.maximum(1.0 / cos2 - 1.0, 0.0), kind)


def smith_lambda_stretched(a2_tan2: np.ndarray, kind: str) -> np.ndarray:
    """Lambda where alpha^2 tan^2 of the direction is known, as for anisotropic surfaces (Heitz14, eq. 86)."""
    if kind == GGX:
        return 0.5 * (np.sqrt(1.0 + a2_tan2) - 1.0)
    a = 1.0 / np.sqrt(np.maximum(a2_tan2, 1e-30))
    rational = ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a)
    return np.where(a2_tan2 < 0.39, 0.0, rational)


def masking_g1(cos_theta: np.ndarray, alpha, kind: str) -> np.ndarray:
    return 1.0 / (1.0 + smith_lambda(cos_theta, alpha, kind))


def masking_g2(cos_theta_i: np.ndarray, cos_theta_o: np.ndarray, alpha, kind: str) -> np.ndarray:
    """Height-correlated masking and shadowing (Heitz14, eq. 99)."""
    return 1.0 / (1.0 + smith_lambda(cos_theta_i, alpha, kind) + smith_lambda(cos_theta_o, alpha, kind))


def masking_v_cavity(cos_i, cos_o, cos_m, cos_mi) -> np.ndarray:
    """Geometric attenuation of symmetric V cavities (Torrance67; Weidlich07, eq. 1)."""
    safe = np.maximum(cos_mi, 1e-12)
    return np.clip(2.0 * cos_m * np.minimum(cos_i, cos_o) / safe, 0.0, 1.0)


def alpha_from_roughness(roughness):
    """alpha = roughness^2: the one place where roughness is squared."""
    return np.square(roughness)


def roughness_from_slope_deg(slope_deg, kind: str):
    """Roughness of a surface whose mean microfacet slope is tan(slope_deg), as Weidlich07 gives it.

    The mean slope is alpha * sqrt(pi) / 2 for Beckmann and alpha * pi / 2 for GGX, whose rms slope is infinite.
    """
    return np.sqrt(np.tan(np.radians(slope_deg)) / _mean_slope_per_alpha(kind))


def slope_deg_from_roughness(roughness, kind: str):
    """Mean microfacet slope in degrees; the inverse of `roughness_from_slope_deg`."""
    return np.degrees(np.arctan(alpha_from_roughness(roughness) * _mean_slope_per_alpha(kind)))


def _mean_slope_per_alpha(kind: str) -> float:
    return 0.5 * np.pi if kind == GGX else 0.5 * np.sqrt(np.pi)
