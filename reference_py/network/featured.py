# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic` for stacks with features that its own arithmetic does not know.

Anisotropy: energies are those of the isotropic stack; the top lobe has its surface's exact widths, deeper ones as far
as their width is their own surface's. What an anisotropic surface does to light that crosses it has no direction.
Thin films: the tier has no colored interfaces, so `weidlich_wilkie` stands in. Normals are the renderer's.
"""

from dataclasses import replace

import numpy as np

from ..optics.material import Brushed, brushed
from ..schema import THIN_FILM
from ..stack import Stack
from .analytic import AnalyticNetwork
from .lobe import DiffuseLobe, GlossyLobe
from .table import MIN_COS_O
from .unbaked import without_unbaked
from .weidlich_wilkie import WeidlichWilkieNetwork


def featured_analytic(stack: Stack):
    """The network that a stack has in the tier `analytic`."""
    if any(element.has(THIN_FILM) for element in (*stack.layers, stack.base)):
        return WeidlichWilkieNetwork(stack)
    return FeaturedAnalyticNetwork(stack)


class FeaturedAnalyticNetwork(AnalyticNetwork):
    """The lobes of the stack without its features, in the shapes that these give them."""

    def __init__(self, stack: Stack):
        self.stack, self._plain = stack, AnalyticNetwork(without_unbaked(stack))

    def lobes(self, cos_theta_o: np.ndarray) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes from the top for views of cosine cos_theta_o (...); weights are (..., 3)."""
        cos_theta_o = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0)
        lobes, layers = self._plain.lobes(cos_theta_o), self.stack.layers
        indices = [1.0, *(layer["ior"] for layer in layers)]
        # the top, all deeper layers as the second, and the base, which may have two lobes
        inner = min(len(layers), 2)
        elements = [*layers[:inner], *[self.stack.base] * (len(lobes) - inner)]
        depths = [*range(inner), *[len(layers)] * (len(lobes) - inner)]
        return [
            _shaped(lobe, brushed(element) if "roughness" in element else None, indices[depth], cos_theta_o, depth == 0 and len(layers) > 0)
            for lobe, element, depth in zip(lobes, elements, depths)
        ]


def _shaped(lobe, widths: Brushed | None, n: float, cos_o: np.ndarray, is_top: bool):
    if widths is None:
        return lobe
    if is_top:
        return replace(lobe, alpha_x=widths.alpha_x, alpha_y=widths.alpha_y, frame=widths.angle)
    inner = np.sqrt(np.maximum(1.0 - (1.0 - np.square(cos_o)) / n**2, 0.0))
    share = np.clip(np.square(n * inner * widths.alpha / (cos_o * np.maximum(lobe.alpha_x, 1e-12))), 0.0, 1.0)
    stretch = [alpha / max(widths.alpha, 1e-12) for alpha in (widths.alpha_x, widths.alpha_y)]
    shape = [np.minimum(lobe.alpha_x * np.sqrt(1.0 - share + share * s * s), 1.0) for s in stretch]
    return replace(lobe, alpha_x=shape[0], alpha_y=shape[1], frame=widths.angle)
