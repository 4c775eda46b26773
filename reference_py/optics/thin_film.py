# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance of an interface with a film so thin that light interferes in it, per RGB channel (Belcour17).

As Cycles computes it from Blender 5.0 on: Airy's sum as a series in the optical path difference, whose terms meet the
Fourier transform of each channel's color matching function under an equal-energy light; three terms are kept.
Blender 4.5 has the paper's Gaussian fit of the functions instead. Below 1 nm the film's index fades to the medium's.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from .colour.spectrum import observer_rgb
from .fresnel import cos_theta_t

TERMS = 3
# The transform is known at this many even steps of 2 pi times the path difference in nm, and constant beyond; Cycles' own.
STEPS, LAST_PHASE_NM = 512, 60000.0
# Cycles takes thinner films for none.
THINNEST_NM = 0.1
_ALL = slice(None)


@dataclass(frozen=True)
class Film:
    """A film: thickness in nm and absolute index of refraction."""

    thickness_nm: float
    ior: float

    def faded_ior(self, n_above: float) -> float:
        """The index that light from a medium of index `n_above` meets, which below 1 nm fades to that."""
        t = min(max(self.thickness_nm, 0.0), 1.0)
        return n_above + (self.ior - n_above) * t * t * (3.0 - 2.0 * t)


@dataclass(frozen=True)
class Films:
    """Films of stacks that are computed at once, of which each has three channels; None where one has no film."""

    each: tuple[Film | None, ...]


def film_of_channel(film: Film | Films | None, channel: int) -> tuple[Film | None, int]:
    """The film that a channel sees, and of which of its colors the channel is, 0 without one."""
    own = film.each[channel // 3] if isinstance(film, Films) else film
    return own, 0 if own is None else channel % 3


@dataclass(frozen=True)
class FilmInterface:
    """A dielectric interface with a film, met from either side."""

    n_above: float
    n_below: float
    film: Film

    def reflectance(self, cos_here: np.ndarray, cos_beyond: np.ndarray, from_above: np.ndarray) -> np.ndarray:
        """(n, 3) of light on the given side, of known cosines on both; 1 where nothing goes beyond."""
        cos_above = np.where(from_above, cos_here, cos_beyond)
        value = film_reflectance(cos_above, self.n_above, self.film, self.n_below)
        return np.where(((cos_here <= 0.0) | (cos_beyond <= 0.0))[:, None], 1.0, value)


@cache
def sensitivities() -> np.ndarray:
    """Complex transform (STEPS, 3) of the channels' color matching functions, 1 at path difference 0."""
    wavelength_nm, matching = observer_rgb()
    fine = np.arange(wavelength_nm[0], wavelength_nm[-1] + 0.5)
    weights = np.stack([np.interp(fine, wavelength_nm, channel) for channel in matching.T], axis=-1)
    phase = np.linspace(0.0, LAST_PHASE_NM, STEPS)
    return np.exp(-1j * phase[:, None] / fine) @ (weights / weights.sum(axis=0))


def film_reflectance(
    cos_theta_i: np.ndarray, n_above: float, film: Film, n_below, k_below=None, channels: slice = _ALL, curve_below: Callable | None = None
) -> np.ndarray:
    """Unpolarised reflectance (..., 3), or of some of the channels, for light from above; n_below and k_below are numbers or (3,), k for conductors.

    `curve_below` gives a conductor's reflectance (..., 3) at cosines (...) inside the film instead; the phases stay.
    """
    cos_1 = np.clip(np.asarray(cos_theta_i, float), 0.0, 1.0)[..., None]
    ior = film.faded_ior(n_above)
    cos_2 = cos_theta_t(cos_1, ior / n_above)
    r_s, r_p = _amplitudes(cos_1, cos_2, n_above, ior)
    reflected_above = np.square(r_s), np.square(r_p)
    if k_below is None:
        cos_3 = cos_theta_t(cos_2, n_below / ior)
        below = _amplitudes(cos_2, cos_3, ior, n_below)
        is_total = (cos_2 <= 0.0) | (cos_3 <= 0.0)
    else:
        below = _conductor_amplitudes(cos_2, ior, np.asarray(n_below) + 1j * np.asarray(k_below))
        is_total = cos_2 <= 0.0
    if curve_below is not None:
        below = tuple(np.sqrt(curve_below(cos_2[..., 0])) * r / np.maximum(np.abs(r), 1e-300) for r in below)
    path = 2.0 * ior * film.thickness_nm * cos_2
    total = 0.0
    for r12, energy, r23 in zip((r_s, r_p), reflected_above, below):
        total = total + 0.5 * _airy(r12, energy, r23, path, channels)
    return np.where(is_total, 1.0, np.clip(total, 0.0, 1.0))


def _amplitudes(cos_i, cos_t, n_i, n_t):
    """Real amplitudes (s, p) of reflection at a dielectric interface; p so that both agree in sign at the normal."""
    with np.errstate(invalid="ignore", divide="ignore"):
        r_s = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t)
        r_p = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t)
    same = np.asarray(n_i == n_t)
    return np.where(same, 0.0, r_s), np.where(same, 0.0, r_p)


def _conductor_amplitudes(cos_i, n_i, index):
    """Complex amplitudes (s, p) at a conductor of complex index, with the signs of `_amplitudes` (Born and Wolf 1999, 14.4)."""
    inner = np.sqrt(np.square(index) - n_i**2 * (1.0 - np.square(cos_i)))
    r_s = (n_i * cos_i - inner) / (n_i * cos_i + inner)
    r_p = (np.square(index) * cos_i - n_i * inner) / (np.square(index) * cos_i + n_i * inner)
    return r_s, r_p


def _airy(r12, energy_12, r23, path, channels: slice):
    """Reflectance of one polarisation (Belcour17, eq. 10)."""
    energy_23 = np.square(np.abs(r23))
    both = energy_12 * energy_23
    # reflection from below turns the sign; a vanishing amplitude has any phase
    phasor = np.where(np.abs(r23) > 0.0, r23 / np.maximum(np.abs(r23), 1e-300), 1.0) * np.where(r12 >= 0.0, -1.0, 1.0)
    transmitted = 1.0 - energy_12
    once = np.square(transmitted) * energy_23 / np.maximum(1.0 - both, 1e-9)
    total, term, turn = energy_12 + once, once - transmitted, np.ones_like(phasor)
    for order in range(1, TERMS + 1):
        term, turn = term * np.sqrt(both), turn * phasor
        at = _sensitivity(order * path, channels)
        total = total + 2.0 * term * (turn.real * at.real + turn.imag * at.imag)
    return total


def _sensitivity(path_nm, channels: slice):
    """The transform (..., channels) at path differences (..., 1 or as many)."""
    place = np.clip(2.0 * np.pi * path_nm / LAST_PHASE_NM, 0.0, 1.0) * (STEPS - 1)
    cell = np.minimum(place.astype(int), STEPS - 2)
    table, channel = sensitivities(), np.arange(3)[channels]
    between = place - cell
    return table[cell, channel] * (1.0 - between) + table[cell + 1, channel] * between
