# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `ashikhmin_shirley`: Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model", isotropic.

Specular lobe (eq. 4 with n_u = n_v), Schlick's Fresnel curve, and a diffuse part (eq. 5) that fades where
the lobe brightens. The exponent is that of Blinn's distribution which matches the stack's alpha for small angles.
Metal base: its lobe alone, tinted by the round trip through all media. Diffuse base: the top interface's lobe over
the tinted base color; without layers the diffuse part of a lobe of no reflectance. Oren-Nayar counts as Lambert.
Limits: interfaces between are ignored, nothing is broadened; the diffuse part fades towards grazing views even
where no lobe takes its place (rough or absent), so a bare white base has albedo .97, .89, .50 at 0, 45, 75 degrees.
Schlick's curve rises to 1 even from 0, so an interface between equal indices does not vanish.

Options: none.

>>> model = make_model("ashikhmin_shirley", presets.load("glazed_mug"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.094, 0.232, 0.348]
"""

import numpy as np

from ...material.stack import Stack
from ...optics.blinn import blinn_exponent
from ...optics.frame import dot, half_vector
from ...optics.microfacet import BECKMANN, is_specular
from ...optics.optical_stack import supports
from .parts import Baseline, dielectric_f0, metal_f0, schlick


@supports("model")
class AshikhminShirley(Baseline):
    """Ashikhmin and Shirley 2000: Fresnel-weighted specular and diffuse."""

    name = "ashikhmin_shirley"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        is_metal = self.optics.base.facets is not None
        tint = self.optics.round_trip()
        facets = self.optics.base.facets or (self.optics.interfaces[0].facets if stack.layers else None)
        self._alpha = facets.alpha if facets else 1.0
        if is_metal:
            self._f0, self._tint, self._color = metal_f0(self.optics), tint, np.zeros(self.channels)
        else:
            self._f0 = np.full(self.channels, dielectric_f0(self.optics.interfaces[0].eta) if stack.layers else 0.0)
            self._tint, self._color = np.full(self.channels, 1.0 if stack.layers else 0.0), tint * self.optics.base.color

    def _f(self, wo, wi):
        return self._specular(wo, wi) + self._diffuse(wo, wi)

    def _specular(self, wo, wi):
        if is_specular(self._alpha):
            return np.zeros(wi.shape[:-1] + (self.channels,))
        n = blinn_exponent(self._alpha)
        wh = half_vector(wi, wo)
        cos_h = np.clip(dot(wi, wh), 1e-12, 1.0)
        lobe = (n + 1.0) / (8.0 * np.pi) * np.clip(wh[..., 2], 1e-12, 1.0) ** n
        lobe = lobe / (cos_h * np.maximum(wi[..., 2], wo[..., 2]))
        return self._tint * schlick(self._f0)(cos_h) * lobe[..., None]

    def _diffuse(self, wo, wi):
        fade = (1.0 - (1.0 - 0.5 * wi[..., 2]) ** 5) * (1.0 - (1.0 - 0.5 * wo[..., 2]) ** 5)
        return 28.0 / (23.0 * np.pi) * self._color * (1.0 - self._f0) * fade[..., None]

    def _widths(self):
        # a Beckmann lobe of the same alpha is close enough to share samples
        return [(BECKMANN, self._alpha)]

    def _specular_albedo(self, cos_o):
        if not is_specular(self._alpha):
            return super()._specular_albedo(cos_o)
        return self._tint * schlick(self._f0)(cos_o)
