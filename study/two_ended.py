# SPDX-License-Identifier: GPL-3.0-or-later
"""f of one rough surface, a dielectric over black or a metal, by walks on its facets (Heitz16) that are also drawn from the light's side.

The walks of `position_free` are connected to the light by the one facet that would send it there. Where view and light both graze a narrow surface, such
facets are rare and bright, and what is not met does not show in the estimated error. Here the last ray is drawn among the facets that the light sees, too,
and both ways are weighted by the balance heuristic (Veach95).
"""

from collections.abc import Callable

import numpy as np

from ..reference_py.optics.frame import dot, reflect
from ..reference_py.optics.fresnel import fresnel_dielectric
from ..reference_py.optics.microfacet import facet_distribution
from ..reference_py.optics.sampling import projected_area, sample_visible_normals

_BATCH = 1 << 16
# Times the walks that are asked for, at most.
_MOST = 16


def reflected_f(
    eta: float, alpha: float, distribution: str, wo: np.ndarray, wi: np.ndarray, walks: int, rng: np.random.Generator, noise: float = np.inf
) -> tuple[float, float]:
    """f in 1/sr of a dielectric between two directions (3,) and its standard error, from so many walks, a whole number of batches of 65536, and as many again
    until the error is this share of f."""
    f, stderr = _estimate(_Walks(eta, alpha, distribution, wo, wi, rng).toward, walks, wi, noise)
    return float(f), float(stderr)


def metal_f(
    reflectance: Callable[[np.ndarray], np.ndarray],
    alpha: float,
    distribution: str,
    wo: np.ndarray,
    wi: np.ndarray,
    walks: int,
    rng: np.random.Generator,
    noise: float = np.inf,
) -> tuple[np.ndarray, np.ndarray]:
    """The same of a metal, of whose facets `reflectance` gives (n, channels) at cosines (n,): both (channels,)."""
    return _estimate(_MetalWalks(reflectance, alpha, distribution, wo, wi, rng).toward, walks, wi, noise)


def _estimate(toward: Callable[[], np.ndarray], walks: int, wi, noise: float) -> tuple[np.ndarray, np.ndarray]:
    means: list[np.ndarray] = []
    while True:
        means += [np.mean(toward(), axis=0) / wi[2] for _ in range(max(walks // _BATCH, 2))]
        f, stderr = np.mean(means, axis=0), np.std(means, axis=0, ddof=1) / np.sqrt(len(means))
        if np.all(stderr <= noise * f) or len(means) * _BATCH >= _MOST * walks:
            return f, stderr


class _Walks:
    """One batch. A direction w points back to where light came from; inside the material all is upside down, with 1 - c for the height c."""

    def __init__(self, eta, alpha, distribution, wo, wi, rng):
        self._eta, self._lobe, self._rng = eta, (alpha, distribution), rng
        self._wo, self._wi = (np.tile(w, (_BATCH, 1)) for w in (wo, wi))
        area = projected_area(self._wi[:1], *self._lobe)
        self._lambda, self._area = area / wi[2] - 1.0, area

    def toward(self) -> np.ndarray:
        """(n,) BSDF times cosine that each walk sends to wi."""
        total, ray = np.zeros(_BATCH), np.arange(_BATCH)
        w, log_c, outside = self._wo, np.zeros(_BATCH), np.ones(_BATCH, bool)
        drawn = np.full(_BATCH, np.nan)  # density of the last ray, where the light's side could have drawn it
        while len(ray):
            log_c = self._advanced(w, log_c)
            stay = np.flatnonzero(log_c < 0.0)
            w, log_c, outside, ray, drawn = w[stay], log_c[stay], outside[stay], ray[stay], drawn[stay]
            above, below = np.flatnonzero(outside), np.flatnonzero(~outside)
            direct = self._reflected(w[above], self._wi[: len(above)]) * self._escape(log_c[above])
            other = self._facets(self._wi[: len(above)], w[above])
            total[ray[above]] += direct * np.where(np.isnan(drawn[above]), 1.0, drawn[above] / np.maximum(drawn[above] + other, 1e-300))
            total[ray[above]] += self._from_the_light(w[above], log_c[above])
            total[ray[below]] += self._refracted(w[below], -self._wi[: len(below)]) * self._escape(_upside_down(log_c[below]))
            w, log_c, outside, drawn = self._next(w, log_c, outside)
        return total

    def _from_the_light(self, w, log_c) -> np.ndarray:
        """Of paths with one event more, whose last ray is drawn from the facets that the light sees."""
        wi = self._wi[: len(w)]
        back = reflect(wi, sample_visible_normals(wi, *self._lobe, self._rng))
        first, then = self._reflected(w, -back), self._reflected(back, wi)
        log_c = self._advanced(back, log_c)
        both = first + self._facets(wi, back)
        return np.where(log_c < 0.0, first * then * self._escape(np.minimum(log_c, 0.0)) / np.maximum(both, 1e-300), 0.0)

    def _next(self, w, log_c, outside):
        eta = np.where(outside, self._eta, 1.0 / self._eta)
        wm = sample_visible_normals(w, *self._lobe, self._rng)
        cos = dot(w, wm)
        cos_t = np.sqrt(np.maximum(1.0 - (1.0 - cos * cos) / (eta * eta), 0.0))
        is_reflected = self._rng.random(len(w)) < _fresnel(cos, eta)
        turned = reflect(w, wm)
        bent = (cos / eta - cos_t)[:, None] * wm - w / eta[:, None]
        on = np.where(is_reflected[:, None], -turned, bent)
        stays = is_reflected & outside
        drawn = np.where(stays, self._reflected(w, turned), np.nan)
        return on, np.where(is_reflected, log_c, _upside_down(log_c)), outside == is_reflected, drawn

    def _advanced(self, w, log_c) -> np.ndarray:
        with np.errstate(divide="ignore", over="ignore"):
            return log_c - self._rng.standard_exponential(len(w)) * (w[:, 2] / projected_area(w, *self._lobe))

    def _facets(self, w, o) -> np.ndarray:
        """Density (n,) of o as the mirror direction of facets seen from w."""
        h = w + o
        return 0.25 * facet_distribution(h / np.maximum(np.linalg.norm(h, axis=1), 1e-30)[:, None], *self._lobe) / projected_area(w, *self._lobe)

    def _reflected(self, w, o) -> np.ndarray:
        return _fresnel(0.5 * np.linalg.norm(w + o, axis=1), np.full(len(w), self._eta)) * self._facets(w, o)

    def _refracted(self, w, o) -> np.ndarray:
        """Density of refracted directions from within (Walter07, eq. 17)."""
        eta = 1.0 / self._eta
        h = -(w + eta * o)
        length2 = np.maximum(dot(h, h), 1e-30)
        h = h / (np.sqrt(length2) * np.where(h[:, 2] < 0.0, -1.0, 1.0))[:, None]
        cos, cos_o = dot(w, h), -dot(o, h)
        seen = np.where((cos > 0.0) & (cos_o > 0.0), cos * cos_o, 0.0) * facet_distribution(h, *self._lobe) / projected_area(w, *self._lobe)
        return (1.0 - _fresnel(np.abs(cos), np.full(len(w), eta))) * seen * eta * eta / length2

    def _escape(self, log_c) -> np.ndarray:
        return np.exp(log_c * self._lambda)


class _MetalWalks(_Walks):
    """One batch on a metal, whose facets absorb what they do not reflect."""

    def __init__(self, reflectance, *surface_and_directions):
        super().__init__(None, *surface_and_directions)
        self._reflectance = reflectance

    def toward(self) -> np.ndarray:
        """(n, channels) BSDF times cosine that each walk sends to wi."""
        ray, w, log_c = np.arange(_BATCH), self._wo, np.zeros(_BATCH)
        throughput = np.ones((_BATCH, self._reflectance(np.ones(1)).shape[1]))
        total, drawn = np.zeros_like(throughput), np.full(_BATCH, np.nan)
        while len(ray):
            log_c = self._advanced(w, log_c)
            stay = np.flatnonzero(log_c < 0.0)
            w, log_c, ray, drawn, throughput = w[stay], log_c[stay], ray[stay], drawn[stay], throughput[stay]
            wi, escape = self._wi[: len(w)], self._escape(log_c)
            direct, other = self._facets(w, wi) * escape, self._facets(wi, w)
            direct *= np.where(np.isnan(drawn), 1.0, drawn / np.maximum(drawn + other, 1e-300))
            total[ray] += throughput * self._mirrored(w, wi) * direct[:, None]
            total[ray] += throughput * self._from_the_light(w, log_c)
            wm = sample_visible_normals(w, *self._lobe, self._rng)
            on = -reflect(w, wm)
            drawn, throughput, w = self._facets(w, -on), throughput * self._mirrored(w, -on), on
        return total

    def _from_the_light(self, w, log_c) -> np.ndarray:
        wi = self._wi[: len(w)]
        back = reflect(wi, sample_visible_normals(wi, *self._lobe, self._rng))
        first, then = self._facets(w, -back), self._facets(back, wi)
        log_c = self._advanced(back, log_c)
        both = first + self._facets(wi, back)
        value = np.where(log_c < 0.0, first * then * self._escape(np.minimum(log_c, 0.0)) / np.maximum(both, 1e-300), 0.0)
        return value[:, None] * self._mirrored(w, -back) * self._mirrored(back, wi)

    def _mirrored(self, w, o) -> np.ndarray:
        """What a facet reflects (n, channels) that mirrors w into o."""
        return self._reflectance(np.clip(0.5 * np.linalg.norm(w + o, axis=1), 0.0, 1.0))


def _fresnel(cos, eta) -> np.ndarray:
    """By rows, as eta is that of the side where each ray is."""
    result = np.empty(len(cos))
    for value in np.unique(eta):
        here = eta == value
        result[here] = fresnel_dielectric(np.clip(cos[here], 0.0, 1.0), value)
    return result


def _upside_down(log_c) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return np.log(-np.expm1(np.minimum(log_c, 0.0)))
