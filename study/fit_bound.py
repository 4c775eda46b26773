# SPDX-License-Identifier: GPL-3.0-or-later
"""How close any stack can come to data: the best sum, with positive weights, of very many lobes that stacks are made of.

A stack's f is such a sum, but for what is scattered repeatedly, which is as smooth as the diffuse parts that are among
them: single surfaces of many roughnesses and indices, the same under a clear or tinted layer, and diffuse bases. A sum may
have weights that no stack has, so no stack is expected to come closer than it; the dictionary is finite, so this is a
bound to the fineness of its steps. Needs scipy.
"""

import numpy as np

from ..reference_py.fit.metric import Metric, rms
from ..reference_py.optics.diffuse import oren_nayar
from ..reference_py.optics.frame import dot, half_vector
from ..reference_py.optics.fresnel import fresnel_dielectric
from ..reference_py.optics.microfacet import BECKMANN, GGX, distribution, masking_g2

_ALPHAS = (0.05, 0.08, 0.12, 0.16, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0)
_TOP_IORS, _UPPER_IORS, _LOWER_IORS = (1.1, 1.3, 1.5, 2.0, 3.0), (1.02, 1.1, 1.3, 1.6), (1.1, 1.5)
_TAUS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
_SIGMAS_DEG = (0.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0)
_STEPS = 6


def least_error(metric: Metric) -> float:
    """RMS residual of the best positive sum, for data of one channel: by least squares of the linearised metric."""
    from scipy.optimize import nnls

    m = metric.measurement
    lobes = np.stack(_lobes(m.wi, m.wo), axis=1)
    target, current, weights = metric.compressed(m.f)[:, 0], m.f[:, 0], None
    for _ in range(_STEPS):
        step = 1e-6 * np.mean(m.f)
        here = metric.compressed(current[:, None])[:, 0]
        slope = (metric.compressed(current[:, None] + step)[:, 0] - here) / step
        found, _ = nnls(lobes * slope[:, None], slope * current + target - here, maxiter=20 * lobes.shape[1])
        weights = found if weights is None else 0.5 * (weights + found)
        current = lobes @ weights
    return rms(metric.residual(current[:, None]))


def _lobes(wi: np.ndarray, wo: np.ndarray) -> list[np.ndarray]:
    surfaces = [(alpha, kind) for alpha in _ALPHAS for kind in (GGX, BECKMANN)]
    lobes = [_surface(wi, wo, *surface, ior) for surface in surfaces for ior in _TOP_IORS]
    for ior in (1.0, *_UPPER_IORS):
        crossed = (1.0 - fresnel_dielectric(wi[:, 2], ior)) * (1.0 - fresnel_dielectric(wo[:, 2], ior))
        below_i, below_o = _refracted(wi, ior), _refracted(wo, ior)
        path = 1.0 / below_i[:, 2] + 1.0 / below_o[:, 2]
        lower = [oren_nayar(below_i, below_o, np.ones(1), sigma)[:, 0] for sigma in _SIGMAS_DEG]
        # below an index of 1 a tint alone, which fades towards grazing
        lower += [_surface(below_i, below_o, *surface, n) for surface in surfaces for n in (_LOWER_IORS if ior > 1.0 else _TOP_IORS)]
        lobes += [part * crossed * np.exp(-tau * path) for part in lower for tau in _TAUS]
    return lobes


def _surface(wi, wo, alpha: float, kind, ior: float) -> np.ndarray:
    wh = half_vector(wi, wo)
    fresnel = fresnel_dielectric(np.clip(dot(wi, wh), 1e-6, 1.0), ior)
    return fresnel * distribution(wh[:, 2], alpha, kind) * masking_g2(wi[:, 2], wo[:, 2], alpha, kind) / (4.0 * wi[:, 2] * wo[:, 2])


def _refracted(w: np.ndarray, ior: float) -> np.ndarray:
    across = w[:, :2] / ior
    return np.concatenate([across, np.sqrt(1.0 - np.sum(np.square(across), axis=1, keepdims=True))], axis=1)
