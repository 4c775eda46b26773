# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `cycles_layer`: the stack written with Cycles' OSL closure layer(top, base), as Cycles 4.5 to 5.2 render it.

Every interface is layer(dielectric_bsdf(...), tint * below), nested from the top, over diffuse, oren_nayar_diffuse_bsdf
or conductor_bsdf. layer() dims what is below by 1 - the largest channel of the top's estimated albedo; see `cycles`.
The tint is what two perpendicular crossings of the medium leave, one color for all views, as users multiply it in.
Limits, all Cycles': no internal reflection, so a diffuse base under n = 1.5 is up to 65 % too bright; no refraction
and no broadening of what is below; grey dimming; weights depend on the view alone, so f is not reciprocal;
below an interface to a thinner medium the albedo exceeds 1, by up to .15 (figures/stress.csv).

option | default   | meaning
------ | --------- | -------
ggx    | multi_ggx | where the stack says ggx: multi_ggx, Blender's default, compensated for lost energy, or ggx;
       |           | beckmann stays beckmann, dimmed by the estimate for GGX

>>> model = make_model("cycles_layer", presets.load("lacquered_brass"), ggx="ggx")
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.839, 0.67, 0.304]
"""

import numpy as np

from ...errors import one_of
from ...material.stack import Stack
from ...optics.microfacet import BECKMANN, GGX
from ...optics.optical_stack import supports
from .cycles import MULTI_GGX, Closure, conductor_closure, dielectric_closure
from .parts import Baseline


@supports("model")
class CyclesLayer(Baseline):
    """Closures stacked with Cycles' layer(), as Cycles computes it."""

    name = "cycles_layer"

    def __init__(self, stack: Stack, ggx: str = MULTI_GGX):
        super().__init__(stack)
        self._ggx = one_of(f"model {self.name}", "ggx", ggx, (MULTI_GGX, GGX))
        surfaces = self.optics.interfaces
        self._tops = [dielectric_closure(s.alpha, self.closure_distribution(s.distribution), s.eta) for s in surfaces]
        self._tints = [np.exp(-2.0 * s.tau) for s in surfaces]
        self._metal = self._metal_closure() if self.optics.base.facets else None

    def closure_distribution(self, distribution: str) -> str:
        """Name of the closure's distribution for one of the stack."""
        return BECKMANN if distribution == BECKMANN else self._ggx

    def _metal_closure(self) -> Closure:
        facets = self.optics.base.facets
        return conductor_closure(facets.alpha, self.closure_distribution(facets.distribution), *self.optics.base.relative_index)

    def _f(self, wo, wi):
        base = self._metal.f(wo, wi) if self._metal else self.optics.base.f(wi, wo)
        return self._layered(wo[..., 2], base, [top.f(wo, wi) for top in self._tops])

    def _specular_albedo(self, cos_o):
        base = self._metal.specular_albedo(cos_o) if self._metal else super()._specular_albedo(cos_o)
        return self._layered(cos_o, base, [top.specular_albedo(cos_o) for top in self._tops])

    def _layered(self, cos_o, base, tops):
        for top, value, tint in reversed(list(zip(self._tops, tops, self._tints))):
            base = value + top.left(cos_o) * tint * base
        return base

    def _widths(self):
        return [closure.lobe.width for closure in (*self._tops, *([self._metal] if self._metal else []))]
