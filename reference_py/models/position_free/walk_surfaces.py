# SPDX-License-Identifier: GPL-3.0-or-later
"""What a walk meets: smooth and rough dielectric interfaces from both sides, and the opaque bases.

All share `is_delta`, `scatter(w, from_below, rng, target)` and `density(w, o, from_below)`, in the frame of
`optics.microsurface`: w and o (n, 3) leave the surface, w_z > 0 whichever side that is.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...optics import microsurface
from ...optics.bases import ConductorBase, DiffuseBase
from ...optics.directions import vectors
from ...optics.interface import Interface, Microfacets
from ...optics.optical_stack import OpticalStack
from ...optics.thin_film import FilmInterface
from .media import ScatteringMedium

# Share of a cosine lobe in the density that weights a `multiple` surface's paths against each other.
# Any share is unbiased; some is needed where the walk leaves far from the single-scattering lobe.
_COSINE_SHARE = 0.1


@dataclass(frozen=True, eq=False, repr=False)
class Event:
    """Directions (n, 3) after a surface, their energy (n, 3) or None where it is all, and BSDF cos at the target."""

    direction: np.ndarray
    weight: np.ndarray | None
    toward: np.ndarray | None = None


class SmoothDielectric:
    """A mirror-like interface; also one between equal indices, where nothing happens."""

    is_delta = True

    def __init__(self, eta: float, film: FilmInterface | None = None):
        self.eta, self.film = eta, film

    def _relative(self, from_below: bool) -> float:
        return 1.0 / self.eta if from_below else self.eta

    def _fresnel(self, cos, eta):
        if eta == 1.0:
            return np.zeros(len(cos)), cos
        return microsurface.fresnel_and_refraction(cos, eta)

    def scatter(self, w, from_below, rng, target=None) -> Event:
        """Reflection or refraction by chance, as Fresnel's shares are; a film's channels differ, and weigh."""
        eta = self._relative(from_below)
        reflectance, cos_t = self._fresnel(w[:, 2], eta)
        reflected, weight = microsurface.chosen(reflectance, w[:, 2], cos_t, self.film, not from_below, rng)
        along = np.where(reflected, -1.0, -1.0 / eta)
        return Event(vectors(along * w[:, 0], along * w[:, 1], np.where(reflected, w[:, 2], -cos_t)), weight)

    def split(self, w, rng) -> Event:
        """From above, with 2 n rows: reflection for certain, weighted by its share, and then refraction of the rest."""
        reflectance, cos_t = self._fresnel(w[:, 2], self.eta)
        reflected, weight, (w, cos_t) = microsurface.split(reflectance, w, cos_t)
        along = np.where(reflected, -1.0, -1.0 / self.eta)
        return Event(vectors(along * w[:, 0], along * w[:, 1], np.where(reflected, w[:, 2], -cos_t)), weight[:, None])

    def transmit(self, w, from_below, rng) -> Event:
        """Refraction for certain, weighted by its share."""
        eta = self._relative(from_below)
        reflectance, cos_t = self._fresnel(w[:, 2], eta)
        if self.film is not None:
            reflectance = self.film.reflectance(w[:, 2], cos_t, not from_below).T
        return Event(vectors(-w[:, 0] / eta, -w[:, 1] / eta, -cos_t), np.atleast_2d(1.0 - reflectance).T)

    def density(self, w, o, from_below) -> np.ndarray:
        """Transmittance, times d(w) / d(o) from above: of the two directions' deltas only the ratio matters."""
        reflectance, cos_t = self._fresnel(w[:, 2], self._relative(from_below))
        if self.film is not None:
            reflectance = self.film.reflectance(w[:, 2], cos_t, not from_below).mean(axis=1)
        transmittance = 1.0 - reflectance
        if from_below:
            return transmittance
        return transmittance * self.eta**2 * np.abs(o[:, 2]) / w[:, 2]


class _Rough:
    """Widths of a rough surface. An anisotropic one turns directions into its own frame and back."""

    def _set_widths(self, facets: Microfacets) -> None:
        widths = facets.anisotropic
        self.alpha, self.distribution = facets.alpha if widths is None else (widths.alpha_x, widths.alpha_y), facets.distribution
        self._turn = None if widths is None else (np.cos(widths.angle), np.sin(widths.angle))

    def _own(self, w: np.ndarray) -> np.ndarray:
        if self._turn is None:
            return w
        c, s = self._turn
        return vectors(c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0], w[:, 2])

    def _back(self, w: np.ndarray) -> np.ndarray:
        if self._turn is None:
            return w
        c, s = self._turn
        return vectors(c * w[:, 0] - s * w[:, 1], c * w[:, 1] + s * w[:, 0], w[:, 2])


class RoughDielectric(_Rough):
    """An interface of microfacets; `surface` says how many of them light may meet (`optics.microsurface`)."""

    is_delta = False

    def __init__(self, eta: float, facets: Microfacets, surface: str, film: FilmInterface | None = None):
        self.eta, self.surface, self.film = eta, surface, film
        self._set_widths(facets)

    def _relative(self, from_below: bool) -> float:
        return 1.0 / self.eta if from_below else self.eta

    def scatter(self, w, from_below, rng, target=None) -> Event:
        """One direction per w off the facets; BSDF cos at the target is estimated on the way."""
        eta, target = self._relative(from_below), None if target is None else self._own(target)
        scattered = microsurface.scatter_dielectric(self._own(w), eta, self.alpha, self.distribution, rng, self.surface, target, self.film, not from_below)
        weight = None if self.surface == "multiple" and self.film is None else _columns(scattered.weight)
        toward = None if target is None else _columns(scattered.toward)
        return Event(self._back(scattered.direction), weight, toward)

    def split(self, w, rng) -> Event:
        """From above, with 2 n rows: what the first facets reflect, and then what they let pass."""
        scattered = microsurface.scatter_dielectric(self._own(w), self.eta, self.alpha, self.distribution, rng, self.surface, both=True)
        return Event(self._back(scattered.direction), scattered.weight[:, None])

    def transmit(self, w, from_below, rng) -> Event:
        """As `scatter`; what is reflected has weight 0."""
        scattered = microsurface.scatter_dielectric(
            self._own(w), self._relative(from_below), self.alpha, self.distribution, rng, self.surface, None, self.film, not from_below
        )
        passed = (scattered.direction[:, 2] < 0.0)[:, None]
        return Event(self._back(scattered.direction), np.where(passed, _columns(scattered.weight), 0.0))

    def density(self, w, o, from_below) -> np.ndarray:
        """Density (n,) in 1/sr by which paths are weighted: single scattering's, with a share of a cosine lobe for `multiple`."""
        eta = self._relative(from_below)
        density = microsurface.scattering_density(self._own(w), self._own(o), eta, self.alpha, self.distribution, self.film, not from_below)
        return _with_cosine_lobe(density, o, self.surface)


class Diffuse:
    """A base that scatters as its own `f` says, sampled by the cosine."""

    is_delta = False

    def __init__(self, base: DiffuseBase):
        self._f = base.f

    def scatter(self, w, from_below, rng, target=None) -> Event:
        """A direction of density cos / pi; its weight is pi f."""
        u = rng.random(len(w))
        radius, phi = np.sqrt(u), 2.0 * np.pi * rng.random(len(w))
        o = vectors(radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1.0 - u))
        toward = None if target is None else self._f(target, w) * target[:, 2:]
        return Event(o, np.pi * self._f(o, w), toward)

    def density(self, w, o, from_below) -> np.ndarray:
        """cos / pi, (n,) in 1/sr."""
        return o[:, 2] / np.pi


class SmoothConductor:
    """A mirror-like metal; `reflectance` is its reflectance (n, 3) at cosines (n,)."""

    is_delta = True

    def __init__(self, reflectance: Callable[[np.ndarray], np.ndarray]):
        self.reflectance = reflectance

    def scatter(self, w, from_below, rng, target=None) -> Event:
        """The mirror direction, weighted by Fresnel's reflectance."""
        return Event(vectors(-w[:, 0], -w[:, 1], w[:, 2]), self.reflectance(w[:, 2]))

    def density(self, w, o, from_below) -> np.ndarray:
        """(n,) of 1: of the two directions' deltas only the ratio matters."""
        return np.ones(len(w))


class RoughConductor(_Rough):
    """A metal of microfacets; `fresnel` is a facet's reflectance (n, 3) at cosines (n,)."""

    is_delta = False

    def __init__(self, fresnel: Callable[[np.ndarray], np.ndarray], facets: Microfacets, surface: str):
        self._fresnel, self.surface = fresnel, surface
        self._set_widths(facets)

    def scatter(self, w, from_below, rng, target=None) -> Event:
        """One direction per w off the facets; BSDF cos at the target is estimated on the way."""
        target = None if target is None else self._own(target)
        scattered = microsurface.scatter_conductor(self._own(w), self._fresnel, self.alpha, self.distribution, rng, self.surface, target)
        return Event(self._back(scattered.direction), scattered.weight, scattered.toward)

    def density(self, w, o, from_below) -> np.ndarray:
        """Density (n,) in 1/sr by which paths are weighted, as of `RoughDielectric`."""
        density = microsurface.scattering_density(self._own(w), self._own(o), None, self.alpha, self.distribution)
        return _with_cosine_lobe(density, o, self.surface)


def _columns(values: np.ndarray) -> np.ndarray:
    """(n, 1) of (n,); (n, 3) as it is."""
    return values if values.ndim == 2 else values[:, None]


def _with_cosine_lobe(density, o, surface) -> np.ndarray:
    if surface == "single":
        return density
    return (1.0 - _COSINE_SHARE) * density + _COSINE_SHARE / np.pi * np.abs(o[:, 2])


class Surfaces:
    """The surfaces of a stack from the top, the base last, and the media between them.

    tau[i] (3,) belongs to the medium between surfaces i and i + 1, or is None if that is clear; media[i] is it where it scatters.
    n_above[i] is the index above surface i.
    """

    def __init__(self, optics: OpticalStack, surface: str):
        self.all = [_dielectric(layer, surface) for layer in optics.interfaces] + [_base(optics.base, surface)]
        self.tau = [layer.tau if np.any(layer.tau > 0.0) else None for layer in optics.interfaces]
        self.media = [None if s.scattering is None else ScatteringMedium(s, f"layer {i}") for i, s in enumerate(optics.interfaces)]
        self.channels = optics.channels
        self.n_above = [layer.n_above for layer in optics.interfaces] + [optics.base.n_above]

    def __len__(self) -> int:
        return len(self.all)


def _dielectric(layer: Interface, surface: str):
    film = None if layer.film is None else FilmInterface(layer.n_above, layer.n_below, layer.film)
    if layer.facets.is_specular or (layer.eta == 1.0 and film is None):
        return SmoothDielectric(layer.eta, film)
    return RoughDielectric(layer.eta, layer.facets, surface, film)


def _base(base: DiffuseBase | ConductorBase, surface: str):
    if base.facets is None:
        return Diffuse(base)
    if base.is_specular:
        return SmoothConductor(base.reflectance)
    return RoughConductor(base.reflectance, base.facets, surface)
