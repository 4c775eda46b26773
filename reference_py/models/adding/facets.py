# SPDX-License-Identifier: GPL-3.0-or-later
"""One scattering event on a rough surface, by quadrature over the visible facet normals.

Points and weights follow the lobe, so a lobe of any width costs the same and keeps its energy exactly. The visible
GGX normals are a uniform cap of a stretched hemisphere (Heitz18, "Sampling the GGX Distribution of Visible Normals");
Beckmann shares the points, its slope density is at most 1.48 times that of GGX of the same alpha.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from ...optics import microfacet
from ...optics.facet_reflectance import DielectricFacet
from ...optics.gauss import gauss_legendre
from ...optics.microfacet import GGX, distribution_of
from ...optics.sampling import projected_area

SINGLE, MULTIPLE = "single", "multiple"
SURFACES = (MULTIPLE, SINGLE)
# Lambda is infinite at the horizon; cosines below this count as this.
GRAZING = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Facets:
    """Microfacets met by a walker; the plane of incidence is xz. Directions leave the surface, upwards is z > 0."""

    wo: np.ndarray
    """(I, 1, 3) directions towards the origin of the walker."""
    wm: np.ndarray
    """(I, Q, 3) facet normals, the half with y >= 0; the other half mirrors it."""
    weights: np.ndarray
    """(I, Q) share of the visible area, sums to 1 over Q for `multiple`."""
    alpha: float
    distribution: str
    surface: str

    @cached_property
    def cos_om(self) -> np.ndarray:
        """(I, Q) cosine between wo and the facet normal."""
        return self.wo[..., 0] * self.wm[..., 0] + self.wo[..., 2] * self.wm[..., 2]

    def reflected(self) -> tuple[np.ndarray, np.ndarray]:
        """Directions (I, Q, 3) and weights (I, Q) of the light a perfect mirror turns out in one event."""
        wi = 2.0 * self.cos_om[..., None] * self.wm - self.wo
        return wi, self.weights * np.where(wi[..., 2] > 0.0, self._reflection_masking(wi[..., 2]), 0.0)

    def refracted(self, eta: float) -> tuple[np.ndarray, np.ndarray]:
        """Directions (I, Q, 3), downwards, and weights (I, Q) without Fresnel; eta = n_t / n_i."""
        cos_o = self.cos_om
        cos_t = np.sqrt(np.maximum(1.0 - (1.0 - np.square(cos_o)) / eta**2, 0.0))
        wt = (cos_o / eta - cos_t)[..., None] * self.wm - self.wo / eta
        return wt, self.weights * np.where(wt[..., 2] < 0.0, self._transmission_masking(-wt[..., 2]), 0.0)

    def _lambda(self, cos_theta):
        return smith_lambda(cos_theta, self.alpha, self.distribution)

    def _reflection_masking(self, cos_i):
        """Share of the facets seen from wo that are seen from wi too: G / G1(wo)."""
        if self.surface == SINGLE:
            return 1.0 / (1.0 + self._lambda(cos_i))
        lambda_o = self._lambda(self.wo[..., 2])
        return (1.0 + lambda_o) / (1.0 + lambda_o + self._lambda(cos_i))

    def _transmission_masking(self, cos_t):
        if self.surface == SINGLE:
            return 1.0 / (1.0 + self._lambda(cos_t))
        # Heitz16, eq. 17: G / G1(wo) = (1 + Lambda_o) B(1 + Lambda_o, 1 + Lambda_t)
        lambda_o, lambda_t = self._lambda(self.wo[..., 2]), self._lambda(cos_t)
        return np.exp(log_gamma(2.0 + lambda_o) + log_gamma(1.0 + lambda_t) - log_gamma(2.0 + lambda_o + lambda_t))


def visible_facets(cos_theta: np.ndarray, alpha: float, distribution: str, surface: str, across: int, along: int, eta: float = 1.0) -> Facets:
    """Quadrature over the normals seen at cosines (I,), below the horizon too.

    `across` and `along` points of the plane of incidence. Where eta = n_t / n_i < 1 the strip of facets that
    do not reflect totally is integrated apart, as the Fresnel curve has a root at its edge.
    """
    cos_theta = np.asarray(cos_theta, float)
    sin_theta = np.sqrt(1.0 - np.square(cos_theta))
    length = np.hypot(alpha * sin_theta, cos_theta)
    cap = _StretchedCap((alpha * sin_theta / length)[:, None, None], (cos_theta / length)[:, None, None], alpha)
    # a across, then b from the stretched horizon, where the slope is infinite, to the edge of the visible disc
    low, high = -np.arctan2(cap.vz, cap.vx), np.full(cap.vz.shape, 0.5 * pi)
    if eta < 1.0:
        critical = np.sqrt(1.0 - eta * eta) / length[:, None, None]
        edge = cap.transmitting_across(low, critical)
        a, w_a = _joined(across // 2, 0.0 * high, edge, high)
        a, w_a = np.moveaxis(a, 1, 2), np.moveaxis(w_a, 1, 2)
        low, high = (np.broadcast_to(edge, a.shape) for edge in (low, high))
        b, w_b = _joined(along // 2, low, *cap.transmitting_along(a, edge, low, critical), high)
    else:
        a, w_a = _gauss(across, 0.0, 0.5 * pi)
        a, w_a = a[:, None], w_a[:, None]
        b, w_b = _gauss(along, low, high)
    nx, ny, nz = cap.normal(a, b)
    nz = np.maximum(nz, 1e-12)
    weights = np.square(np.cos(a)) * np.cos(b) * w_a * w_b
    weights = weights / weights.sum(axis=(1, 2), keepdims=True)
    if distribution != GGX:  # the nodes are those of GGX
        slope2 = (np.square(nx) + np.square(ny)) / np.square(nz)
        weights = weights * np.square(1.0 + slope2) * distribution_of(distribution).slope_density(slope2)
        if surface == MULTIPLE:  # the walk on the microsurface draws normals from the normalised density
            weights = weights / np.maximum(weights.sum(axis=(1, 2), keepdims=True), 1e-300)
        else:
            ratio = (1.0 + smith_lambda(cos_theta, alpha, GGX)) / (1.0 + smith_lambda(cos_theta, alpha, distribution))
            weights = weights * ratio[:, None, None]
    # components one after the other, which computes fastest
    wm = np.stack([alpha * nx, np.broadcast_to(alpha * ny, nx.shape), nz]).reshape(3, len(cos_theta), -1)
    wm /= np.sqrt(np.sum(np.square(wm), axis=0))
    wo = np.stack([sin_theta, np.zeros_like(sin_theta), cos_theta])[..., None]
    return Facets(np.moveaxis(wo, 0, -1), np.moveaxis(wm, 0, -1), weights.reshape(len(cos_theta), -1), alpha, distribution, surface)


def reflection_lobe(cos_o, cos_i, cos_m, alpha: float, distribution: str, surface: str) -> np.ndarray:
    """D G / (4 cos_i cos_o) of one event, f without Fresnel; cos_m is that of the facet normal. Broadcasts."""
    return microfacet.distribution(cos_m, alpha, distribution) * seen_by_both(cos_o, cos_i, alpha, distribution, surface)


def seen_by_both(cos_o, cos_i, alpha: float, distribution: str, surface: str) -> np.ndarray:
    """G / (4 cos_i cos_o), the part of `reflection_lobe` that knows no azimuth."""
    cos_o, cos_i = np.maximum(cos_o, GRAZING), np.maximum(cos_i, GRAZING)
    lambda_o, lambda_i = smith_lambda(cos_o, alpha, distribution), smith_lambda(cos_i, alpha, distribution)
    one_over_g = (1.0 + lambda_o) * (1.0 + lambda_i) if surface == SINGLE else 1.0 + lambda_o + lambda_i
    return 1.0 / (4.0 * cos_o * cos_i * one_over_g)


def smith_lambda(cos_theta: np.ndarray, alpha: float, distribution: str) -> np.ndarray:
    """Lambda of directions at cosines above the surface, from the exact projected area (Heitz16, eq. 3).

    `microfacet.smith_lambda` approximates Beckmann's, which would not balance to the last digit.
    """
    cos = np.maximum(np.ravel(cos_theta), GRAZING)
    w = np.stack([np.sqrt(np.maximum(1.0 - cos * cos, 0.0)), np.zeros_like(cos), cos], axis=-1)
    return np.maximum(projected_area(w, alpha, distribution) / cos - 1.0, 0.0).reshape(np.shape(cos_theta))


@dataclass(frozen=True, eq=False, repr=False)
class _StretchedCap:
    """Normals of the stretched hemisphere by angles a across and b along the plane of incidence."""

    vx: np.ndarray
    vz: np.ndarray
    alpha: float

    def normal(self, a, b):
        t2, depth = np.cos(a) * np.sin(b), np.cos(a) * np.cos(b)
        return depth * self.vx - t2 * self.vz, np.sin(a) + 0.0 * b, t2 * self.vx + depth * self.vz

    def transmitting_across(self, low, critical):
        """Largest a at which some facets do not reflect totally; 0 if all do."""
        p, q, half = self._harmonics(critical)
        trial = 2.0 * _trials(low)
        most = np.max(half + p * np.cos(trial) + q * np.sin(trial), axis=-1, keepdims=True)
        return np.arccos(np.minimum(critical * self.alpha / np.sqrt(np.maximum(most, 1e-300)), 1.0))

    def transmitting_along(self, a, across, low, critical):
        """The two b between which the facets at a do not reflect totally; equal if all do, as they do from `across` on."""
        p, q, half = self._harmonics(critical)
        least = np.square(critical * self.alpha / np.cos(a)) - half
        middle, reach = np.arctan2(q, p), np.arccos(np.clip(least / np.hypot(p, q), -1.0, 1.0))
        nearest = self._nearest(a, low, critical)
        return [np.where(a < across, np.clip(0.5 * (middle + side * reach), low, 0.5 * pi), nearest) for side in (-1.0, 1.0)]

    def _nearest(self, a, low, critical):
        """Of a few b, the one at which the facets at a are closest to not reflecting totally."""
        trial = _trials(low)
        cos_a, cos_b = np.cos(a), np.cos(trial)
        nz2 = np.square(cos_a * (np.sin(trial) * self.vx + cos_b * self.vz))
        excess = cos_a * cos_b - critical * np.sqrt(self.alpha**2 + (1.0 - self.alpha**2) * nz2)
        return np.take_along_axis(trial, np.argmax(excess, axis=-1)[..., None], axis=-1)

    def _harmonics(self, critical):
        """(p, q, half): facets do not reflect totally where cos(a)^2 (half + p cos(2 b) + q sin(2 b)) > (critical alpha)^2.

        Their cosine, cos(a) cos(b) in units of the stretched length, is to exceed `critical` times the length of the unstretched normal.
        """
        flat = np.square(critical) * (1.0 - self.alpha**2)
        return 0.5 - 0.5 * flat * (np.square(self.vz) - np.square(self.vx)), -flat * self.vx * self.vz, 0.5 - 0.5 * flat


def _trials(low):
    return low + (0.5 * pi - low) * (np.arange(24) + 0.5) / 24


def _joined(count, *edges):
    """Nodes and weights of `_rooted` pieces between consecutive edges, joined along the last axis."""
    return [np.concatenate(values, axis=-1) for values in zip(*(_rooted(count, *pair) for pair in zip(edges, edges[1:])))]


def _gauss(count, low, high):
    x, w = gauss_legendre(count)
    half = 0.5 * (high - low)
    return low + half * (x + 1.0), half * w


def _rooted(count, low, high):
    """Gauss nodes and weights in a variable in which square roots at both ends are smooth."""
    v, w = _gauss(count, 0.0, 1.0)
    return low + (high - low) * np.square(np.sin(0.5 * pi * v)), (high - low) * 0.5 * pi * np.sin(pi * v) * w


def dielectric_reflected(facets: Facets, facet: DielectricFacet) -> tuple[np.ndarray, np.ndarray]:
    """(wi, weights) of a dielectric, Fresnel included."""
    wi, weights = facets.reflected()
    return wi, weights * facet(facets.cos_om)


def dielectric_refracted(facets: Facets, facet: DielectricFacet) -> tuple[np.ndarray, np.ndarray]:
    """(wt, weights) of a dielectric, Fresnel included."""
    wt, weights = facets.refracted(facet.eta)
    return wt, weights * (1.0 - facet(facets.cos_om))


_LANCZOS = (
    0.99999999999980993, 676.5203681218851, -1259.1392167224028, 771.32342877765313, -176.61502916214059,
    12.507343278686905, -0.13857109526572012, 9.9843695780195716e-6, 1.5056327351493116e-7,
)  # fmt: skip


def log_gamma(x: np.ndarray) -> np.ndarray:
    """ln Gamma(x) for x >= 1 (Lanczos 1964, g = 7), relative error below 1e-13."""
    x = np.asarray(x, float) - 1.0
    series = _LANCZOS[0] + sum(c / (x + i) for i, c in enumerate(_LANCZOS[1:], start=1))
    t = x + 7.5
    return 0.5 * np.log(2.0 * pi) + (x + 0.5) * np.log(t) - t + np.log(series)
