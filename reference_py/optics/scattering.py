# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that scatter: how a layer's values become an optical depth, single-scattering albedos and an asymmetry."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..material.schema import SCATTERING
from ..material.stack import Layer
from .slab import half_space_albedo

# Fit of the spherical albedo of a half space over s = sqrt((1 - albedo) / (1 - g albedo)): van de Hulst, "Multiple Light Scattering"
# (1980), as Christensen15 prints it. It starts the exact inversion.
FIT = (0.139, 1.17)
_CLOSE, _ROUNDS = 1e-10, 100


@dataclass(frozen=True, eq=False, repr=False)
class Scattering:
    """What a medium does with the light that it does not let pass; `Interface.tau` says how much that is."""

    albedo: np.ndarray
    """(channels,) share that is scattered and not absorbed, the tint's absorption counted."""
    g: float
    """Mean cosine of the scattering angle (Henyey41)."""


def medium_of(layer: Layer, tint_tau: np.ndarray) -> tuple[np.ndarray, Scattering | None]:
    """(tau (3,) of one perpendicular crossing, what is scattered) of a layer's medium, whose tint has an optical depth `tint_tau` (3,)."""
    if not layer.has(SCATTERING):
        return tint_tau, None
    if "density" in layer:
        extinction, albedo = np.full(len(layer["scatter_color"]), layer["density"]), np.array(albedo_of_color(layer["scatter_color"], layer["scatter_g"]))
    else:
        extinction, albedo = np.array(layer["extinction"]), np.array(layer["scatter_albedo"])
    own = extinction * layer["thickness"]
    tau = tint_tau + own
    if not np.any(own * albedo > 0.0):
        return tau, None
    return tau, Scattering(np.where(tau > 0.0, own * albedo / np.where(tau > 0.0, tau, 1.0), 0.0), layer["scatter_g"])


@lru_cache(maxsize=256)
def albedo_of_color(color: tuple[float, ...], g: float) -> tuple[float, ...]:
    """Single-scattering albedos of a medium whose half space, without interface and tint, has these spherical albedos, each 0 to 1.

    Good to 1e-5 of the color that they give; 0 and 1 are exact.
    """
    wanted = np.array(color, float)
    target = wanted
    for _ in range(_ROUNDS):
        s = similarity_of_color(target)
        albedo = (1.0 - s * s) / (1.0 - g * s * s)
        miss = wanted - half_space_albedo(albedo, g)
        if np.max(np.abs(miss)) < _CLOSE:
            break
        target = target + miss
    return tuple(np.where(wanted >= 1.0, 1.0, np.where(wanted <= 0.0, 0.0, albedo)).tolist())


def similarity_of_color(color: np.ndarray) -> np.ndarray:
    """s = sqrt((1 - albedo) / (1 - g albedo)), from 1 of black to 0 of white, of a half space's spherical albedo, by the fit: whatever g is."""
    a, b = FIT
    middle = 1.0 + a + b * color
    return np.clip((middle - np.sqrt(np.maximum(middle**2 - 4.0 * a * (1.0 - color), 0.0))) / (2.0 * a), 0.0, 1.0)


def color_of_similarity(s: np.ndarray) -> np.ndarray:
    """The inverse of `similarity_of_color`."""
    a, b = FIT
    return (1.0 - s) * (1.0 - a * s) / (1.0 + b * s)
