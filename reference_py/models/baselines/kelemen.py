# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `kelemen`: Kelemen and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model".

Specular: D F / |wi + wo|^2, which replaces masking and cosines. Matte, coupled to it:
k (1 - a(wi)) (1 - a(wo)) / (pi (1 - a_mean)) with a the specular albedo, so that a white matte part fills the
specular one up to 1 at every view. a is found by quadrature, F is exact, D the stack's distribution.
Metal base: its lobe alone, tinted by the round trip through all media. Diffuse base: the top interface's lobe,
k the tinted base color; Oren-Nayar counts as Lambert.
Limits: interfaces between are ignored, nothing is broadened, internal reflection does not darken; a rough metal
loses more than single scattering must.

Options: none.

>>> model = make_model("kelemen", presets.load("glazed_mug"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.097, 0.244, 0.367]
"""

import numpy as np

from ...material.stack import Stack
from ...optics import microfacet
from ...optics.frame import dot, half_vector
from ...optics.microfacet import is_specular
from ...optics.optical_stack import supports
from .energy import albedo_curve
from .parts import Baseline, interface_lobe, metal_lobe


@supports("model")
class Kelemen(Baseline):
    """Kelemen and Szirmay-Kalos 2001: coupled specular and matte."""

    name = "kelemen"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        metal = metal_lobe(self.optics)
        tint = self.optics.round_trip()
        self._lobe = metal or (interface_lobe(self.optics, 0) if stack.layers else None)
        self._tint = tint if metal else np.ones(self.channels)
        self._matte = None if metal else tint * self.optics.base.color
        if self._matte is not None and self._lobe:
            # where the lobe's own albedo exceeds 1 nothing is left for the matte part
            self._glossy_albedo = albedo_curve(self._specular, self._widths(), self._specular_albedo)

    def _f(self, wo, wi):
        total = self._specular(wo, wi)
        if self._matte is None:
            return total
        if not self._lobe:
            return total + self._matte / np.pi
        left = 1.0 - self._glossy_albedo.mean
        share = [np.maximum(1.0 - self._glossy_albedo(w[..., 2]), 0.0) for w in (wi, wo)]
        return total + self._matte * share[0] * share[1] / (np.pi * left)

    def _specular(self, wo, wi):
        if not self._lobe or is_specular(self._lobe.alpha):
            return np.zeros(np.broadcast_shapes(wi.shape, wo.shape)[:-1] + (self.channels,))
        wh = half_vector(wi, wo)
        d = microfacet.distribution(wh[..., 2], self._lobe.alpha, self._lobe.distribution)
        h2 = np.maximum(2.0 * (1.0 + dot(wi, wo)), 1e-30)
        return self._tint * self._lobe.fresnel(np.clip(dot(wi, wh), 0.0, 1.0)) * (d / h2)[..., None]

    def _widths(self):
        return [self._lobe.width] if self._lobe else []

    def _specular_albedo(self, cos_o):
        return self._tint * self._lobe.specular_albedo(cos_o) if self._lobe else super()._specular_albedo(cos_o)
