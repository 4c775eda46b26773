# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `torrance_sparrow`: one glossy lobe, and a diffuse part, without any layering (Torrance67; Walter07).

What a plain glossy or glossy-plus-diffuse shader shows. A metal base: its own lobe alone, tinted by the round trip
through all media; no interface above is seen. A diffuse base: the lobe of the top interface, added to the base
tinted likewise and dimmed by 1 - f0 of that interface. Masking is Smith's, with the stack's own distribution.
Limits: interfaces between are ignored, nothing is broadened, single scattering loses energy at large alpha; the
sum of lobe and diffuse part exceeds 1 over a light base towards grazing views, by up to .47 at 89.9 degrees
(figures/stress.csv).

Options: none.

>>> model = make_model("torrance_sparrow", presets.load("metallic_car_paint"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.035, 0.22, 0.343]
"""

import numpy as np

from ...material.stack import Stack
from ...optics.optical_stack import supports
from .parts import Baseline, dielectric_f0, interface_lobe, metal_lobe


@supports("model")
class TorranceSparrow(Baseline):
    """A plain glossy shader, with a diffuse base if there is one."""

    name = "torrance_sparrow"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        self._metal = metal_lobe(self.optics)
        self._tint = self.optics.round_trip()
        self._lobe = self._metal or (interface_lobe(self.optics, 0) if stack.layers else None)
        self._lobe_tint = self._tint if self._metal else np.ones(self.channels)
        self._diffuse = self._tint * (1.0 - dielectric_f0(self.optics.interfaces[0].eta) if stack.layers else 1.0)

    def _f(self, wo, wi):
        total = np.zeros(wi.shape[:-1] + (self.channels,))
        if self._lobe:
            total = total + self._lobe_tint * self._lobe.f(wo, wi)
        if not self._metal:
            total = total + self._diffuse * self.optics.base.f(wi, wo)
        return total

    def _widths(self):
        return [self._lobe.width] if self._lobe else []

    def _specular_albedo(self, cos_o):
        return self._lobe_tint * self._lobe.specular_albedo(cos_o) if self._lobe else super()._specular_albedo(cos_o)
