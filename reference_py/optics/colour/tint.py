# SPDX-License-Identifier: GPL-3.0-or-later
"""Tints of glazes that are given as spectra, integrated to the three channels of a stack.

Bouguer's law (Weidlich07, eq. 5) holds for each wavelength alone: a tint in RGB, raised to the thickness, leaves the truth as the glaze
gets thicker. So the color that a glaze has over its base is integrated over the spectrum, and the tint is that which gives a channel
the same. The glaze is seen straight on; light that its surface turns back inside comes again, all outside of the critical angle.
"""

from functools import lru_cache

import numpy as np

from .spectrum import rgb_weights, standard_wavelengths

# Optical depths at which the color of a glaze is tabulated: 0, then so dense that reading between them costs 1e-4.
_DEPTHS = np.concatenate([[0.0], np.geomspace(1e-4, 70.0, 600)])
_THINNEST = 1e-3


@lru_cache(maxsize=64)
def tint_of_spectrum(
    wavelength_nm: tuple[float, ...],
    transmittance: tuple[float, ...],
    thickness: float,
    ior: float = 1.0,
    reflectance: float = 1.0,
    is_metal: bool = False,
    illuminant: str = "D65",
) -> tuple[float, float, float]:
    """The tint [r, g, b], linear Rec.709, each 0 to 1, with which a layer over a base shows the color that the spectrum gives it.

    `transmittance` (n,) is what one crossing of unit thickness leaves at increasing wavelengths (n,) in nm, linear between, constant beyond;
    `reflectance` is the base's, a diffuse one or a metal. Colors outside of Rec.709 are limited to what the layer can show.
    Raises LaminaError for wavelengths that do not increase and for an unknown illuminant.
    """
    nm, thickness = standard_wavelengths(), max(thickness, _THINNEST)
    depth = -np.log(np.maximum(np.interp(nm, wavelength_nm, transmittance), 1e-30)) * thickness
    shown = _metal_albedo if is_metal else _diffuse_albedo
    table = shown(_DEPTHS, ior, reflectance)
    color = np.interp(depth, _DEPTHS, table) @ rgb_weights(nm, illuminant)
    tau = np.interp(color, table[::-1], _DEPTHS[::-1])
    return tuple(np.exp(-tau / thickness).tolist())


def _surface_reflectance(ior: float) -> float:
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def _diffuse_albedo(depth: np.ndarray, ior: float, reflectance: float) -> np.ndarray:
    """Of a smooth glaze of optical depths (n,) over a diffuse base, less what its surface reflects; Fresnel's curve counts as a step."""
    turned, edge = _surface_reflectance(ior), np.sqrt(max(1.0 - 1.0 / ior**2, 0.0))
    x, w = np.polynomial.legendre.leggauss(32)

    def mean(low, high, crossings):
        cos = low + 0.5 * (high - low) * (x + 1.0)
        return (w * (high - low) * cos) @ np.exp(-crossings * depth / np.maximum(cos, 1e-9)[:, None])

    comes_again = turned * mean(edge, 1.0, 2.0) + mean(0.0, edge, 2.0)
    leaves = (1.0 - turned) * mean(edge, 1.0, 1.0)
    return (1.0 - turned) * np.exp(-depth) * reflectance * leaves / (1.0 - reflectance * comes_again)


def _metal_albedo(depth: np.ndarray, ior: float, reflectance: float) -> np.ndarray:
    """Of a smooth glaze of optical depths (n,) over a metal, less what its surface reflects."""
    turned, back = _surface_reflectance(ior), reflectance * np.exp(-2.0 * depth)
    return (1.0 - turned) ** 2 * back / (1.0 - turned * back)
