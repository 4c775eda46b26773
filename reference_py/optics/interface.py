# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces between media: facets, the interface of a layer, and how a stack's values become them."""

from dataclasses import dataclass

import numpy as np

from ..material.schema import ANISOTROPY, THIN_FILM
from ..material.stack import Base, Layer
from .facet_reflectance import DielectricFacet
from .fresnel import fresnel_dielectric
from .microfacet import alpha_from_roughness, is_specular
from .scattering import Scattering, medium_of
from .thin_film import THINNEST_NM, Film, Films, film_of_channel, film_reflectance

# A tint of 0 means black after any thickness; the floor keeps tau finite in float32 too.
TINT_FLOOR = 1e-30


@dataclass(frozen=True)
class AnisotropicRoughness:
    """Widths of an anisotropic surface, along and across a direction that is `angle` in radians from the tangent."""

    alpha_x: float
    alpha_y: float
    angle: float

    @property
    def alpha(self) -> float:
        """That of the isotropic surface that stands for it, of as much variance of slopes."""
        return float(np.sqrt(0.5 * (self.alpha_x**2 + self.alpha_y**2)))


@dataclass(frozen=True)
class Microfacets:
    """The facets of a surface; `alpha` is the root of both's mean square where it is anisotropic."""

    distribution: str
    alpha: float
    anisotropic: AnisotropicRoughness | None = None

    @classmethod
    def of(cls, element: Layer | Base) -> "Microfacets":
        """Those of a layer or base, in Blender's convention of anisotropy. Cycles takes no alpha above 1."""
        alpha = alpha_from_roughness(element["roughness"])
        if not element.has(ANISOTROPY):
            return cls(element["distribution"], alpha)
        aspect = float(np.sqrt(1.0 - 0.9 * element["anisotropy"]))
        widths = AnisotropicRoughness(min(alpha / aspect, 1.0), alpha * aspect, 2.0 * np.pi * element["rotation"])
        return cls(element["distribution"], widths.alpha, widths)

    @property
    def is_specular(self) -> bool:
        """Whether the surface is smooth, so that it has no finite f."""
        return is_specular(self.alpha)


@dataclass(frozen=True, eq=False, repr=False)
class Interface:
    """One dielectric interface and the medium below it."""

    n_above: float
    n_below: float
    facets: Microfacets
    tau: np.ndarray
    """Optical depth (channels,) of one perpendicular crossing of the medium below, what is scattered counted."""
    film: Film | Films | None = None
    scattering: Scattering | None = None
    """That of the medium below; None where it only absorbs."""

    @classmethod
    def of(cls, layer: Layer, n_above: float) -> "Interface":
        """That of a layer below a medium of absolute index `n_above`."""
        tau, scattering = medium_of(layer, optical_depth(layer["tint"], layer["thickness"]))
        return cls(n_above, layer["ior"], Microfacets.of(layer), tau, film_of(layer), scattering)

    @property
    def alpha(self) -> float:
        """The facets' alpha."""
        return self.facets.alpha

    @property
    def distribution(self) -> str:
        """Name of the facets' distribution."""
        return self.facets.distribution

    @property
    def eta(self) -> float:
        """n_below / n_above."""
        return self.n_below / self.n_above

    @property
    def does_nothing(self) -> bool:
        """Whether light passes it as if it were not there, whatever its roughness."""
        return self.eta == 1.0 and self.film is None

    def facet(self, channel: int) -> DielectricFacet:
        """What a facet reflects in a channel of light from above."""
        return DielectricFacet(self.n_above, self.n_below, *film_of_channel(self.film, channel))

    def reflectance(self, cos_theta_i: np.ndarray) -> np.ndarray:
        """Fresnel reflectance for light from above, (..., 1), or (..., 3) with a film, or (..., channels) with films."""
        if self.film is None:
            return fresnel_dielectric(cos_theta_i, self.eta)[..., None]
        if isinstance(self.film, Films):
            return np.stack([self.facet(c)(cos_theta_i) for c in range(len(self.tau))], axis=-1)
        return film_reflectance(cos_theta_i, self.n_above, self.film, self.n_below)


def film_of(element: Layer | Base) -> Film | Films | None:
    """The thin film on an element's surface, or those of several stacks; None if it has none that Cycles would see."""
    if not element.has(THIN_FILM):
        return None
    thickness, ior = element["film_thickness"], element["film_ior"]
    if isinstance(thickness, tuple):
        return Films(tuple(map(_film, thickness, ior)))
    return _film(thickness, ior)


def _film(thickness_nm: float, ior: float) -> Film | None:
    return Film(thickness_nm, ior) if thickness_nm > THINNEST_NM else None


def optical_depth(tint, thickness: float) -> np.ndarray:
    """tau (3,) of one perpendicular crossing: tint ** thickness is what it leaves (Weidlich07, eq. 5)."""
    return -np.log(np.maximum(np.asarray(tint, float), TINT_FLOOR)) * thickness
