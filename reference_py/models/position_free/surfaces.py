# SPDX-License-Identifier: GPL-3.0-or-later
"""What a walk meets: smooth and rough dielectric interfaces from both sides, and the opaque bases.

All share `is_delta`, `scatter(w, from_below, rng, target)` and `density(w, o, from_below)`, in the frame of
`optics.microsurface`: w and o (n, 3) leave the surface, w_z > 0 whichever side that is.
"""

from dataclasses import dataclass

import numpy as np

from ...optics import microsurface
from ...optics.diffuse import oren_nayar
from ...optics.fresnel import fresnel_conductor
from ...optics.material import Interface, conductor_index, interfaces, n_above_base
from ...optics.microfacet import alpha_from_roughness, is_specular
from ...optics.sampling import vectors
from ...stack import Stack

# Share of a cosine lobe in the density that weights a `multiple` surface's paths against each other.
# Any share is unbiased; some is needed where the walk leaves far from the single-scattering lobe.
_COSINE_SHARE = 0.1


@dataclass(frozen=True)
class Event:
    """Directions (n, 3) after a surface, their energy (n, 3) or None where it is all, and BSDF cos at the target."""

    direction: np.ndarray
    weight: np.ndarray | None
    toward: np.ndarray | None = None


class SmoothDielectric:
    """A mirror-like interface; also one between equal indices, where nothing happens."""

    is_delta = True

    def __init__(self, eta: float):
        self.eta = eta

    def _relative(self, from_below: bool) -> float:
        return 1.0 / self.eta if from_below else self.eta

    def _fresnel(self, cos, eta):
        if eta == 1.0:
            return np.zeros(len(cos)), cos
        return microsurface.fresnel_and_refraction(cos, eta)

    def scatter(self, w, from_below, rng, target=None) -> Event:
        eta = self._relative(from_below)
        reflectance, cos_t = self._fresnel(w[:, 2], eta)
        reflected = rng.random(len(w)) < reflectance
        along = np.where(reflected, -1.0, -1.0 / eta)
        return Event(vectors(along * w[:, 0], along * w[:, 1], np.where(reflected, w[:, 2], -cos_t)), None)

    def transmit(self, w, from_below, rng) -> Event:
        """Refraction for certain, weighted by its share."""
        eta = self._relative(from_below)
        reflectance, cos_t = self._fresnel(w[:, 2], eta)
        return Event(vectors(-w[:, 0] / eta, -w[:, 1] / eta, -cos_t), 1.0 - reflectance)

    def density(self, w, o, from_below) -> np.ndarray:
        """Transmittance, times d(w) / d(o) from above: of the two directions' deltas only the ratio matters."""
        transmittance = 1.0 - self._fresnel(w[:, 2], self._relative(from_below))[0]
        if from_below:
            return transmittance
        return transmittance * self.eta**2 * np.abs(o[:, 2]) / w[:, 2]


class RoughDielectric:
    is_delta = False

    def __init__(self, eta: float, alpha: float, kind: str, surface: str):
        self.eta, self.alpha, self.kind, self.surface = eta, alpha, kind, surface

    def _relative(self, from_below: bool) -> float:
        return 1.0 / self.eta if from_below else self.eta

    def scatter(self, w, from_below, rng, target=None) -> Event:
        eta = self._relative(from_below)
        scattered = microsurface.scatter_dielectric(w, eta, self.alpha, self.kind, rng, self.surface, target)
        weight = None if self.surface == "multiple" else scattered.weight[:, None]
        toward = None if target is None else scattered.toward[:, None]
        return Event(scattered.direction, weight, toward)

    def transmit(self, w, from_below, rng) -> Event:
        """As `scatter`; what is reflected has weight 0."""
        scattered = microsurface.scatter_dielectric(
            w, self._relative(from_below), self.alpha, self.kind, rng, self.surface
        )
        return Event(scattered.direction, np.where(scattered.direction[:, 2] < 0.0, scattered.weight, 0.0))

    def density(self, w, o, from_below) -> np.ndarray:
        density = microsurface.scattering_density(w, o, self._relative(from_below), self.alpha, self.kind)
        return _with_cosine_lobe(density, o, self.surface)


class Diffuse:
    """Lambert or Oren-Nayar."""

    is_delta = False

    def __init__(self, color: np.ndarray, sigma_deg: float):
        self.color, self.sigma_deg = np.asarray(color, float), sigma_deg

    def _f(self, w, o) -> np.ndarray:
        if self.sigma_deg == 0.0:
            return self.color[None, :] / np.pi
        return oren_nayar(o, w, self.color, self.sigma_deg)

    def scatter(self, w, from_below, rng, target=None) -> Event:
        u = rng.random(len(w))
        radius, phi = np.sqrt(u), 2.0 * np.pi * rng.random(len(w))
        o = vectors(radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1.0 - u))
        toward = None if target is None else self._f(w, target) * target[:, 2:]
        return Event(o, np.pi * self._f(w, o), toward)

    def density(self, w, o, from_below) -> np.ndarray:
        return o[:, 2] / np.pi


class SmoothConductor:
    is_delta = True

    def __init__(self, eta: np.ndarray, k: np.ndarray):
        self.eta, self.k = eta, k

    def scatter(self, w, from_below, rng, target=None) -> Event:
        return Event(vectors(-w[:, 0], -w[:, 1], w[:, 2]), fresnel_conductor(w[:, 2:], self.eta, self.k))

    def density(self, w, o, from_below) -> np.ndarray:
        return np.ones(len(w))


class RoughConductor:
    is_delta = False

    def __init__(self, eta: np.ndarray, k: np.ndarray, alpha: float, kind: str, surface: str):
        self.eta, self.k = eta, k
        self.alpha, self.kind, self.surface = alpha, kind, surface

    def _fresnel(self, cos) -> np.ndarray:
        return np.stack([fresnel_conductor(cos, eta, k) for eta, k in zip(self.eta, self.k)]).T

    def scatter(self, w, from_below, rng, target=None) -> Event:
        scattered = microsurface.scatter_conductor(w, self._fresnel, self.alpha, self.kind, rng, self.surface, target)
        return Event(scattered.direction, scattered.weight, scattered.toward)

    def density(self, w, o, from_below) -> np.ndarray:
        density = microsurface.scattering_density(w, o, None, self.alpha, self.kind)
        return _with_cosine_lobe(density, o, self.surface)


def _with_cosine_lobe(density, o, surface) -> np.ndarray:
    if surface == "single":
        return density
    return (1.0 - _COSINE_SHARE) * density + _COSINE_SHARE / np.pi * np.abs(o[:, 2])


class Surfaces:
    """The surfaces of a stack from the top, the base last, and the media between them.

    tau[i] (3,) belongs to the medium between surfaces i and i + 1, or is None if that is clear;
    n_above[i] is the index above surface i.
    """

    def __init__(self, stack: Stack, surface: str):
        dielectrics = interfaces(stack)
        self.all = [_dielectric(layer, surface) for layer in dielectrics] + [_base(stack, surface)]
        self.tau = [layer.tau if np.any(layer.tau > 0.0) else None for layer in dielectrics]
        self.n_above = [layer.n_above for layer in dielectrics] + [n_above_base(stack)]

    def __len__(self) -> int:
        return len(self.all)


def _dielectric(layer: Interface, surface: str):
    if is_specular(layer.alpha) or layer.eta == 1.0:
        return SmoothDielectric(layer.eta)
    return RoughDielectric(layer.eta, layer.alpha, layer.distribution, surface)


def _base(stack: Stack, surface: str):
    base = stack.base
    if base.kind != "conductor":
        return Diffuse(base["color"], base["sigma_deg"] if "sigma_deg" in base else 0.0)
    eta, k = (index / n_above_base(stack) for index in conductor_index(base))
    alpha = float(alpha_from_roughness(base["roughness"]))
    if is_specular(alpha):
        return SmoothConductor(eta, k)
    return RoughConductor(eta, k, alpha, base["distribution"], surface)
