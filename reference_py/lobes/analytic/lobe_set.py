# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic`: adding over the interfaces at shading time, for parameters that vary from point to point."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...material.qualities import ANALYTIC
from ...material.stack import Stack
from ...optics.bases import ConductorBase, DiffuseBase
from ...optics.optical_stack import OpticalStack, supports
from ..lobe import DielectricCurve, DiffuseLobe, GlossyLobe, oren_nayar_lobes
from ..own_normals import about_own_normals
from ..view_table import MIN_COS_O
from .base import Facets, bare_metal, gauss, metal_lobe, uniform_below
from .beam import Crossing, cosine, through
from .calibration import LOBE_BEND
from .interface_tables import closure_energy, top_gain

# Gauss nodes of the mean albedo of an Oren-Nayar base.
ALBEDO_NODES = 8


@supports("lobe set")
class AnalyticLobes:
    """At most three closures, or two and a diffuse base's one or two, whatever the number of layers.

    The top interface has the exact Fresnel curve and its lossless energy; all deeper interfaces share one glossy
    lobe; the base has one. Every energy is divided by that of its closure, so albedos are those of the adding.
    """

    name = ANALYTIC
    is_live, followed = True, ()

    def __init__(self, stack: Stack):
        self.stack = stack
        optics = OpticalStack.of(stack, self)
        surfaces, self.base = optics.interfaces, optics.base
        self._down = [Crossing(s.n_above, s.n_below, s.alpha, s.distribution, s.tau) for s in surfaces]
        self._up = [Crossing(s.n_below, s.n_above, s.alpha, s.distribution, s.tau) for s in reversed(surfaces)]

    def with_values_of(self, stack: Stack) -> "AnalyticLobes":
        """The same for a stack's own values."""
        return type(self)(stack)

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.lobes(np.ones(1)))

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes from the top for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        cos_o, index = np.unique(np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0), return_inverse=True)
        index = index.reshape(np.shape(cos_theta_o))
        return [at_views(lobe, index) for lobe in self.lobes_of(cos_o)]

    def lobes_of(
        self, cos_o: np.ndarray, top_alpha: np.ndarray | None = None, base_facets: Callable[[np.ndarray], Facets] | None = None
    ) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views (n,), whatever their order; `top_alpha` (n,) is what they see of the top's.

        `base_facets` gives those of a metal base for the cosines (n,) of the beams that reach it.
        """
        p = np.sqrt(1.0 - np.square(cos_o))
        passage = through(self._down, p, np.zeros_like(p), top_alpha)
        result: list[GlossyLobe | DiffuseLobe] = []
        if self._down:
            result.append(self._top_lobe(cos_o, top_alpha))
        if len(self._down) > 1:
            alpha = lobe_alpha(passage.inner_variance, cos_o)
            result.append(glossy(self._down[1].distribution, passage.inner, alpha, cos_o))
        return about_own_normals(self.stack, result + self._base_lobes(cos_o, passage, base_facets), len(result))

    def _top_lobe(self, cos_o, seen_alpha) -> GlossyLobe:
        top = self._down[0]
        eta = top.n_other / top.n_own
        weight = top_gain(cos_o, top.alpha if seen_alpha is None else seen_alpha, eta, top.distribution)[..., None] * np.ones(3)
        alpha = np.asarray(top.alpha) * np.ones_like(cos_o)
        return GlossyLobe(top.distribution, weight, alpha, alpha, fresnel=DielectricCurve(eta))

    def _base_lobes(self, cos_o, passage, base_facets) -> list[GlossyLobe | DiffuseLobe]:
        match self.base:
            case ConductorBase():
                return self._metal_lobes(cos_o, passage, base_facets)
            case DiffuseBase():
                return self._diffuse_lobes(cos_o, passage)

    def _diffuse_lobes(self, cos_o, passage) -> list[DiffuseLobe]:
        base, n = self.base, self.base.n_above
        own = base.albedo(np.minimum(cosine(passage.p, n), 1.0))
        energy = own
        if self._down:
            u, w = gauss(ALBEDO_NODES)
            mean = np.sum((2.0 * w * u)[:, None] * base.albedo(u), axis=-2, keepdims=True)
            back, out = uniform_below(self._down, self._up, n)
            energy = passage.transmitted * own * out / (1.0 - mean * back)
        if np.all(base.sigma_deg == 0.0):
            return [DiffuseLobe(energy)]
        return oren_nayar_lobes(energy / np.maximum(base.albedo(cos_o), 1e-12), base.color, base.sigma_deg)

    def _metal_lobes(self, cos_o, passage, base_facets) -> list[GlossyLobe | DiffuseLobe]:
        base, n = self.base, self.base.n_above
        alpha, distribution = base.facets.alpha, base.facets.distribution
        eta, k = base.relative_index
        reaches = cosine(passage.p, n)
        facets = base_facets(reaches) if base_facets else Facets((alpha, alpha), closure_energy(reaches, alpha, distribution))
        if not self._down:
            return [glossy(distribution, bare_metal(cos_o, alpha, distribution, eta, k, facets), alpha * np.ones_like(cos_o), cos_o)]
        lobe = metal_lobe(self._up, n, passage.p, passage.variance, alpha, distribution, eta, k, facets)
        variance = 2.0 * passage.variance + np.square(2.0 * n * reaches * alpha)
        energy = passage.transmitted * (lobe.first + lobe.later)
        return [glossy(distribution, energy, lobe_alpha(variance, cos_o), cos_o)]


def at_views(lobe, index):
    """The lobe at the views that `index` picks."""
    if isinstance(lobe, DiffuseLobe):
        return replace(lobe, weight=lobe.weight[index])
    return replace(lobe, weight=lobe.weight[index], alpha_x=lobe.alpha_x[index], alpha_y=lobe.alpha_y[index])


def lobe_alpha(variance, cos_o) -> np.ndarray:
    """Alpha (...) outside of a lobe whose p has this variance: facets of that slope spread p as much.

    A slope m changes p by 2 cos_o m + LOBE_BEND sin_o m^2; the second term keeps grazing lobes from growing without bound.
    """
    bend = LOBE_BEND * np.sqrt(1.0 - np.square(cos_o))
    spread = np.sqrt(variance)
    return np.minimum(spread / (cos_o + np.sqrt(np.square(cos_o) + bend * spread)), 1.0)


def glossy(distribution: str, energy, alpha, cos_o) -> GlossyLobe:
    """A glossy lobe of the given energy (..., 3)."""
    return GlossyLobe(distribution, energy / np.maximum(closure_energy(cos_o, alpha, distribution), 1e-3)[..., None], alpha, alpha)
