# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic` for stacks with brushed surfaces, which its own arithmetic does not know.

The top lobe has its surface's exact widths, deeper ones as far as their width is their own surface's, and every
lobe's weight is of its own energy at the azimuth of the view. A view crosses the top as one of the isotropic surface that it sees
there; what other anisotropic surfaces do to light that crosses them has no direction.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from ...material.stack import Stack
from ...optics.interface import AnisotropicRoughness, Microfacets
from ..brushing import isotropic
from ..lobe import DiffuseLobe, GlossyLobe
from ..view_table import MIN_COS_O
from .base import Facets
from .interface_tables import anisotropic_energy, closure_energy
from .lobe_set import AnalyticLobes, at_views


class BrushedLobes(AnalyticLobes):
    """The lobes of the stack without anisotropy, in the shapes that it gives them."""

    def __init__(self, stack: Stack):
        self.stack, self._plain = stack, AnalyticLobes(isotropic(stack))
        self.base = self._plain.base

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes from the top for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        cos_o, phi = np.broadcast_arrays(np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0), np.asarray(phi, float))
        views, index = np.unique(cos_o + 1j * phi, return_inverse=True)
        return [at_views(lobe, index.reshape(cos_o.shape)) for lobe in self._lobes(views.real, views.imag)]

    def _lobes(self, cos_o, phi):
        layers, base = self.stack.layers, self.stack.base
        top, metal = (_widths(e) if e is not None and "roughness" in e else None for e in (layers[0] if layers else None, base))
        seen = None if top is None else seen_alpha(top, cos_o, phi)
        facets = None if metal is None else partial(_facets, widths=metal, phi=phi, distribution=base["distribution"])
        lobes = self._plain.lobes_of(cos_o, seen, facets)
        indices = [1.0, *(layer["ior"] for layer in layers)]
        # the top, all deeper layers as the second, and the base, which may have two lobes
        inner = min(len(layers), 2)
        elements = [*layers[:inner], *[base] * (len(lobes) - inner)]
        depths = [*range(inner), *[len(layers)] * (len(lobes) - inner)]
        return [
            _shaped(lobe, _widths(element) if "roughness" in element else None, indices[depth], cos_o, phi, depth == 0 and len(layers) > 0)
            for lobe, element, depth in zip(lobes, elements, depths)
        ]


def _widths(element) -> AnisotropicRoughness | None:
    return Microfacets.of(element).anisotropic


def seen_alpha(widths: AnisotropicRoughness, cos_o, phi) -> np.ndarray:
    """Alpha (...) of the isotropic interface that reflects as much of the view as an anisotropic one.

    Along the normal all of its slopes count alike, at grazing views those along the plane of incidence. Its reflectance is good to
    .01 of the light to 60 degrees and to .035 at 80, across (tests/reference_py/test_anisotropy.py).
    """
    along, across = np.square(_sides(widths, phi))
    return np.sqrt((along + np.square(cos_o) * across) / (1.0 + np.square(cos_o)))


def _sides(widths: AnisotropicRoughness, phi) -> tuple[np.ndarray, np.ndarray]:
    """Alphas (...) along and across the plane of incidence."""
    cos, sin = np.cos(phi - widths.angle), np.sin(phi - widths.angle)
    return np.hypot(widths.alpha_x * cos, widths.alpha_y * sin), np.hypot(widths.alpha_x * sin, widths.alpha_y * cos)


def _facets(cos_theta, widths: AnisotropicRoughness, phi, distribution: str) -> Facets:
    x2, y2 = widths.alpha_x**2, widths.alpha_y**2
    white = anisotropic_energy(cos_theta, phi - widths.angle, widths.alpha_x, widths.alpha_y, distribution)
    return Facets(_sides(widths, phi), white, (x2 - y2) / max(x2 + y2, 1e-20))


def _shaped(lobe, widths: AnisotropicRoughness | None, n: float, cos_o: np.ndarray, phi: np.ndarray, is_top: bool):
    if widths is None:
        return lobe
    if is_top:
        return replace(lobe, alpha_x=np.full(cos_o.shape, widths.alpha_x), alpha_y=np.full(cos_o.shape, widths.alpha_y), frame=widths.angle)
    inner = np.sqrt(np.maximum(1.0 - (1.0 - np.square(cos_o)) / n**2, 0.0))
    share = np.clip(np.square(n * inner * widths.alpha / (cos_o * np.maximum(lobe.alpha_x, 1e-12))), 0.0, 1.0)
    stretch = [alpha / max(widths.alpha, 1e-12) for alpha in (widths.alpha_x, widths.alpha_y)]
    alpha_x, alpha_y = (np.minimum(lobe.alpha_x * np.sqrt(1.0 - share + share * s * s), 1.0) for s in stretch)
    isotropic = np.maximum(closure_energy(cos_o, lobe.alpha_x, lobe.distribution), 1e-3)
    own = np.maximum(anisotropic_energy(cos_o, phi - widths.angle, alpha_x, alpha_y, lobe.distribution), 1e-3)
    return replace(lobe, weight=lobe.weight * (isotropic / own)[..., None], alpha_x=alpha_x, alpha_y=alpha_y, frame=widths.angle)
