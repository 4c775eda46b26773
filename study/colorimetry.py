# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours as people see them, by colour-science, which the extra `figures` brings."""

import numpy as np

from ..reference_py.errors import LaminaError
from ..reference_py.optics.colour import xyz_to_rgb


def colour_science():
    """The module `colour`. Raises LaminaError, in one line, where it is missing."""
    try:
        import colour
    except ImportError:
        raise LaminaError("colour differences need colour-science: pip install lamina[figures]") from None
    return colour


def xyz_of_linear(rgb: np.ndarray) -> np.ndarray:
    """XYZ (..., 3) of linear Rec.709 (..., 3), Y = 1 for white."""
    return rgb @ np.linalg.inv(xyz_to_rgb(np.eye(3)))


def white() -> np.ndarray:
    """Chromaticity xy (2,) of Rec.709's white."""
    return colour_science().XYZ_to_xy(xyz_of_linear(np.ones(3)))


def lab(xyz: np.ndarray) -> np.ndarray:
    """CIE 1976 L*a*b* (..., 3) of XYZ (..., 3), Y = 1 for white."""
    return colour_science().XYZ_to_Lab(xyz, white())


def delta_e_2000(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """CIEDE2000 (...) of XYZ (..., 3), Y = 1 for white."""
    return colour_science().delta_E(lab(first), lab(second), method="CIE 2000")
