# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' glossy closures as numbers: energy compensation and the albedo that a closure is thought to have.

Read from Cycles 4.5 to 5.2 (kernel/closure/bsdf_microfacet.h, app/cycles_precompute.cpp). Cycles reads both from
tables; ours (data/cycles_energies.json, by `study.make_cycles_energies`) hold the integrals that its hold, computed anew on
its grids, and are read with its linear interpolation, so that its error is ours too. Mean Fresnel curves are integrals where
Cycles has fits (.001 apart below an index of 1). GGX tables serve every distribution, as in Cycles.
"""

import json
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...optics.microfacet import BECKMANN, GGX, is_specular
from .energy import facet_points, facets_seen, mean_fresnel, reflected_share
from .parts import COS_82, Fresnel, Lobe, conductor, dielectric, dielectric_f0, f82

MULTI_GGX = "multi_ggx"
FILE = Path(__file__).parents[2] / "data" / "cycles_energies.json"
# The tables hold whole numbers of this unit.
UNIT = 1e-8
# Nodes of the tables are even in the cosine and in the root of alpha; those of `rise` also in the root of |eta - 1| / (eta + 1).
ENERGY_NODES, RISE_NODES = 32, 16


def _between(x: float, count: int) -> tuple[int, int, float]:
    """Neighbouring nodes of x in 0..1 and the second one's share."""
    place = np.clip(x, 0.0, 1.0) * (count - 1)
    first = int(place)
    return first, min(first + 1, count - 1), place - first


@lru_cache(maxsize=1)
def tables() -> dict[str, np.ndarray]:
    """`energy` (alphas, cosines) of a lossless lobe that scatters once, `mean` (alphas,) of that, weighted by the cosine, and `rise` (alphas,
    indices, cosines): the mean of (F - F0) / (1 - F0) over the facets seen, where masked light counts as none."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    shapes = {"energy": (ENERGY_NODES,) * 2, "mean": (ENERGY_NODES,), "rise": (RISE_NODES,) * 3}
    return {name: UNIT * np.array(data[name], float).reshape(shape) for name, shape in shapes.items()}


@lru_cache(maxsize=16)
def _turned_out(cosines: tuple[float, ...], alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """Of facets that views (N,) see, their cosine to the view and what leaves by each of a light of 1, both (N, n); not to be written to."""
    cos_o, alphas = np.array(cosines), np.full(len(cosines), alpha)
    *places, weights = facet_points()
    cos_om, cos_i = facets_seen(cos_o, alphas, *places)
    return cos_om, reflected_share(cos_i, cos_o, alphas) * weights


def _energy(alpha: float) -> tuple[np.ndarray, float]:
    """The table's row at this alpha, and its mean."""
    low, high, share = _between(np.sqrt(alpha), ENERGY_NODES)
    energy, mean = (table[low] * (1.0 - share) + table[high] * share for table in (tables()["energy"], tables()["mean"]))
    return energy, float(mean)


def _rise(alpha: float, eta: float) -> np.ndarray:
    """How far the reflectance of an interface has risen from F0 to 1 at the table's cosines; eta counts as 1 / eta."""
    r0, r1, r = _between(np.sqrt(alpha), RISE_NODES)
    z0, z1, z = _between(np.sqrt(abs((eta - 1.0) / (eta + 1.0))), RISE_NODES)
    near, far = ((1.0 - r) * tables()["rise"][r0, at] + r * tables()["rise"][r1, at] for at in (z0, z1))
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
        self._column, energy = _energy(alpha) if distribution == MULTI_GGX else (np.ones(ENERGY_NODES), 1.0)
        self._again = mean * energy / (1.0 - mean * (1.0 - energy))

    def _kept(self, cos_o) -> np.ndarray:
        """Energy (..., 1) that single scattering keeps of a lossless lobe; 1 for what is not compensated."""
        return np.interp(cos_o, np.linspace(0.0, 1.0, ENERGY_NODES), self._column)[..., None]

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
            estimate = np.interp(cos_o, np.linspace(0.0, 1.0, RISE_NODES), self._estimate)[..., None]
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
