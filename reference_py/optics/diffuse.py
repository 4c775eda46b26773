# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse bases: the energy-preserving Oren-Nayar model, and the one of 1994.

`oren_nayar` is the improved form of Fujii 2012 with the multiple-scattering term of OpenPBR 1.0: light that meets several facets
has the square of the color. Cycles renders that from Blender 5.3 on; up to 5.2 it multiplied by the color once more.
Its roughness parameter is B / A of OrenNayar94, so a standard deviation in degrees means the same
facet statistics in both.
"""

import numpy as np

from .frame import dot

# Of the albedo a pi + b G(theta) in light that meets one facet: G at the horizon, and its mean over all views.
G_AT_HORIZON, MEAN_G = 0.5 * np.pi - 2.0 / 3.0, (2.0 * np.pi - 5.6) / 3.0
# Of the color, in light that meets several facets: the model's, and that of Cycles up to Blender 5.2.
OREN_NAYAR_POWER, CYCLES_5_2_POWER = 2, 3
_NEWTON_STEPS = 8


# With s the square of a slope deviation, the model of 1994 has A = 1 - x and B = y of x and y = f s / (s + o), by f and o.
FACTORS_1994 = (0.5, 0.33), (0.45, 0.09)


def _coefficients_1994(sigma_deg):
    sigma2 = np.square(np.radians(sigma_deg))
    less, b = (factor * sigma2 / (sigma2 + offset) for factor, offset in FACTORS_1994)
    return 1.0 - less, b


def fujii_roughness(sigma_deg):
    """Roughness of Fujii's form, B / A of OrenNayar94 at this standard deviation in degrees."""
    a, b = _coefficients_1994(sigma_deg)
    return b / a


def directional_g(cos_theta: np.ndarray) -> np.ndarray:
    """G (...) of view cosines (...) in the albedo a pi + b G(theta); a Taylor expansion where tan(theta) would overflow."""
    cos_theta = np.clip(cos_theta, 0.0, 1.0)
    safe = np.maximum(cos_theta, 1e-6)
    sin_theta = np.sqrt(np.maximum(1.0 - safe * safe, 0.0))
    g = sin_theta * (np.arccos(safe) - 2.0 / 3.0 - sin_theta * safe) + 2.0 / 3.0 * (sin_theta / safe) * (1.0 - sin_theta**3)
    return np.where(cos_theta < 1e-6, G_AT_HORIZON - cos_theta, g)


def oren_nayar(wi: np.ndarray, wo: np.ndarray, color: np.ndarray, sigma_deg: float, power: int = OREN_NAYAR_POWER) -> np.ndarray:
    """f in 1/sr, (..., 3), for directions above the surface (Fujii 2012; OpenPBR 1.0, diffuse lobe).

    `power` is that of the color in what meets several facets: CYCLES_5_2_POWER is what Cycles had.
    """
    color = np.asarray(color, float)
    sigma = fujii_roughness(sigma_deg)
    cos_i, cos_o = np.maximum(wi[..., 2], 0.0), np.maximum(wo[..., 2], 0.0)
    if np.all(sigma == 0.0):
        return np.broadcast_to(color / np.pi, np.broadcast_shapes(cos_i.shape, cos_o.shape) + color.shape).copy()
    a = 1.0 / (np.pi + sigma * G_AT_HORIZON)
    b = sigma * a
    t = dot(wi, wo) - cos_i * cos_o
    t = np.where(t > 0.0, t / np.maximum(np.maximum(cos_i, cos_o), 1e-30), t)
    mean = np.asarray(a * np.pi + MEAN_G * b)[..., None]
    multiple = color**power * (mean / (1.0 - mean)) / (np.pi * (1.0 - color * (1.0 - mean)))
    lost_o = 1.0 - (a * np.pi + b * directional_g(cos_o))
    lost_i = 1.0 - (a * np.pi + b * directional_g(cos_i))
    return color * (a + b * t)[..., None] + multiple * (lost_o * lost_i)[..., None]


def oren_nayar_albedo(cos_theta_o: np.ndarray, color: np.ndarray, sigma_deg: float, power: int = OREN_NAYAR_POWER) -> np.ndarray:
    """Directional albedo (..., 3) of `oren_nayar` for views (...) and colors that broadcast to (..., 3)."""
    single, mean = _single_albedo(cos_theta_o, sigma_deg)
    return _albedo_and_slope(np.asarray(color, float), single, mean, power)[0]


def oren_nayar_color(cos_theta_o: np.ndarray, albedo: np.ndarray, sigma_deg: float, power: int = OREN_NAYAR_POWER) -> np.ndarray:
    """The colors (..., 3), 1 at most, for which `oren_nayar_albedo` is `albedo` (..., 3), 0 or more."""
    single, mean = _single_albedo(cos_theta_o, sigma_deg)
    color = np.ones(np.shape(albedo))
    for _ in range(_NEWTON_STEPS):  # the albedo is convex in the color, so each step stays above it
        value, slope = _albedo_and_slope(color, single, mean, power)
        color = np.minimum(color - (value - albedo) / slope, 1.0)
    return color


def _single_albedo(cos_theta_o: np.ndarray, sigma_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Albedo (..., 1) of white in light that meets one facet, and its mean (..., 1) over all views."""
    sigma = fujii_roughness(sigma_deg)
    a = 1.0 / (np.pi + sigma * G_AT_HORIZON)
    b = sigma * a
    return (a * np.pi + b * directional_g(np.asarray(cos_theta_o, float)))[..., None], np.asarray(a * np.pi + MEAN_G * b)[..., None]


def _albedo_and_slope(color: np.ndarray, single: np.ndarray, mean: np.ndarray, power: int) -> tuple[np.ndarray, np.ndarray]:
    """The albedo, and how it grows with the color."""
    rest = 1.0 - color * (1.0 - mean)
    multiple = mean * (1.0 - single) * color ** (power - 1) / rest
    return color * (single + multiple), single + multiple * (power + color * (1.0 - mean) / rest)


def oren_nayar_shares(color: np.ndarray, sigma_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Weights (..., 3) of the white `oren_nayar` and of what meets one facet alone, whose sum is `oren_nayar` of the color.

    White is the same for every `power`, and so is f(color) / color in the limit of a dark color, which meets one facet alone.
    """
    color = np.asarray(color, float)
    sigma = fujii_roughness(sigma_deg)
    mean = np.asarray((np.pi + MEAN_G * sigma) / (np.pi + sigma * G_AT_HORIZON))[..., None]
    white = color**2 * mean / (1.0 - color * (1.0 - mean))
    return white, color - white


def oren_nayar_1994(wi: np.ndarray, wo: np.ndarray, color: np.ndarray, sigma_deg: float) -> np.ndarray:
    """The qualitative model of OrenNayar94 (eq. 30), in 1/sr, (..., 3); loses energy at grazing angles."""
    a, b = _coefficients_1994(sigma_deg)
    cos_i, cos_o = np.maximum(wi[..., 2], 1e-12), np.maximum(wo[..., 2], 1e-12)
    sin_sin_cos_phi = dot(wi, wo) - cos_i * cos_o
    # sin(max angle) tan(min angle) cos(phi) = sin_i sin_o cos(phi) / max(cos)
    lobe = a + b * np.maximum(sin_sin_cos_phi, 0.0) / np.maximum(cos_i, cos_o)
    return np.asarray(color, float) / np.pi * lobe[..., None]
