# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear Rec.709 as reflectance spectra, for formats that hold spectra alone: a choice among many, which gives back the color under D65."""

import json
from functools import lru_cache
from pathlib import Path

import numpy as np

FILE = Path(__file__).parents[2] / "data" / "rgb_spectra.json"


@lru_cache(maxsize=1)
def _primaries() -> tuple[np.ndarray, np.ndarray]:
    entry = json.loads(FILE.read_text(encoding="utf-8"))
    return np.array(entry["wavelength_nm"]), np.array([entry[name] for name in ("red", "green", "blue")])


def upsampled(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (n,) in nm, and spectra (..., n) of linear Rec.709 (..., 3): the mixture of those of the primaries (`study.make_rgb_spectra`).

    What is positive stays so, grey is flat, and `reflectance_to_rgb` gives back the color to 1e-5.
    """
    wavelength_nm, primaries = _primaries()
    return wavelength_nm, np.asarray(rgb, float) @ primaries
