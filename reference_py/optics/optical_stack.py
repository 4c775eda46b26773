# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in optical terms: relative indices, alphas, optical depths, complex index of the base."""

from dataclasses import dataclass

import numpy as np

from ..material.schema import ANISOTROPY, THIN_FILM
from ..material.stack import Element, Stack
from .colour import artist_index, conductor_rgb
from .fresnel import fresnel_dielectric
from .microfacet import alpha_from_roughness, is_specular
from .thin_film import THINNEST_NM, Film, film_reflectance

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
class Interface:
    """One dielectric interface and the medium below it."""

    n_above: float
    n_below: float
    alpha: float
    """The root of both's mean square where the surface is anisotropic."""
    distribution: str
    tau: np.ndarray
    """Optical depth (3,) of one perpendicular crossing of the medium below."""
    brushed: AnisotropicRoughness | None = None
    film: Film | None = None

    @property
    def eta(self) -> float:
        """n_below / n_above."""
        return self.n_below / self.n_above

    def reflectance(self, cos_theta_i: np.ndarray) -> np.ndarray:
        """Fresnel reflectance for light from above, (..., 1), or (..., 3) with a film."""
        if self.film is None:
            return fresnel_dielectric(cos_theta_i, self.eta)[..., None]
        return film_reflectance(cos_theta_i, self.n_above, self.film, self.n_below)


def brushed(element: Element) -> AnisotropicRoughness | None:
    """How an element's surface is anisotropic, in Blender's convention; None if it is not. Cycles takes no alpha above 1."""
    if not element.has(ANISOTROPY):
        return None
    alpha = float(alpha_from_roughness(element["roughness"]))
    aspect = float(np.sqrt(1.0 - 0.9 * element["anisotropy"]))
    return AnisotropicRoughness(min(alpha / aspect, 1.0), alpha * aspect, 2.0 * np.pi * element["rotation"])


def film_of(element: Element) -> Film | None:
    """The thin film on an element's surface; None if it has none that Cycles would see."""
    if not element.has(THIN_FILM) or element["film_thickness"] <= THINNEST_NM:
        return None
    return Film(element["film_thickness"], element["film_ior"])


def mean_alpha(element: Element) -> float:
    """Alpha of an element's surface, or of the isotropic one that stands for it."""
    widths = brushed(element)
    return float(alpha_from_roughness(element["roughness"])) if widths is None else widths.alpha


def optical_depth(tint, thickness: float) -> np.ndarray:
    """tau (3,) of one perpendicular crossing: tint ** thickness is what it leaves (Weidlich07, eq. 5)."""
    return -np.log(np.maximum(np.asarray(tint, float), TINT_FLOOR)) * thickness


def interfaces(stack: Stack) -> tuple[Interface, ...]:
    """The dielectric interfaces from the top; vacuum above the first."""
    result, n_above = [], 1.0
    for layer in stack.layers:
        result.append(
            Interface(
                n_above=n_above,
                n_below=layer["ior"],
                alpha=mean_alpha(layer),
                distribution=layer["distribution"],
                tau=optical_depth(layer["tint"], layer["thickness"]),
                brushed=brushed(layer),
                film=film_of(layer),
            )
        )
        n_above = layer["ior"]
    return tuple(result)


def rough_surfaces(stack: Stack) -> list[tuple[str, float]]:
    """(distribution, alpha) of every surface that does something and is not smooth, from the top: where f can be narrow."""
    surfaces = [(s.distribution, s.alpha) for s in interfaces(stack) if s.eta != 1.0]
    if stack.base.kind == "conductor":
        surfaces.append((stack.base["distribution"], mean_alpha(stack.base)))
    return [(kind, alpha) for kind, alpha in surfaces if not is_specular(alpha)]


def n_above_base(stack: Stack) -> float:
    """Absolute index of the medium in contact with the base."""
    return stack.layers[-1]["ior"] if stack.layers else 1.0


def channels(stack: Stack) -> int:
    """Length of the colour axis: 3 for RGB, the number of wavelengths for a stack of `spectral`."""
    return len(stack.base["color"] if "color" in stack.base else conductor_index(stack.base)[0])


def conductor_index(base: Element) -> tuple[np.ndarray, np.ndarray]:
    """Absolute complex index (eta, k), each (3,), of a conductor base."""
    if "metal" in base:
        return conductor_rgb(base["metal"])
    if "eta" in base:
        return np.array(base["eta"]), np.array(base["k"])
    return artist_index(np.array(base["reflectance"]), np.array(base["edge_color"]))
