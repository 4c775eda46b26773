# SPDX-License-Identifier: GPL-3.0-or-later
"""What one facet reflects in one channel: curves over the cosine that are equal, and hash alike, where they are the same function.

A thin film's curve is read from a table, good to 1e-4 for films of up to 2000 nm: its formula costs ten times as much.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .fresnel import cos_theta_t, fresnel_conductor, fresnel_dielectric
from .thin_film import Film, film_reflectance

# Cells of a film's table over the cosine.
_CELLS = 4096


@dataclass(frozen=True)
class DielectricFacet:
    """A facet between two media of absolute index, met from the side of `n_own`; `channel` is that of its film's color, 0 without one."""

    n_own: float
    n_other: float
    film: Film | None = None
    channel: int = 0

    @property
    def eta(self) -> float:
        """n_other / n_own, in travel direction."""
        return self.n_other / self.n_own

    @property
    def turned(self) -> "DielectricFacet":
        """The same facet, met from its other side."""
        return replace(self, n_own=self.n_other, n_other=self.n_own)

    def __call__(self, cos_theta: np.ndarray) -> np.ndarray:
        """Reflectance at cosines of this side (...); 1 under total reflection."""
        if self.film is None:
            return fresnel_dielectric(cos_theta, self.eta)
        # both sides reflect alike
        thin, dense = sorted((self.n_own, self.n_other))
        return _film_table(thin, self.film, dense, None, self.channel).read(cos_theta, self.n_own)


@dataclass(frozen=True)
class ConductorFacet:
    """A facet of a metal of absolute index eta + i k below a medium of index `n_above`; `channel` is that of its film's color, 0 without one."""

    n_above: float
    metal_eta: float
    metal_k: float
    film: Film | None = None
    channel: int = 0

    def __call__(self, cos_theta: np.ndarray) -> np.ndarray:
        """Reflectance at cosines (...)."""
        if self.film is None:
            return fresnel_conductor(cos_theta, self.metal_eta / self.n_above, self.metal_k / self.n_above)
        return _film_table(self.n_above, self.film, self.metal_eta, self.metal_k, self.channel).read(cos_theta, self.n_above)


Facet = DielectricFacet | ConductorFacet


@dataclass(frozen=True, eq=False, repr=False)
class _FilmTable:
    """Reflectance of a channel at even cosines in the thinnest medium, of index `n`: elsewhere critical angles are roots, which a table would miss."""

    n: float
    values: np.ndarray

    def read(self, cos_theta: np.ndarray, n_own: float) -> np.ndarray:
        """Reflectance at cosines (...) in a medium of index `n_own`."""
        place = cos_theta_t(np.clip(cos_theta, 0.0, 1.0), self.n / n_own) * _CELLS
        cell = np.minimum(place.astype(int), _CELLS - 1)
        between = place - cell
        return self.values[cell] * (1.0 - between) + self.values[cell + 1] * between


# those of a metal's bake over a film's thickness
@lru_cache(maxsize=256)
def _film_table(n_above: float, film: Film, n_below: float, k_below: float | None, channel: int) -> _FilmTable:
    n = min(n_above, film.faded_ior(n_above), *(() if k_below is not None else (n_below,)))
    cosines = cos_theta_t(np.linspace(0.0, 1.0, _CELLS + 1), n_above / n)
    return _FilmTable(n, film_reflectance(cosines, n_above, film, n_below, k_below, slice(channel, channel + 1))[:, 0])
