# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured complex indices of metals: spectral (data/metals/*.json) and per RGB channel (data/metals_rgb.json)."""

import json
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import LaminaError
from .spectrum import resample

METALS_FOLDER = Path(__file__).parents[2] / "data" / "metals"
RGB_FILE = METALS_FOLDER.with_name("metals_rgb.json")


class Metal(NamedTuple):
    """Published table of one metal: wavelength_nm, n, k are (samples,); doi is empty where the source has none."""

    name: str
    label: str
    source: str
    doi: str
    wavelength_nm: np.ndarray
    n: np.ndarray
    k: np.ndarray


@lru_cache(maxsize=1)
def metal_names() -> tuple[str, ...]:
    """Names of the metals, in alphabetical order: one per file in data/metals."""
    return tuple(sorted(path.stem for path in METALS_FOLDER.glob("*.json")))


def load_metal(name: str) -> Metal:
    """The published table of a metal. Raises LaminaError for an unknown name."""
    _require(name, metal_names())
    table = json.loads((METALS_FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    return Metal(*(table[f] if isinstance(table[f], str) else np.array(table[f], float) for f in Metal._fields))


def metal_index(name: str, wavelength_nm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Complex index (n, k), each (m,), of a metal on wavelengths (m,) in nm, linear between published samples.

    Raises LaminaError for an unknown metal and for wavelengths that its table does not cover.
    """
    metal = load_metal(name)
    wavelength_nm = np.asarray(wavelength_nm, float)
    first, last = metal.wavelength_nm[[0, -1]]
    if not np.all((wavelength_nm >= first) & (wavelength_nm <= last)):
        raise LaminaError(f"Metal {name!r} is tabulated from {first:g} to {last:g} nm; got {wavelength_nm.tolist()} nm")
    n, k = resample(metal.wavelength_nm, np.array([metal.n, metal.k]), wavelength_nm)
    return n, k


def conductor_rgb(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Absolute complex index (eta, k), each (3,), whose Fresnel reflectance in air is the metal's in linear Rec.709.

    Fitted by `study.make_metals_rgb`, with the error in data/metals_rgb.json. Raises LaminaError for an unknown name.
    """
    table = _rgb_table()
    _require(name, tuple(table))
    return np.array(table[name]["eta"]), np.array(table[name]["k"])


@lru_cache(maxsize=1)
def _rgb_table() -> dict[str, dict]:
    return json.loads(RGB_FILE.read_text(encoding="utf-8"))["metals"]


def _require(name: str, choices: tuple[str, ...]) -> None:
    if name not in choices:
        raise LaminaError(f"Unknown metal {name!r}; choose one of {', '.join(choices)}")
