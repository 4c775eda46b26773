# SPDX-License-Identifier: GPL-3.0-or-later
"""Varnishes over matte white, as spectra: the yellow one of Weidlich07's figure 5, also as RGB, and others beside it.

The paper prints no absorption coefficient. Ours are single smooth bands, the yellow one about as strong for a crossing
of unit thickness as the tint of the preset `tinted_glaze`.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import reflectance_to_rgb, standard_wavelengths
from ...reference_py.optics.spectral import gaussian_band, spectral_stack
from ...reference_py.registry import make_model
from .seen_colors import xyz_of_rgb, xyz_of_spectra
from .sphere import Picture, render

THICKNESS = (0.0, 0.4, 0.8, 1.6, 3.0, 5.0, 15.0)
# centre and standard deviation in nm, and optical depth at the centre of a crossing of unit thickness
BANDS = {"yellow": (435.0, 42.0, 1.6), "magenta": (540.0, 42.0, 0.8), "cyan": (630.0, 55.0, 0.8), "brown": (400.0, 130.0, 1.0)}
WAVELENGTH_NM = standard_wavelengths()[::2]  # every 10 nm


def optical_depth(varnish: str = "yellow") -> np.ndarray:
    """Optical depth (41,) of a perpendicular crossing of unit thickness of one of `BANDS`."""
    return gaussian_band(WAVELENGTH_NM, *BANDS[varnish])


def rgb_tint() -> np.ndarray:
    """The tint (3,) an artist would set for the yellow varnish: the colour of white light after the same crossing, limited to 1."""
    return np.clip(reflectance_to_rgb(np.exp(-optical_depth()), WAVELENGTH_NM), 0.0, 1.0)


def with_thickness(thickness: float) -> Stack:
    """The preset `tinted_glaze` with another thickness and the tint of `rgb_tint`."""
    stack = presets.load("tinted_glaze")
    layer = stack.layers[0].with_values(thickness=thickness, tint=tuple(rgb_tint()))
    return replace(stack, layers=(layer,))


def spectral_varnish(thickness: float, varnish: str = "yellow") -> Stack:
    """The same with the absorption of each wavelength, of any of `BANDS`."""
    return spectral_stack(with_thickness(thickness), WAVELENGTH_NM, tints={0: np.exp(-optical_depth(varnish))})


@lru_cache(maxsize=16)
def varnished_sphere(thickness: float, size: int, is_spectral: bool = True) -> tuple[np.ndarray, Picture]:
    """XYZ (size, size, 3) and the picture it comes from."""
    stack = spectral_varnish(thickness) if is_spectral else with_thickness(thickness)
    picture = render(make_model("weidlich_wilkie", stack), size)
    return (xyz_of_spectra(picture.radiance, WAVELENGTH_NM) if is_spectral else xyz_of_rgb(picture.radiance)), picture
