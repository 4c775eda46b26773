# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes data/rgb_spectra.json: `python -m lamina.study.make_rgb_spectra` (needs scipy).

Reflectances of the three primaries of linear Rec.709 with the least squared slopes that are positive, sum to 1 at every wavelength, and have the
colors (1, 0, 0), (0, 1, 0) and (0, 0, 1) under D65: so do mixtures. The idea of Mallett and Yuksel 2019, on the piecewise linear spectra of here.
"""

import json

import numpy as np
from scipy.optimize import nnls

from ..reference_py.atomic import write_text
from ..reference_py.optics.colour.spectrum import rgb_weights
from ..reference_py.optics.colour.upsampling import FILE

WAVELENGTH_NM = np.arange(380.0, 781.0, 20.0)
# Of the conditions against the slopes; they hold to 1e-5.
_WEIGHT = 1e3

ABOUT = (
    "Reflectances of the primaries of linear Rec.709 (CIE 1931 2-degree observer, D65): positive, summing to 1, with the least squared slopes. "
    "Linear between wavelengths, constant beyond them. Written by lamina.study.make_rgb_spectra."
)


def primaries() -> np.ndarray:
    """(3, n) reflectances on WAVELENGTH_NM."""
    n = len(WAVELENGTH_NM)
    slopes = np.kron(np.eye(3), np.diff(np.eye(n), axis=0))
    sums, colors = np.kron(np.ones((1, 3)), np.eye(n)), np.kron(np.eye(3), rgb_weights(WAVELENGTH_NM).T)
    wanted = np.concatenate([np.zeros(len(slopes)), _WEIGHT * np.ones(n), _WEIGHT * np.eye(3).ravel()])
    return nnls(np.vstack([slopes, _WEIGHT * sums, _WEIGHT * colors]), wanted, maxiter=10_000)[0].reshape(3, n)


def main() -> None:
    """Write the file."""
    rounded = np.round(primaries(), 6).tolist()
    entry = {"about": ABOUT, "wavelength_nm": WAVELENGTH_NM.tolist(), **dict(zip(("red", "green", "blue"), rounded))}
    write_text(FILE, json.dumps(entry, indent=1) + "\n")


if __name__ == "__main__":
    main()
