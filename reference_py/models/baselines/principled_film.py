# SPDX-License-Identifier: GPL-3.0-or-later
"""`principled_coat` with a thin film on its metal or its second interface, as Cycles 5.0 to 5.3 render it.

Read from kernel/closure/bsdf_microfacet.h and bsdf_util.h: the film lies in air, also below a coat; a metal's index comes from its
reflectance at 0 and 82 degrees, taken for Gulbrandsen's two colors, its phases from that index, and its reflectance
inside the film from the F82 curve. What light reflected again meets is the surface without film. Blender 4.5 has no film on metals, and fits
the colors of films on the second interface differently.
"""

import numpy as np

from ...material.stack import Stack
from ...optics.colour import artist_index
from ...optics.thin_film import Film, film_reflectance
from .cycles import MULTI_GGX, Closure
from .energy import mean_fresnel
from .parts import COS_82, Fresnel, dielectric, f82, metal_f82
from .principled_coat import PrincipledCoat

# A metal of reflectance 1 has no finite index; Cycles' own.
_MOST = 0.999


class FilmedPrincipled(PrincipledCoat):
    """Blender's Principled BSDF with a coat, and a film on what is below that."""

    def __init__(self, stack: Stack, film: Film):
        super().__init__(stack)
        if self._metal:
            plain = metal_f82(self.optics)
            self._metal = Closure(self.optics.base.facets.alpha, MULTI_GGX, filmed_metal(plain, film), mean_fresnel(plain))
        elif self._specular:
            surface = self.optics.interfaces[1]
            self._specular = Closure(surface.alpha, MULTI_GGX, lambda cos: film_reflectance(cos, 1.0, film, surface.eta), mean_fresnel(dielectric(surface.eta)))


def filmed_metal(plain: Fresnel, film: Film) -> Fresnel:
    """The curve of a film on a metal that has the F82 curve `plain` without it."""
    at_0, at_82 = plain(np.ones(())), plain(np.full((), COS_82))
    eta, k = artist_index(np.minimum(at_0, _MOST), at_82)
    inside = (eta + 1j * k) / film.faded_ior(1.0)
    below = f82(np.square(np.abs((inside - 1.0) / (inside + 1.0))), at_82)
    return lambda cos: film_reflectance(cos, 1.0, film, eta, k, curve_below=below)
