# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour and metals: spectra to linear Rec.709, measured metals, the artist-friendly conductor.

Convention everywhere: CIE 1931 2-degree observer, illuminant D65 where no other is named, Rec.709 primaries
with D65 as white, so a perfect white reflector is (1, 1, 1), under another illuminant by Bradford's adaptation. Wavelengths are in nm; RGB is linear
and the last axis. Tables in ../data are read on first use, not on import.
"""

from .artist import artist_color, artist_index
from .difference import ciede2000, lab_of_linear
from .metals import conductor_rgb, load_metal, metal_index, metal_names
from .spaces import canonical, is_known, known_spaces, srgb_encoded, to_linear_rec709
from .spectrum import reflectance_to_rgb, reflectance_to_xyz, resample, rgb_weights, standard_wavelengths, xyz_to_rgb
from .tint import tint_of_spectrum
from .upsampling import upsampled

__all__ = [
    "artist_color",
    "artist_index",
    "canonical",
    "ciede2000",
    "conductor_rgb",
    "is_known",
    "known_spaces",
    "lab_of_linear",
    "load_metal",
    "metal_index",
    "metal_names",
    "reflectance_to_rgb",
    "reflectance_to_xyz",
    "resample",
    "rgb_weights",
    "srgb_encoded",
    "standard_wavelengths",
    "tint_of_spectrum",
    "to_linear_rec709",
    "upsampled",
    "xyz_to_rgb",
]
