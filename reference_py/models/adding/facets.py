# SPDX-License-Identifier: GPL-3.0-or-later
"""One scattering event on a rough surface, by quadrature over the visible facet normals.

Points and weights follow the lobe, so a lobe of any width costs the same and keeps its energy exactly. The visible
GGX normals are a uniform cap of a stretched hemisphere (Heitz18, "Sampling the GGX Distribution of Visible Normals");
Beckmann shares the points, its slope density is at most 1.48 times that of GGX of the same alpha.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from ...optics.fresnel import fresnel_dielectric
from ...optics.microfacet import GGX, smith_lambda

SINGLE, MULTIPLE = "single", "multiple"
SURFACES = (MULTIPLE, SINGLE)


@dataclass(frozen=True)
class Facets:
    """Microfacets met by a walker; the plane of incidence is xz. Directions leave the surface, upwards is z > 0."""

    wo: np.ndarray
    """(I, 1, 3) directions towards the origin of the walker."""
    wm: np.ndarray
    """(I, Q, 3) facet normals, the half with y >= 0; the other half mirrors it."""
    weights: np.ndarray
    """(I, Q) share of the visible area, sums to 1 over Q for `multiple`."""
    alpha: float
    kind: str
    surface: str

    @property
    def cos_om(self) -> np.ndarray:
        """(I, Q) cosine between wo and the facet normal."""
        return np.sum(self.wo * self.wm, axis=-1)

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
        return smith_lambda(np.maximum(cos_theta, 1e-12), self.alpha, self.kind)

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


def visible_facets(cos_theta: np.ndarray, alpha: float, kind: str, surface: str, across: int, along: int) -> Facets:
    """Quadrature over the normals seen at cosines (I,) > 0; `across` and `along` points of the plane of incidence."""
    cos_theta = np.asarray(cos_theta, float)
    sin_theta = np.sqrt(1.0 - np.square(cos_theta))
    length = np.hypot(alpha * sin_theta, cos_theta)
    vx, vz = (alpha * sin_theta / length)[:, None, None], (cos_theta / length)[:, None, None]
    x_a, w_a = np.polynomial.legendre.leggauss(across)
    x_b, w_b = np.polynomial.legendre.leggauss(along)
    a, w_a = (0.25 * pi * (x_a + 1.0))[:, None], (w_a * 0.25 * pi)[:, None]
    # from the stretched horizon, where the slope is infinite, to the edge of the visible disc
    low = -np.arctan2(vz, vx)
    b = low + (0.5 * pi - low) * 0.5 * (x_b + 1.0)
    t1, t2, depth = np.sin(a), np.cos(a) * np.sin(b), np.cos(a) * np.cos(b)
    nx, ny, nz = depth * vx - t2 * vz, np.broadcast_to(t1, b.shape[:1] + (across, along)), t2 * vx + depth * vz
    nz = np.maximum(nz, 1e-12)
    weights = np.square(np.cos(a)) * np.cos(b) * w_a * w_b
    weights = weights / weights.sum(axis=(1, 2), keepdims=True)
    if kind != GGX:
        slope2 = (np.square(nx) + np.square(ny)) / np.square(nz)
        weights = weights * np.square(1.0 + slope2) * np.exp(-slope2)
        if surface == MULTIPLE:  # the walk on the microsurface draws normals from the normalised density
            weights = weights / np.maximum(weights.sum(axis=(1, 2), keepdims=True), 1e-300)
        else:
            ratio = (1.0 + smith_lambda(cos_theta, alpha, GGX)) / (1.0 + smith_lambda(cos_theta, alpha, kind))
            weights = weights * ratio[:, None, None]
    wm = np.stack([alpha * nx, alpha * ny, nz], axis=-1)
    wm = wm / np.linalg.norm(wm, axis=-1, keepdims=True)
    wo = np.stack([sin_theta, np.zeros_like(sin_theta), cos_theta], axis=-1)[:, None, :]
    flat = (len(cos_theta), across * along)
    return Facets(wo, wm.reshape(*flat, 3), weights.reshape(flat), alpha, kind, surface)


def dielectric_events(facets: Facets, eta: float):
    """((wi, weights), (wt, weights)) of a dielectric, Fresnel included; eta = n_t / n_i."""
    reflectance = fresnel_dielectric(facets.cos_om, eta)
    wi, w_reflected = facets.reflected()
    wt, w_refracted = facets.refracted(eta)
    return (wi, w_reflected * reflectance), (wt, w_refracted * (1.0 - reflectance))


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
