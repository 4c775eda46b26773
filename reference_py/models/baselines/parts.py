# SPDX-License-Identifier: GPL-3.0-or-later
"""What the baselines share: their signature, microfacet lobes, and one way to read a stack.

How a stack is read: every interface and metal has its index relative to the medium above it, absorption is the
color `round_trip` that two perpendicular crossings of all media leave. That is the best a user of these models can set.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...material.stack import Stack
from ...optics import microfacet
from ...optics.frame import color_axis, dot, half_vector, per_direction
from ...optics.fresnel import fresnel_conductor, fresnel_dielectric
from ...optics.microfacet import is_specular
from ...optics.optical_stack import OpticalStack
from ...optics.quadrature import directional_albedo

_UP = np.array([0.0, 0.0, 1.0])
# The cosine at which an F82 curve takes its second value, and Schlick's rise there.
COS_82 = 1.0 / 7.0
_RISE_82 = (1.0 - COS_82) ** 5

Fresnel = Callable[[np.ndarray], np.ndarray]
"""Reflectance (..., 1) or (..., 3) at cosines (...) to the facet."""


class Baseline:
    """A model of the shared signature. Subclasses give `_f`, and `_widths` and `_specular_albedo` where they have lobes.

    The colour axis, written (..., 3) below, has `channels` entries.
    """

    name: str
    stochastic = False

    def __init__(self, stack: Stack):
        self.stack, self.optics = stack, OpticalStack.of(stack, self)
        self.channels = self.optics.channels

    @per_direction(color_axis)
    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like parts have none and count as 0."""
        visible = ((wo[..., 2] > 0.0) & (wi[..., 2] > 0.0))[..., None]
        return np.where(visible, self._f(np.where(visible, wo, _UP), np.where(visible, wi, _UP)), 0.0)

    @per_direction(color_axis)
    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like parts included; 0 for views below the surface."""
        visible = wo[..., 2:] > 0.0
        return np.where(visible, self._albedo(np.where(visible, wo, _UP)), 0.0)

    def _f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """f (..., 3) for directions above the surface."""
        raise NotImplementedError

    def _albedo(self, wo: np.ndarray) -> np.ndarray:
        """Albedo (n, 3) for views above the surface."""
        return directional_albedo(self.f, wo, self._widths()) + self._specular_albedo(wo[..., 2])

    def _widths(self) -> Sequence[tuple[str, float]]:
        """(distribution, alpha) of the lobes, for the quadrature."""
        return []

    def _specular_albedo(self, cos_o: np.ndarray) -> np.ndarray:
        """Energy (..., 3) of mirror-like lobes."""
        return np.zeros(cos_o.shape + (self.channels,))


@dataclass(frozen=True)
class Lobe:
    """A microfacet reflection lobe, D G2 F / (4 cos_i cos_o) (Walter07)."""

    alpha: float
    distribution: str
    fresnel: Fresnel

    @property
    def width(self) -> tuple[str, float]:
        """(distribution, alpha), as the quadrature takes it."""
        return self.distribution, self.alpha

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """(..., 1) or (..., 3) for directions above the surface; 0 for a mirror."""
        wh = half_vector(wi, wo)
        if is_specular(self.alpha):
            return np.zeros(wh.shape[:-1] + (1,))
        d = microfacet.distribution(wh[..., 2], self.alpha, self.distribution)
        g = microfacet.masking_g2(wi[..., 2], wo[..., 2], self.alpha, self.distribution)
        value = d * g / (4.0 * np.maximum(wi[..., 2] * wo[..., 2], 1e-30))
        return self.fresnel(np.clip(dot(wi, wh), 0.0, 1.0)) * value[..., None]

    def specular_albedo(self, cos_o: np.ndarray) -> np.ndarray:
        """Energy (..., 1) or (..., 3) of a mirror; 0 for a rough lobe."""
        return self.fresnel(cos_o) * (1.0 if is_specular(self.alpha) else 0.0)


def dielectric(eta: float) -> Fresnel:
    """Exact curve of a dielectric, (..., 1)."""
    return lambda cos: fresnel_dielectric(cos, eta)[..., None]


def conductor(eta: np.ndarray, k: np.ndarray) -> Fresnel:
    """Exact curve of a metal of relative index eta + i k, (..., 3)."""
    return lambda cos: fresnel_conductor(cos[..., None], eta, k)


def schlick(f0: np.ndarray) -> Fresnel:
    """f0 + (1 - f0) (1 - cos)^5 (Schlick94), shaped like f0."""
    return lambda cos: f0 + (1.0 - f0) * ((1.0 - cos) ** 5)[..., None]


def f82(f0: np.ndarray, reflectance_82: np.ndarray) -> Fresnel:
    """Schlick's curve with a dip that makes it reflectance_82 at 82 degrees (Kutz21); both (3,)."""
    drop = (f0 + (1.0 - f0) * _RISE_82 - reflectance_82) / (COS_82 * (1.0 - COS_82) * _RISE_82)

    def fresnel(cos):
        rise = ((1.0 - cos) ** 5)[..., None]
        return np.clip(f0 + (1.0 - f0) * rise - drop * (cos * (1.0 - cos))[..., None] * rise, 0.0, 1.0)

    return fresnel


def interface_lobe(optics: OpticalStack, index: int) -> Lobe:
    """Lobe of interface `index` of a stack."""
    surface = optics.interfaces[index]
    return Lobe(surface.alpha, surface.distribution, dielectric(surface.eta))


def metal_lobe(optics: OpticalStack) -> Lobe | None:
    """Lobe of a conductor base under its medium; None over a diffuse base."""
    facets = optics.base.facets
    return None if facets is None else Lobe(facets.alpha, facets.distribution, optics.base.reflectance)


def metal_f0(optics: OpticalStack) -> np.ndarray:
    """Reflectance (3,) of a conductor base at normal incidence, under its medium."""
    return optics.base.reflectance(np.ones(()))


def metal_colors(optics: OpticalStack) -> tuple[np.ndarray, np.ndarray]:
    """`metal_f0`, and the share, at most 1, of Schlick's curve that the metal reflects at 82 degrees; each (3,)."""
    f0 = metal_f0(optics)
    return f0, np.minimum(optics.base.reflectance(np.full((), COS_82)) / (f0 + (1.0 - f0) * _RISE_82), 1.0)


def metal_f82(optics: OpticalStack) -> Fresnel:
    """The F82 curve of `metal_colors`."""
    f0, tint = metal_colors(optics)
    return f82(f0, tint * (f0 + (1.0 - f0) * _RISE_82))


def dielectric_f0(eta: float) -> float:
    """Reflectance of an interface at normal incidence."""
    return ((eta - 1.0) / (eta + 1.0)) ** 2
