# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `principled_coat`: Blender's Principled BSDF with a coat, as Cycles 4.5 to 5.2 render it.

The top interface is the coat (weight 1, its IOR and roughness); Coat Tint is what two perpendicular crossings of all
media leave, since Cycles applies tint^(1 / cos_t) once for both ways, cos_t being the view's cosine inside the coat.
A metal base is Metallic 1 with Base Color and Specular Tint set to the metal's reflectance at 0 and 82 degrees (F82).
A diffuse base is Base Color, with Diffuse Roughness for Oren-Nayar; a second interface is Specular (its IOR relative
to the coat), otherwise IOR Level is 0. `settings` gives the values by socket name.
Limits: no place for a third interface, nor for a second over metal: they are left out; GGX only; no internal
reflection, so a coated diffuse base is too bright; no broadening; f is not reciprocal;
under a coat that is denser than the second interface's medium the albedo exceeds 1, by up to .64 (figures/stress.csv):
total reflection is estimated by the table for the inverse index, which has none, so the base is hardly dimmed. Blender
4.5.15 does it: n = 1.5 of alpha .5 over a smooth 1.3 over Lambert .8 renders 1.635 +- .002 at 75 degrees, here it is 1.639.

Options: none.

>>> model = make_model("principled_coat", presets.load("metallic_car_paint"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.062, 0.229, 0.345]
"""

import numpy as np

from ...material.stack import Stack
from ...optics.diffuse import fujii_roughness
from ...optics.fresnel import cos_theta_t
from ...optics.optical_stack import supports
from ...optics.quadrature import directional_albedo
from .cycles import MULTI_GGX, Closure, dielectric_closure, principled_specular
from .energy import mean_fresnel
from .parts import Baseline, metal_colors, metal_f82


@supports("model")
class PrincipledCoat(Baseline):
    """Blender's Principled BSDF with a coat."""

    name = "principled_coat"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        surfaces = self.optics.interfaces
        self._coat = dielectric_closure(surfaces[0].alpha, MULTI_GGX, surfaces[0].eta) if surfaces else None
        self._coat_eta = surfaces[0].eta if surfaces else 1.0
        self._tint = self.optics.round_trip()
        self._metal = self._specular = None
        if self.optics.base.facets:
            fresnel = metal_f82(self.optics)
            self._metal = Closure(self.optics.base.facets.alpha, MULTI_GGX, fresnel, mean_fresnel(fresnel))
        elif len(surfaces) > 1 and surfaces[1].eta != 1.0:
            self._specular = principled_specular(surfaces[1].alpha, surfaces[1].eta)

    def settings(self) -> dict[str, float | tuple[float, ...]]:
        """Values of the node's sockets by name; colors are linear RGB. What is not named is Blender's default."""
        values = {"Coat Weight": 1.0 if self._coat else 0.0}
        if self._coat:
            top = self.stack.layers[0]
            values |= {"Coat Roughness": top["roughness"], "Coat IOR": top["ior"], "Coat Tint": tuple(self._tint)}
        base = self.stack.base
        if self._metal:
            f0, f82_tint = metal_colors(self.optics)
            values |= {"Metallic": 1.0, "Base Color": tuple(f0), "Specular Tint": tuple(f82_tint)}
            return values | {"Roughness": base["roughness"]}
        values["Base Color"] = tuple(self.optics.base.color)
        if self.optics.base.sigma_deg > 0.0:
            values["Diffuse Roughness"] = float(fujii_roughness(self.optics.base.sigma_deg))
        if self._specular:
            return values | {"IOR": self.optics.interfaces[1].eta, "Roughness": self.stack.layers[1]["roughness"]}
        return values | {"Specular IOR Level": 0.0}

    def _f(self, wo, wi):
        base = self._metal.f(wo, wi) if self._metal else self.optics.base.f(wi, wo)
        if self._specular:
            base = self._specular.f(wo, wi) + self._specular.left(wo[..., 2]) * base
        return self._throughput(wo[..., 2]) * base + (self._coat.f(wo, wi) if self._coat else 0.0)

    def _albedo(self, above):
        """By its closures: that of each depends on the view alone."""
        cos_o, base = above[..., 2], self.optics.base
        if self._metal:
            below = self._metal.albedo(cos_o)
        elif base.sigma_deg > 0.0:
            below = directional_albedo(lambda wo, wi: base.f(wi, wo), above, [])
        else:
            below = base.color
        if self._specular:
            below = self._specular.albedo(cos_o) + self._specular.left(cos_o) * below
        return self._throughput(cos_o) * below + (self._coat.albedo(cos_o) if self._coat else 0.0)

    def _specular_albedo(self, cos_o):
        base = self._metal.specular_albedo(cos_o) if self._metal else super()._specular_albedo(cos_o)
        if self._specular:
            base = base + self._specular.specular_albedo(cos_o)
        return self._throughput(cos_o) * base + (self._coat.specular_albedo(cos_o) if self._coat else 0.0)

    def _throughput(self, cos_o):
        """What the coat leaves of the base, (..., 3)."""
        if not self._coat:
            return np.ones(cos_o.shape + (self.channels,))
        path = 1.0 / cos_theta_t(cos_o, self._coat_eta)
        return self._coat.left(cos_o) * self._tint ** path[..., None]

    def _widths(self):
        return [closure.lobe.width for closure in (self._coat, self._specular, self._metal) if closure]
