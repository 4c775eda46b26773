# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' glossy closures as numbers: energy compensation and the albedo that a closure is thought to have.

Read from Cycles 4.5 to 5.2 (kernel/closure/bsdf_microfacet.h, app/cycles_precompute.cpp). Cycles reads both from
tables; here their entries are computed anew as the integrals that the tables hold, on the tables' grids and with
their linear interpolation, so that its error is ours too. Mean Fresnel curves are integrals where Cycles has fits
(.001 apart below an index of 1). GGX tables serve every distribution, as in Cycles.
"""

from functools import lru_cache

import numpy as np

from ...optics.fresnel import fresnel_dielectric
from ...optics.gauss import gauss_legendre
from ...optics.microfacet import BECKMANN, GGX, is_specular
from ...optics.quadrature import points
from .energy import facet_points, facets_seen, mean_fresnel, reflected_share
from .parts import COS_82, Fresnel, Lobe, conductor, dielectric, dielectric_f0, f82

MULTI_GGX = "multi_ggx"
_FLOOR = 1e-4  # of the tables' first nodes
_ENERGY_NODES, _RISE_NODES = 32, 16
_ORDER = 24
_FACETS = 4096


def _nodes(count: int) -> np.ndarray:
    return np.clip(np.linspace(0.0, 1.0, count), _FLOOR, 1.0)


def _between(x: float, count: int) -> tuple[int, int, float]:
    """Neighbouring nodes of x in 0..1 and the second one's share."""
    place = np.clip(x, 0.0, 1.0) * (count - 1)
    first = int(place)
    return first, min(first + 1, count - 1), place - first


def _ggx_energy(cos_o: np.ndarray, alpha: float) -> np.ndarray:
    """(N,) albedo of a lossless single-scattering GGX lobe."""
    alphas = np.full(len(cos_o), alpha)
    _, cos_i = facets_seen(cos_o, alphas, *points(_FACETS))
    return np.mean(reflected_share(cos_i, cos_o, alphas), axis=1)


@lru_cache(maxsize=16)
def _turned_out(cosines: tuple[float, ...], alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """Of facets that views (N,) see, their cosine to the view and what leaves by each of a light of 1, both (N, n); not to be written to."""
    cos_o, alphas = np.array(cosines), np.full(len(cosines), alpha)
    *places, weights = facet_points()
    cos_om, cos_i = facets_seen(cos_o, alphas, *places)
    return cos_om, reflected_share(cos_i, cos_o, alphas) * weights


@lru_cache(maxsize=_ENERGY_NODES)
def _energy_column(index: int) -> tuple[np.ndarray, float]:
    """Energy at the table's cosines for its roughness node `index`, and the cosine-weighted mean of it."""
    alpha = _nodes(_ENERGY_NODES)[index] ** 2
    x, w = gauss_legendre(_ORDER)
    cos = 0.5 * (x + 1.0)
    return _ggx_energy(_nodes(_ENERGY_NODES), alpha), float(np.sum(w * cos * _ggx_energy(cos, alpha)))


def _energy(alpha: float) -> tuple[np.ndarray, float]:
    """The table's column at this alpha, and its mean."""
    low, high, share = _between(np.sqrt(alpha), _ENERGY_NODES)
    (a, mean_a), (b, mean_b) = _energy_column(low), _energy_column(high)
    return (1.0 - share) * a + share * b, (1.0 - share) * mean_a + share * mean_b


@lru_cache(maxsize=64)
def _rise_column(rough: int, depth: int) -> np.ndarray:
    """Mean of (F - F0) / (1 - F0) over the facets seen, at the table's cosines; masked light counts as none."""
    cos_o = _nodes(_RISE_NODES)
    z2 = np.clip(_nodes(_RISE_NODES)[depth], _FLOOR, 0.99) ** 2
    eta = (1.0 + z2) / (1.0 - z2)
    cos_om, cos_i = facets_seen(cos_o, np.full(len(cos_o), _nodes(_RISE_NODES)[rough] ** 2), *points(_FACETS))
    f0 = dielectric_f0(eta)
    rise = np.clip((fresnel_dielectric(cos_om, eta) - f0) / (1.0 - f0), 0.0, 1.0)
    return np.mean(np.where(cos_i > 0.0, rise, 0.0), axis=1)


def _rise(alpha: float, eta: float) -> np.ndarray:
    """How far the reflectance of an interface has risen from F0 to 1 at the table's cosines; eta counts as 1 / eta."""
    r0, r1, r = _between(np.sqrt(alpha), _RISE_NODES)
    z0, z1, z = _between(np.sqrt(abs((eta - 1.0) / (eta + 1.0))), _RISE_NODES)
    near = (1.0 - r) * _rise_column(r0, z0) + r * _rise_column(r1, z0)
    far = (1.0 - r) * _rise_column(r0, z1) + r * _rise_column(r1, z1)
    return (1.0 - z) * near + z * far


class Closure:
    """A glossy closure: its f and mirror energy for a view, and the albedo by which what lies below is dimmed.

    `distribution`: "ggx", "beckmann" or "multi_ggx". Only the last is compensated for lost energy (Kulla17).
    `mean` is the mean of the Fresnel curve that light reflected again meets. `estimate` holds Cycles' albedo of the
    curve at the table's cosines, or is None: then the curve itself.
    """

    def __init__(self, alpha: float, distribution: str, fresnel: Fresnel, mean: np.ndarray, estimate: np.ndarray | None = None):
        self.lobe = Lobe(alpha, BECKMANN if distribution == BECKMANN else GGX, fresnel)
        self._estimate = estimate
        self._column, energy = _energy(alpha) if distribution == MULTI_GGX else (np.ones(_ENERGY_NODES), 1.0)
        self._again = mean * energy / (1.0 - mean * (1.0 - energy))

    def _kept(self, cos_o) -> np.ndarray:
        """Energy (..., 1) that single scattering keeps of a lossless lobe; 1 for what is not compensated."""
        return np.interp(cos_o, np.linspace(0.0, 1.0, _ENERGY_NODES), self._column)[..., None]

    def gain(self, cos_o: np.ndarray) -> np.ndarray:
        """Factor (..., channels) on the lobe that puts back the light which is reflected again."""
        kept = self._kept(cos_o)
        return 1.0 + self._again * (1.0 - kept) / kept

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """(..., channels) for directions above the surface; 0 for a mirror."""
        return self.gain(wo[..., 2]) * self.lobe.f(wo, wi)

    def specular_albedo(self, cos_o: np.ndarray) -> np.ndarray:
        """Energy (..., channels) of a mirror; 0 for a rough lobe."""
        return self.gain(cos_o) * self.lobe.specular_albedo(cos_o)

    def albedo(self, cos_o: np.ndarray) -> np.ndarray:
        """Energy (N, channels) for views (N,), of one that is not "beckmann". Within 4e-4 of the integral of f."""
        if is_specular(self.lobe.alpha):
            return self.specular_albedo(cos_o)
        cos_om, share = _turned_out(tuple(cos_o.tolist()), self.lobe.alpha)
        return self.gain(cos_o) * np.sum(share[..., None] * self.lobe.fresnel(cos_om), axis=1)

    def left(self, cos_o: np.ndarray) -> np.ndarray:
        """What Cycles leaves for the closures below, (..., 1): 1 - the largest channel of the estimated albedo."""
        if self._estimate is None:
            estimate = self.lobe.fresnel(cos_o)
        else:
            estimate = np.interp(cos_o, np.linspace(0.0, 1.0, _RISE_NODES), self._estimate)[..., None]
        kept = self._kept(cos_o)
        albedo = (kept + self._again * (1.0 - kept)) * estimate
        return np.clip(1.0 - np.max(albedo, axis=-1, keepdims=True), 0.0, 1.0)


def dielectric_closure(alpha: float, distribution: str, eta: float) -> Closure:
    """`dielectric_bsdf` without transmission; where eta <= 1 Cycles takes the smooth curve as albedo."""
    fresnel = dielectric(eta)
    return Closure(alpha, distribution, fresnel, mean_fresnel(fresnel), _estimate(alpha, eta) if eta > 1.0 else None)


def principled_specular(alpha: float, eta: float) -> Closure:
    """The Principled BSDF's specular lobe; its albedo comes from the table for either sign of eta - 1."""
    fresnel = dielectric(eta)
    return Closure(alpha, MULTI_GGX, fresnel, mean_fresnel(fresnel), _estimate(alpha, eta))


def _estimate(alpha: float, eta: float) -> np.ndarray:
    f0 = dielectric_f0(eta)
    return f0 + (1.0 - f0) * _rise(alpha, eta)


def conductor_closure(alpha: float, distribution: str, eta: np.ndarray, k: np.ndarray) -> Closure:
    """`conductor_bsdf`; Cycles 4.5 has an approximate Fresnel curve there, 5.0 and later the exact one.

    Its mean is that of the F82 curve through the exact curve's ends, as in Cycles.
    """
    fresnel = conductor(eta, k)
    mean = mean_fresnel(f82(fresnel(np.ones(())), fresnel(np.full((), COS_82))))
    return Closure(alpha, distribution, fresnel, mean)
