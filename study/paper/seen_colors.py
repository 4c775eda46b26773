# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours as people see them: CIE 1976 L*a*b* and L*u*v*, by colour-science, and means over bands of view angle."""

from functools import lru_cache

import numpy as np

from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import reflectance_to_xyz, xyz_to_rgb
from ...reference_py.registry import make_model
from ..colorimetry import colour_science, lab, white, xyz_of_linear
from .sphere import radiance

BANDS_DEG = (0.0, 30.0, 50.0, 70.0, 90.0)
"""Edges of the bands of view angle on a sphere."""


def band_names() -> list[str]:
    return [f"{a:g}-{b:g}deg" for a, b in zip(BANDS_DEG, BANDS_DEG[1:])]


def band_means(values: np.ndarray, theta_deg: np.ndarray) -> np.ndarray:
    """Means (4,) of values (...) over the pixels of each band; theta_deg (...) is nan beside the sphere."""
    return np.array([np.mean(values[(theta_deg >= a) & (theta_deg < b)]) for a, b in zip(BANDS_DEG, BANDS_DEG[1:])])


@lru_cache(maxsize=1)
def white_level() -> float:
    """Radiance of the brightest spot of a perfectly white, matte sphere: what L* = 100 means in all figures."""
    model = make_model("weidlich_wilkie", Stack.from_dict({"base": {"kind": "lambert", "color": [1.0] * 3}}))
    x, y = np.meshgrid(*2 * [np.linspace(-0.95, 0.95, 40)])
    z2 = 1.0 - x * x - y * y
    normals = np.stack([x, y, np.sqrt(np.maximum(z2, 0.0))], axis=-1)[z2 > 0.0]
    return float(np.max(radiance(model, normals)))


def xyz_of_rgb(rgb: np.ndarray) -> np.ndarray:
    """XYZ (..., 3) of linear Rec.709 radiance (..., 3), white being `white_level`."""
    return xyz_of_linear(rgb / white_level())


def xyz_of_spectra(spectra: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
    """XYZ (..., 3) of radiance (..., n) on wavelengths (n,) under D65, white being `white_level`."""
    return reflectance_to_xyz(spectra / white_level(), wavelength_nm)


def displayed(xyz: np.ndarray) -> np.ndarray:
    """sRGB (..., 3) in 0 to 1 for the screen (IEC 61966-2-1); what the screen cannot show is clipped."""
    rgb = np.clip(xyz_to_rgb(xyz), 0.0, 1.0)
    return np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1.0 / 2.4) - 0.055)


def lightness_chroma_hue(xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """L*, C*ab (...) and hue angle h_ab (...) in degrees of XYZ (..., 3)."""
    lightness, a, b = np.moveaxis(lab(xyz), -1, 0)
    return lightness, np.hypot(a, b), np.degrees(np.arctan2(b, a)) % 360.0


def hue_difference(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """CIE 1976 Delta H*ab (...), comparable with Delta C* and Delta L*, of XYZ (..., 3)."""
    a, b = lab(first), lab(second)
    cross = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    chroma = np.hypot(a[..., 1], a[..., 2]) * np.hypot(b[..., 1], b[..., 2])
    along = a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return np.sign(cross) * np.sqrt(np.maximum(2.0 * (chroma - along), 0.0))


def saturation(xyz: np.ndarray) -> np.ndarray:
    """CIE 1976 saturation s_uv (...) of XYZ (..., 3): chroma over lightness in L*u*v*."""
    luv = colour_science().XYZ_to_Luv(xyz, white())
    return np.hypot(luv[..., 1], luv[..., 2]) / np.maximum(luv[..., 0], 1e-6)
