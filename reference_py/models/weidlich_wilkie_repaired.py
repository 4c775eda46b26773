# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07 with the repairs that need no further bounces.

- Jacobian: directions refract about the surface normal and a component below carries the solid angle's
  compression, f2* = f2 T(i) T(o) a (n0 / n1)^2 and p2* = p2 (n0 / n1)^2 cos(i) / cos(i').
- Weights: components are picked by the energy that each of them sends back at this view.
- No culling: facet samples that cannot leave are kept. Their wi points below the horizon, where f is 0, and `pdf`
  covers them, so its integral over the whole sphere is 1. A diffuse base is sampled in the cone that leaves alone:
  its p2 is n^2 cos(i') / pi there, its p2* cos(i) / pi. Trapped samples would be 1 - 1 / n^2 of all.

Still one bounce per interface, without the paper's compensation, which guessed the rest: light that an interface
turns back is lost, so a coated white base is too dark, by .57 to .68 (figures/stress.csv). `adding` sums all
bounces.

option  | default | meaning
------- | ------- | -------
weights | energy  | by which components are picked for samples: energy that each sends back at the view,
        |         | or constant, as in Weidlich07

>>> model = make_model("weidlich_wilkie_repaired", presets.load("metallic_car_paint"), weights="constant")
>>> model.component_weights(spherical(0.5, 0.0)).tolist()
[0.5, 0.5]
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ..errors import one_of
from ..material.stack import Stack
from ..optics.frame import DOWN, no_axis, per_direction, sampled
from ..optics.optical_stack import supports
from ..optics.quadrature import cosine_directions, points
from . import weidlich_wilkie_sampling as sampling
from .weidlich_wilkie import Level, WeidlichWilkie

WEIGHTS = ("energy", "constant")

_VIEWS, _POINTS = 24, 64


@supports("model", bases=None, distributions=None)
class WeidlichWilkieRepaired(WeidlichWilkie):
    """Weidlich and Wilkie 2007 with the solid angle of crossing accounted for.

    Raises LaminaError on an unknown option or choice.
    """

    name = "weidlich_wilkie_repaired"

    def __init__(self, stack: Stack, weights: str = WEIGHTS[0]):
        super().__init__(stack, refraction="macro_normal", compensation="none")
        self._weights = one_of(f"model {self.name}", "weights", weights, WEIGHTS)

    def _cross(self, surface, facets, level: Level) -> Level:
        below = super()._cross(surface, facets, level)
        return replace(below, throughput=below.throughput / surface.eta**2)

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo and whether it is valid, (...).

        Invalid ones lie below the horizon; they have a density and count as samples of value 0. They point straight
        down where no component has a finite f.
        """
        wi = np.broadcast_to(DOWN, wo.shape).copy()
        pick, u1, u2 = rng.random((3, len(wo)))
        # without the last sum, which rounding may leave below a pick
        bounds = np.cumsum(self.component_weights(wo), axis=-1)[:, :-1]
        chosen = np.sum(pick[:, None] >= bounds, axis=-1)
        for place, k in enumerate(self._finite):
            rows = np.flatnonzero(chosen == place)
            wi[rows] = self._sample_component(k, wo[rows], u1[rows], u2[rows])
        return wi, (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)

    @per_direction(no_axis)
    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample` for wi on the whole sphere; 0 for viewers below the horizon."""
        weights = self.component_weights(wo)
        total = sum((weights[..., i] * self._component_pdf(k, wo, wi) for i, k in enumerate(self._finite)), 0.0)
        return np.where(wo[..., 2] > 0.0, total, 0.0)

    @cached_property
    def _finite(self) -> list[int]:
        return sampling.finite_components(self)

    def _sample_component(self, k: int, wo, u1, u2) -> np.ndarray:
        if self.lobes[k] is None:
            return cosine_directions(u1, u2)
        n = sampling.index_above(self, k)
        inside = sampling.sample_component(self.lobes[k], sampling.enter(wo, n), u1, u2)
        outside, leaves = sampling.leave(inside, n)
        trapped = np.concatenate([inside[:, :2], -np.abs(inside[:, 2:])], axis=-1)
        return np.where(leaves[:, None], outside, trapped)

    def _component_pdf(self, k: int, wo, wi) -> np.ndarray:
        """Density of `_sample_component`: two kinds of trapped directions share the lower hemisphere."""
        lobe, n = self.lobes[k], sampling.index_above(self, k)
        if lobe is None:
            return np.maximum(wi[..., 2], 0.0) / np.pi
        wo_inside, wi_inside = sampling.enter(wo, n), sampling.enter(wi, n)
        jacobian = wi[..., 2] / (n * n * np.maximum(wi_inside[..., 2], 1e-30))
        above = sampling.component_density(lobe, wo_inside, wi_inside) * jacobian
        wi_down = wi * np.array([1.0, 1.0, -1.0])
        is_trapped = ~sampling.leave(wi_down, n)[1]
        below = sampling.component_density(lobe, wo_inside, wi)
        below = below + np.where(is_trapped, sampling.component_density(lobe, wo_inside, wi_down), 0.0)
        return np.where(wi[..., 2] > 0.0, above, below)

    def component_weights(self, wo: np.ndarray) -> np.ndarray:
        """Probability (..., K) of picking each of the K components with a finite f, from the top."""
        cosines, energies = self._energies
        cos_o = np.clip(np.asarray(wo, float)[..., 2], 0.0, 1.0)
        shares = np.empty(cos_o.shape + (len(energies),))
        for i, energy in enumerate(energies):
            shares[..., i] = np.interp(cos_o, cosines, energy)
        return shares / np.sum(shares, axis=-1, keepdims=True)

    @cached_property
    def _energies(self) -> tuple[np.ndarray, np.ndarray]:
        """Cosines (V,) and what each finite component sends back there, (K, V), as mean over RGB.

        An estimate by `_POINTS` samples of the component itself: weights need no more, and any that are positive
        wherever f is keep the samples unbiased.
        """
        cosines = np.square(np.linspace(0.02, 1.0, _VIEWS))  # closer towards grazing, where Fresnel changes fast
        if self._weights == "constant":
            return cosines, np.ones((len(self._finite), _VIEWS))
        wo = np.repeat(np.stack([np.sqrt(1.0 - cosines**2), 0.0 * cosines, cosines], axis=-1), _POINTS, axis=0)
        u1, u2 = (np.tile(u, _VIEWS) for u in points(_POINTS))
        energies = np.empty((len(self._finite), _VIEWS))
        for i, k in enumerate(self._finite):
            wi = self._sample_component(k, wo, u1, u2)
            value = np.mean(self.components(wo, wi)[k], axis=-1) * np.maximum(wi[:, 2], 0.0)
            density = np.maximum(self._component_pdf(k, wo, wi), 1e-30)
            energies[i] = np.mean((value / density).reshape(_VIEWS, _POINTS), axis=-1)
        # a black stack reflects nothing: then any weights do
        return cosines, np.where(np.sum(energies, axis=0) > 0.0, energies, 1.0)
