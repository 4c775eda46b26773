# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `schlick`: the double-layer material of Schlick 1993, "A Customizable Reflectance Model for Everyday Rendering".

R = S(u) D + (1 - S(u)) S'(u) D', with S his Fresnel curve at the half vector, for the clear top interface and the base.
D = G(v) G(v') Z / (4 pi v v'), Z(t) = r / (1 + r t^2 - t^2)^2, G(v) = v / (r - r v + v): GGX of alpha^2 = r with a
masking of his own, whatever distribution the stack names. A diffuse base is r' = 1, D' = 1 / pi.
The base's color S'(0) is its own times the round trip through all media; Oren-Nayar counts as Lambert.
Left out: his re-emission of masked light, (1 - G G') / (4 pi v v'), which is unbounded at grazing views, and the
weights that add a mirror to a rough lobe (they would not show the alpha that a stack names).
Limits: interfaces between are ignored, nothing is broadened, internal reflection does not darken; over a light
diffuse base the sum exceeds 1 towards grazing views, and so does a metal, whose G stays near 1 until cos < alpha^2: by
up to 1.7 at 89.9 degrees (figures/stress.csv). His Fresnel curve rises to 1 even from 0, so an interface between equal
indices does not vanish.

Options: none.

>>> model = make_model("schlick", presets.load("glazed_mug"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.096, 0.243, 0.366]
"""

import numpy as np

from ...material.stack import Stack
from ...optics import microfacet
from ...optics.frame import dot, half_vector
from ...optics.microfacet import GGX, is_specular
from ...optics.optical_stack import supports
from .parts import Baseline, dielectric_f0, metal_f0, schlick


@supports("model")
class Schlick(Baseline):
    """Schlick 1993: a clear layer over a base."""

    name = "schlick"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        self._top_alpha = self.optics.interfaces[0].alpha if stack.layers else None
        self._top_fresnel = schlick(np.array([dielectric_f0(self.optics.interfaces[0].eta)])) if stack.layers else None
        is_metal = self.optics.base.facets is not None
        self._base_alpha = self.optics.base.facets.alpha if is_metal else None
        color = metal_f0(self.optics) if is_metal else self.optics.base.color
        self._tint = self.optics.round_trip()
        self._base_fresnel = schlick(color)

    def _f(self, wo, wi):
        wh = half_vector(wi, wo)
        u = np.clip(dot(wi, wh), 0.0, 1.0)
        base = self._throughput(u) * self._base_fresnel(u)
        base = base / np.pi if self._base_alpha is None else base * _lobe(wo, wi, wh, self._base_alpha)
        if self._top_alpha is None:
            return base
        return base + self._top_fresnel(u) * _lobe(wo, wi, wh, self._top_alpha)

    def _throughput(self, u):
        """What is left for the base, (..., 3)."""
        return self._tint * (1.0 - self._top_fresnel(u) if self._top_fresnel else 1.0)

    def _widths(self):
        return [(GGX, alpha) for alpha in (self._top_alpha, self._base_alpha) if alpha is not None]

    def _specular_albedo(self, cos_o):
        total = super()._specular_albedo(cos_o)
        if self._top_alpha is not None and is_specular(self._top_alpha):
            total = total + self._top_fresnel(cos_o)
        if self._base_alpha is not None and is_specular(self._base_alpha):
            total = total + self._throughput(cos_o) * self._base_fresnel(cos_o)
        return total


def _lobe(wo, wi, wh, alpha):
    """D (..., 1) of a rough surface; 0 for a mirror."""
    if is_specular(alpha):
        return np.zeros(wh.shape[:-1] + (1,))
    r = alpha * alpha
    cos_i, cos_o = np.maximum(wi[..., 2], 1e-15), np.maximum(wo[..., 2], 1e-15)
    # G(v) / v
    masking = 1.0 / ((r - r * cos_i + cos_i) * (r - r * cos_o + cos_o))
    return (0.25 * microfacet.distribution(wh[..., 2], alpha, GGX) * masking)[..., None]
