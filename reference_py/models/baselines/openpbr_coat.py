# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `openpbr_coat`: the coat of OpenPBR 1.1 (Academy Software Foundation, section "Coat") over its base.

f = f_coat + T (1 - E_coat(wo)) Delta f_base, with the specification's suggested formulas:
- absorption T = exp(-tau (1 / cos_t(wi) + 1 / cos_t(wo))), cosines inside the coat (view-dependent absorption);
- darkening Delta = (1 - K) / (1 - E_b K), K from F(wo) for a smooth to 1 - (1 - E_F) / eta^2 for a rough base;
- roughening of the base's lobe, r'^4 = min(1, r^4 + 2 r_coat^4);
- a second interface that is optically thinner takes the inverse index.
The top interface is the coat (weight 1), the media's optical depths add up in it. A metal base has its F82 curve, a
diffuse base the energy-preserving Oren-Nayar model or Lambert, under a second interface as its gloss if there is one
(specular weight 0 otherwise). Without layers the base stands alone.
Limits: no place for a third interface, nor for a second over metal: they are left out; GGX only, single scattering;
one Delta for all views of a diffuse base; the gloss layer's own darkening is left to the base color, as the
specification does; f is not reciprocal.

option    | default | meaning
--------- | ------- | -------
darkening | on      | Delta: on is the specification's weight 1, off is 0

>>> model = make_model("openpbr_coat", presets.load("glazed_mug"), darkening="off")
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.097, 0.244, 0.367]
"""

import numpy as np

from ...errors import one_of
from ...material.stack import Stack
from ...optics.fresnel import cos_theta_t, fresnel_dielectric
from ...optics.interface import Microfacets
from ...optics.microfacet import GGX, alpha_from_roughness
from ...optics.optical_stack import supports
from .energy import albedo_curve, mean_fresnel
from .parts import Baseline, Lobe, dielectric, dielectric_f0, metal_f0, metal_f82


@supports("model")
class OpenPbrCoat(Baseline):
    """OpenPBR 1: coat with darkening over its base."""

    name = "openpbr_coat"

    def __init__(self, stack: Stack, darkening: str = "on"):
        super().__init__(stack)
        self._darkens = one_of(f"model {self.name}", "darkening", darkening, ("on", "off")) == "on"
        surfaces = self.optics.interfaces
        self._coat = self._lobe = None
        self._tau = sum((s.tau for s in surfaces), np.zeros(self.channels))
        if surfaces:
            self._eta = surfaces[0].eta
            self._coat = Lobe(surfaces[0].alpha, GGX, dielectric(self._eta))
            self._coat_albedo = _albedo(self._coat)
            self._mean_fresnel = float(mean_fresnel(self._coat.fresnel)[0])
        self._is_metal = self.optics.base.facets is not None
        if self._is_metal:
            roughness = self._roughened(self.optics.base.facets)
            self._lobe = Lobe(float(alpha_from_roughness(roughness)), GGX, metal_f82(self.optics))
            self._base_albedo, self._base_roughness = metal_f0(self.optics), roughness
        else:
            self._base_albedo, self._base_roughness = self.optics.base.color, 1.0
        if not self._is_metal and len(surfaces) > 1 and surfaces[1].eta != 1.0:
            self._add_gloss(max(surfaces[1].eta, 1.0 / surfaces[1].eta))

    def _roughened(self, facets: Microfacets) -> float:
        coat = self.optics.interfaces[0].alpha if self.optics.interfaces else 0.0
        return min(1.0, facets.alpha**2 + 2.0 * coat**2) ** 0.25

    def _add_gloss(self, eta: float) -> None:
        roughness, f0 = self._roughened(self.optics.interfaces[1].facets), dielectric_f0(eta)
        self._lobe = Lobe(float(alpha_from_roughness(roughness)), GGX, dielectric(eta))
        self._gloss_albedo = _albedo(self._lobe)
        self._base_roughness = 1.0 + f0 * (roughness - 1.0)
        self._base_albedo = f0 + (1.0 - f0) * self._base_albedo

    def _f(self, wo, wi):
        base = self._lobe.f(wo, wi) if self._lobe else 0.0
        if not self._is_metal:
            left = 1.0 - self._gloss_albedo(wo[..., 2]) if self._lobe else 1.0
            base = base + left * self.optics.base.f(wi, wo)
        if not self._coat:
            return base * np.ones(self.channels)
        return self._coat.f(wo, wi) + self._throughput(wo[..., 2], wi[..., 2]) * base

    def _throughput(self, cos_o, cos_i):
        """What the coat leaves of the base, (..., 3)."""
        path = 1.0 / cos_theta_t(cos_i, self._eta) + 1.0 / cos_theta_t(cos_o, self._eta)
        absorbed = np.exp(-self._tau * path[..., None])
        return absorbed * (1.0 - self._coat_albedo(cos_o)) * self._darkening(cos_o)

    def _darkening(self, cos_o):
        if not self._darkens:
            return np.ones(self.channels)
        smooth = fresnel_dielectric(cos_o, self._eta)
        rough = 1.0 - (1.0 - self._mean_fresnel) / self._eta**2
        inside = (smooth + self._base_roughness * (rough - smooth))[..., None]
        return (1.0 - inside) / np.maximum(1.0 - self._base_albedo * inside, 1e-12)

    def _specular_albedo(self, cos_o):
        base = self._lobe.specular_albedo(cos_o) if self._lobe else super()._specular_albedo(cos_o)
        if not self._coat:
            return base * np.ones(self.channels)
        return self._coat.specular_albedo(cos_o) + self._throughput(cos_o, cos_o) * base

    def _widths(self):
        return [lobe.width for lobe in (self._coat, self._lobe) if lobe]


def _albedo(lobe: Lobe):
    """Directional albedo of a lobe over the view's cosine."""
    return albedo_curve(lobe.f, [lobe.width], lobe.specular_albedo)
