# SPDX-License-Identifier: GPL-3.0-or-later
"""The opaque bases: what each reflects, in the medium above it."""

from dataclasses import dataclass

import numpy as np

from ..material.stack import Base
from .colour import artist_index, conductor_rgb
from .diffuse import oren_nayar, oren_nayar_1994, oren_nayar_albedo
from .facet_reflectance import ConductorFacet
from .fresnel import fresnel_conductor
from .interface import Microfacets, film_of
from .thin_film import Film, Films, film_of_channel, film_reflectance


@dataclass(frozen=True, eq=False, repr=False)
class DiffuseBase:
    """A base whose facets are diffuse (`diffuse.oren_nayar`); Lambert is the one of level facets, sigma 0."""

    n_above: float
    color: np.ndarray
    sigma_deg: float = 0.0

    facets = None
    is_specular = False

    @classmethod
    def of(cls, base: Base, n_above: float) -> "DiffuseBase":
        """That of a base which has a color, and may have a slope deviation, below a medium of index `n_above`."""
        return cls(n_above, np.array(base["color"], float), base["sigma_deg"] if "sigma_deg" in base else 0.0)

    @property
    def channels(self) -> int:
        """Length of the colour axis."""
        return self.color.shape[-1]

    def channel_key(self, channel: int):
        """Equal for channels that this base treats alike."""
        return float(self.color[channel])

    def f(self, wi: np.ndarray, wo: np.ndarray, qualitative: bool = False) -> np.ndarray:
        """f (..., channels) in 1/sr, for directions above it; `qualitative` is the model of OrenNayar94."""
        if self.sigma_deg == 0.0:
            return np.broadcast_to(self.color / np.pi, (*np.broadcast_shapes(wi.shape, wo.shape)[:-1], self.channels))
        return (oren_nayar_1994 if qualitative else oren_nayar)(wi, wo, self.color, self.sigma_deg)

    def albedo(self, cos_theta_o: np.ndarray) -> np.ndarray:
        """Directional albedo (..., channels)."""
        if np.all(self.sigma_deg == 0.0):
            return np.broadcast_to(self.color, np.broadcast_shapes((*np.shape(cos_theta_o), self.channels), np.shape(self.color)))
        return oren_nayar_albedo(cos_theta_o, self.color, self.sigma_deg)


@dataclass(frozen=True, eq=False, repr=False)
class ConductorBase:
    """A metal of absolute complex index eta + i k, each (channels,)."""

    n_above: float
    eta: np.ndarray
    k: np.ndarray
    facets: Microfacets
    film: Film | Films | None = None

    @classmethod
    def of(cls, base: Base, n_above: float) -> "ConductorBase":
        """That of a base which is given by name, by index or by its colors, below a medium of index `n_above`."""
        return cls(n_above, *conductor_index(base), Microfacets.of(base), film_of(base))

    @property
    def channels(self) -> int:
        """Length of the colour axis."""
        return self.eta.shape[-1]

    @property
    def is_specular(self) -> bool:
        """Whether the metal is smooth, so that it has no finite f."""
        return self.facets.is_specular

    @property
    def relative_index(self) -> tuple[np.ndarray, np.ndarray]:
        """eta and k over the index of the medium above, each (channels,)."""
        n = np.asarray(self.n_above)[..., None]
        return self.eta / n, self.k / n

    def facet(self, channel: int) -> ConductorFacet:
        """What a facet reflects in a channel."""
        return ConductorFacet(self.n_above, float(self.eta[channel]), float(self.k[channel]), *film_of_channel(self.film, channel))

    def channel_key(self, channel: int):
        """Equal for channels that this base treats alike."""
        return self.facet(channel)

    def reflectance(self, cos_theta_i: np.ndarray) -> np.ndarray:
        """Fresnel reflectance (..., channels) of a facet that light meets at these cosines, with its film."""
        if isinstance(self.film, Films):
            return np.stack([self.facet(c)(cos_theta_i) for c in range(self.channels)], axis=-1)
        if self.film is not None:
            return film_reflectance(cos_theta_i, self.n_above, self.film, self.eta, self.k)
        return fresnel_conductor(np.asarray(cos_theta_i)[..., None], *self.relative_index)


def conductor_index(base: Base) -> tuple[np.ndarray, np.ndarray]:
    """Absolute complex index (eta, k), each (channels,), of a conductor base."""
    if "metal" in base:
        return conductor_rgb(base["metal"])
    if "eta" in base:
        return np.array(base["eta"]), np.array(base["k"])
    return artist_index(np.array(base["reflectance"]), np.array(base["edge_color"]))
