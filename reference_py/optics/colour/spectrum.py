# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance spectra to CIE XYZ and linear Rec.709 (CIE 015:2018; ITU-R BT.709-6 for the primaries).

The RGB matrix comes from the primaries and the white that the tables themselves integrate to, so white is
(1, 1, 1) to rounding. Channels may leave [0, 1] for colours outside the gamut: nothing is clipped here.
"""

import json
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...errors import LaminaError, one_of
from .spaces import adaptation

OBSERVER_FILE = Path(__file__).parents[2] / "data" / "cie1931_2deg.json"

# x, y of the red, green and blue primary
REC709_PRIMARIES = np.array([[0.640, 0.330], [0.300, 0.600], [0.150, 0.060]])


@lru_cache(maxsize=1)
def _tables() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (81,) and the weights (81, 3) that turn a reflectance on them into XYZ, Y of white being 1."""
    table = json.loads(OBSERVER_FILE.read_text(encoding="utf-8"))
    weights = _observer(table) * np.array(table["d65"])[:, None]
    weights /= weights[:, 1].sum()
    wavelength_nm = np.array(table["wavelength_nm"], float)
    for array in (wavelength_nm, weights):
        array.setflags(write=False)
    return wavelength_nm, weights


def _observer(table: dict) -> np.ndarray:
    return np.array([table["x_bar"], table["y_bar"], table["z_bar"]]).T


@lru_cache(maxsize=1)
def _rgb_from_xyz() -> np.ndarray:
    """(3, 3) matrix from XYZ to linear Rec.709: columns of its inverse are the primaries, scaled to sum to white."""
    x, y = REC709_PRIMARIES.T
    primaries = np.array([x / y, np.ones(3), (1.0 - x - y) / y])
    white = _tables()[1].sum(axis=0)
    matrix = np.linalg.inv(primaries * np.linalg.solve(primaries, white))
    matrix.setflags(write=False)
    return matrix


def standard_wavelengths() -> np.ndarray:
    """Wavelengths of the observer table: 380 to 780 nm in 5 nm steps, (81,). Read-only."""
    return _tables()[0]


def resample(wavelength_nm: np.ndarray, values: np.ndarray, new_wavelength_nm: np.ndarray) -> np.ndarray:
    """Values (..., n) on increasing wavelengths (n,), linearly interpolated on new wavelengths (m,): (..., m).

    Beyond the first and last wavelength the end values hold.
    Raises LaminaError when wavelengths do not increase or the shapes differ.
    """
    wavelength_nm, values = _checked(wavelength_nm), np.asarray(values, float)
    if values.shape[-1:] != wavelength_nm.shape:
        raise LaminaError(f"Spectrum of shape {values.shape} needs {wavelength_nm.size} values on its last axis")
    return values @ _interpolation(wavelength_nm, np.asarray(new_wavelength_nm, float))


def observer_rgb() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (81,) and the color matching functions (81, 3) of linear Rec.709 on them, without an illuminant."""
    table = json.loads(OBSERVER_FILE.read_text(encoding="utf-8"))
    return standard_wavelengths(), _observer(table) @ _rgb_from_xyz().T


def rgb_weights(wavelength_nm: np.ndarray, illuminant: str = "D65") -> np.ndarray:
    """Weights (n, 3): `reflectance @ weights` is linear Rec.709 for a reflectance on these wavelengths (n,).

    The reflectance counts as piecewise linear, constant beyond its ends. White is (1, 1, 1) under every illuminant (Bradford).
    Raises LaminaError unless increasing, and for an unknown illuminant.
    """
    if illuminant == "D65":
        return _xyz_weights(wavelength_nm) @ _rgb_from_xyz().T
    table_nm, d65 = _tables()
    table = json.loads(OBSERVER_FILE.read_text(encoding="utf-8"))
    weights = _observer(table) * illuminant_power(table_nm, illuminant)[:, None]
    weights = weights / weights[:, 1].sum()
    adapted = weights @ adaptation(weights.sum(axis=0), d65.sum(axis=0)).T
    return _interpolation(_checked(wavelength_nm), table_nm) @ adapted @ _rgb_from_xyz().T


def illuminant_power(wavelength_nm: np.ndarray, illuminant: str) -> np.ndarray:
    """Relative spectral power (n,) of illuminant A, lamp light (CIE 015:2018, eq. 1), or E, of equal energy. Raises LaminaError for others."""
    one_of("colour", "illuminant", illuminant, ("A", "E"))
    nm = np.asarray(wavelength_nm, float)
    if illuminant == "E":
        return np.ones(nm.shape)
    return 100.0 * (560.0 / nm) ** 5 * np.expm1(1.435e7 / (2848.0 * 560.0)) / np.expm1(1.435e7 / (2848.0 * nm))


def reflectance_to_xyz(reflectance: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
    """XYZ (..., 3) under D65, Y = 1 for white, of spectral reflectances (..., n) on wavelengths (n,)."""
    return _integrate(reflectance, _xyz_weights(wavelength_nm))


def xyz_to_rgb(xyz: np.ndarray) -> np.ndarray:
    """Linear Rec.709 (..., 3) of XYZ (..., 3) with Y = 1 for the D65 white. Not clipped."""
    return np.asarray(xyz, float) @ _rgb_from_xyz().T


def reflectance_to_rgb(reflectance: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
    """Linear Rec.709 (..., 3) under D65 of spectral reflectances (..., n) on wavelengths (n,). Not clipped.

    Raises LaminaError when wavelengths do not increase or the last axis does not fit.
    """
    return _integrate(reflectance, rgb_weights(wavelength_nm))


def _integrate(reflectance: np.ndarray, weights: np.ndarray) -> np.ndarray:
    reflectance = np.asarray(reflectance, float)
    if reflectance.shape[-1:] != weights.shape[:1]:
        raise LaminaError(f"Spectrum of shape {reflectance.shape} needs {len(weights)} values on its last axis")
    return reflectance @ weights


def _xyz_weights(wavelength_nm: np.ndarray) -> np.ndarray:
    table_nm, weights = _tables()
    return _interpolation(_checked(wavelength_nm), table_nm) @ weights


def _checked(wavelength_nm: np.ndarray) -> np.ndarray:
    wavelength_nm = np.asarray(wavelength_nm, float)
    if wavelength_nm.ndim != 1 or wavelength_nm.size == 0 or not np.all(np.diff(wavelength_nm) > 0.0):
        raise LaminaError(f"Wavelengths must be a list that increases, in nm; got {wavelength_nm.tolist()}")
    return wavelength_nm


def _interpolation(from_nm: np.ndarray, to_nm: np.ndarray) -> np.ndarray:
    """(n, m) matrix of linear interpolation with constant ends: values @ matrix."""
    return np.array([np.interp(to_nm, from_nm, unit) for unit in np.eye(from_nm.size)])
