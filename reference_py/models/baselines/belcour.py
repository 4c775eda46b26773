# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `belcour`: Belcour 2018, "Efficient Rendering of Layered Materials using an Atomic Decomposition with
Statistical Operators": one GGX lobe per interface, from the view's energy, mean and variance in the stack.

Energies are of the view alone (his non-reciprocal form). An interface reflects the directional albedo of a
single-scattering GGX lobe and transmits the rest; media multiply by exp(-tau / cos). Of what a medium scatters he keeps what one forward event lets
through, (1 + albedo tau / cos) exp(-tau / cos), widened by the phase function's variance ((1 - g) / g)^.8 / (1 + g) (his sections 4.3 and 4.4): nothing
comes back from it, a thin haze blurs as much as a thick one, and g of 0 or less counts as .00001. Variances add and scale with
the refraction's Jacobian as in his section 5; the constants are those of his code: s = a^1.1 / (1 - a^1.1).
He has no diffuse base: here its total is exact, T(wo) rho T(wi) / (pi n^2 (1 - rho R_d)) with T and R_d of all layers
from the model `adding`; Oren-Nayar counts as Lambert. Every distribution counts as GGX.
Limits: RGB alone, whose mean is what widens its lobes; f is not reciprocal; one mean direction per lobe, no tilt. Under a rough interface the weights add up to too
much, since what single scattering loses is taken as transmitted; then the lobe counts masking again, so that f gives
too little, too broadly. Aluminium under n = 1.5, green channel, alpha .3 over .05 at 60 degrees: weights .84, albedo
.64, f at the mirror direction 1.55; the truth is .73 and 2.21 (`adding`), and .52 for interfaces that lose what single
scattering loses (`position_free`, surface=single). Alpha .6 over .1 at 0 degrees: .84, .69, .51; .79, .69; and .51.
A white Lambert base under a rough interface is .02 to .06 too dark (figures/stress.csv).

Options: none.

>>> model = make_model("belcour", presets.load("glazed_mug"))
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.07, 0.131, 0.193]
"""

from dataclasses import dataclass

import numpy as np

from ...material.schema import SCATTERING
from ...material.stack import Stack
from ...optics.frame import half_vector
from ...optics.fresnel import cos_theta_t
from ...optics.interface import Interface
from ...optics.microfacet import GGX, SPECULAR_ALPHA, distribution, is_specular, masking_g2
from ...optics.optical_stack import supports
from ...optics.quadrature import points
from ..adding import Adding
from .energy import Curve, facets_seen, reflected_share
from .parts import Baseline, Fresnel, dielectric, metal_lobe

_LIMIT = 0.9999  # of alpha: at 1 the variance is infinite
_MIN_COS = 1e-4
_MIN_G = 1e-5
_FACETS = 1024


@supports("model", spectral=False, features=(SCATTERING,))
class Belcour(Baseline):
    """Belcour 2018: one equivalent GGX lobe per interface."""

    name = "belcour"

    def __init__(self, stack: Stack):
        super().__init__(stack)
        self._metal = metal_lobe(self.optics)
        count = len(stack.layers) + bool(self._metal)
        # per lobe three weights and an alpha
        self._lobes = Curve(self._table) if count else None
        self._count = count
        if not self._metal:
            energies = Adding(stack).layer_energies()
            self._transmitted = Curve(lambda cos: energies.above(cos)[1])
            rho = self.optics.base.color
            inside = energies.diffuse_below[0]
            self._diffuse = rho / (np.pi * self.optics.base.n_above**2 * (1.0 - rho * inside))

    def lobes(self, cos_o: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """(weight (..., 3), alpha (...)) of the lobe of each interface, and of a metal base, from the top."""
        values = self._lobes(cos_o) if self._lobes else np.zeros(np.shape(cos_o) + (0,))
        return [(values[..., 4 * i : 4 * i + 3], values[..., 4 * i + 3]) for i in range(self._count)]

    def _table(self, cos_o):
        walk = _Walk(cos_o)
        columns = []
        for surface in self.optics.interfaces:
            columns += walk.interface(surface.alpha, dielectric(surface.eta), surface.eta)
            walk.medium(surface)
        if self._metal:
            columns += walk.interface(self._metal.alpha, self._metal.fresnel, None)
        return np.concatenate(columns, axis=-1)

    def _f(self, wo, wi):
        total = np.zeros(wi.shape)
        cos_h = half_vector(wi, wo)[..., 2]
        for weight, alpha in self.lobes(wo[..., 2]):
            rough = np.maximum(alpha, 10.0 * SPECULAR_ALPHA)
            d = distribution(cos_h, rough, GGX) * masking_g2(wi[..., 2], wo[..., 2], rough, GGX)
            value = d / (4.0 * np.maximum(wi[..., 2] * wo[..., 2], 1e-30))
            total = total + weight * np.where(is_specular(alpha), 0.0, value)[..., None]
        if not self._metal:
            total = total + self._diffuse * self._transmitted(wo[..., 2]) * self._transmitted(wi[..., 2])
        return total

    def _widths(self):
        alphas = np.concatenate([[], *(alpha for _, alpha in self.lobes(np.array([0.05, 0.4, 1.0])))])
        # lobes within a factor of two share samples
        return [(GGX, float(a)) for a in np.unique(2.0 ** np.round(np.log2(alphas[alphas > SPECULAR_ALPHA])))]

    def _specular_albedo(self, cos_o):
        specular = [weight * is_specular(alpha)[..., None] for weight, alpha in self.lobes(cos_o)]
        return sum(specular, super()._specular_albedo(cos_o))


def _variance(alpha):
    power = np.minimum(alpha, _LIMIT) ** 1.1
    return power / (1.0 - power)


def _alpha(variance):
    return (variance / (1.0 + variance)) ** (1.0 / 1.1)


def _reflectance(cos, alpha, fresnel: Fresnel) -> np.ndarray:
    """(N, channels) directional albedo of a single-scattering GGX lobe."""
    cos_om, cos_i = facets_seen(cos, alpha, *points(_FACETS))
    return np.mean(fresnel(cos_om) * reflected_share(cos_i, cos, alpha)[..., None], axis=1)


@dataclass
class _Walk:
    """Energies, variances and Jacobians from the surface (0) down to here (i), for views at cosines (N,)."""

    cos: np.ndarray

    def __post_init__(self):
        n = len(self.cos)
        self.r_i0 = np.zeros((n, 3))
        self.t_0i = self.t_i0 = np.ones((n, 3))
        self.s_t0i = self.s_ti0 = self.s_ri0 = np.zeros(n)
        self.j_0i = self.j_i0 = np.ones(n)

    def medium(self, surface: Interface) -> None:
        path = surface.tau / np.maximum(self.cos, _MIN_COS)[:, None]
        share = np.exp(-path)
        if surface.scattering is not None:
            share = share * (1.0 + surface.scattering.albedo * path)
            g = max(surface.scattering.g, _MIN_G)
            spread = ((1.0 - g) / g) ** 0.8 / (1.0 + g)
            self.s_t0i, self.s_ti0 = self.s_t0i + spread, self.s_ti0 + self.j_i0 * spread
            self.s_ri0 = self.s_ri0 + 2.0 * spread
        self.t_0i, self.t_i0, self.r_i0 = self.t_0i * share, self.t_i0 * share, self.r_i0 * share**2

    def interface(self, alpha: float, fresnel: Fresnel, eta: float | None) -> list[np.ndarray]:
        """Cross an interface; eta is None for an opaque base. Returns its lobe: weight (N, 3), alpha (N, 1)."""
        s_r = _variance(alpha)
        rough = np.maximum(_alpha(self.s_t0i + s_r), 0.0)
        r12 = np.broadcast_to(_reflectance(self.cos, rough, fresnel), self.r_i0.shape)
        d = 1.0 - self.r_i0 * r12
        again = np.mean(self.r_i0 * r12 / d, axis=1)
        weight = self.t_0i * r12 * self.t_i0 / d
        spread = self.s_ti0 + self.j_0i * (self.s_t0i + s_r + again * (s_r + self.s_ri0))
        if eta is not None:
            self._descend(alpha, eta, rough, r12, d, again)
        return [weight, _alpha(spread)[:, None]]

    def _descend(self, alpha, eta, rough, r12, d, again):
        ct = cos_theta_t(self.cos, eta)
        passes = (ct > 0.0)[:, None]
        below = np.maximum(ct, _MIN_COS)
        r21 = np.where(passes, _reflectance(below, rough, dielectric(1.0 / eta)), 0.0)
        t12, t21 = np.where(passes, 1.0 - r12, 0.0), np.where(passes, 1.0 - r21, 0.0)
        s_r = _variance(alpha)
        s_t12 = _variance(alpha * abs(eta - 1.0) / (2.0 * eta))
        s_t21 = _variance(alpha * abs(1.0 / eta - 1.0) * eta / 2.0)
        j12 = eta * below / np.maximum(self.cos, _MIN_COS)
        through = t21 * self.r_i0 * t12 / d
        m, r = np.mean(through, axis=1), np.mean(r21, axis=1)
        more = (s_r + self.s_ri0) * again
        # every right-hand side has the values from above the interface
        from_above = s_t12 + j12 * (s_t21 + self.s_ri0 + more)
        s_ri0 = (r * s_r + m * from_above) / np.maximum(r + m, 1e-12)
        s_t0i = j12 * self.s_t0i + s_t12 + j12 * more
        s_ti0 = self.j_i0 * s_t21 + self.s_ti0 + self.j_i0 * more
        self.r_i0, self.t_0i, self.t_i0 = r21 + through, self.t_0i * t12 / d, t21 * self.t_i0 / d
        self.s_ri0, self.s_t0i, self.s_ti0 = s_ri0, s_t0i, s_ti0
        self.j_0i, self.j_i0 = self.j_0i * j12, self.j_i0 / j12
        self.cos = below
