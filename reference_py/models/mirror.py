# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `mirror`: a network evaluated as Cycles evaluates its closures.

Equal to the render up to float32 rounding (`make test`, goniometer tests). It is not a model of the stack:
its distance from one is the network's error.
"""

import numpy as np

from ..frame import dot, half_vector
from ..network import DEFAULT_TIER, make_network
from ..network.lobe import DielectricCurve, DiffuseLobe, GlossyLobe, SchlickCurve
from ..optics.diffuse import oren_nayar
from ..optics.fresnel import fresnel_dielectric
from ..optics.microfacet import GGX, is_specular, smith_lambda
from ..stack import Stack
from .quadrature import directional_albedo


class Mirror:
    """f and albedo of the network of `tier`."""

    name = "mirror"
    stochastic = False

    def __init__(self, stack: Stack, tier: str = DEFAULT_TIER):
        self.network = make_network(stack, tier)

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like lobes have none and count as 0."""
        wo, wi = np.broadcast_arrays(np.asarray(wo, float), np.asarray(wi, float))
        visible = (wo[..., 2] > 0.0) & (wi[..., 2] > 0.0)
        lobes = self.network.lobes(np.where(visible, wo[..., 2], 1.0))
        total = sum(lobe_f(lobe, wo, wi) for lobe in lobes)
        return np.where(visible[..., None], total, 0.0)

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like lobes included."""
        wo = np.asarray(wo, float)
        lobes = self.network.lobes(wo[..., 2])
        glossy = [lobe for lobe in lobes if isinstance(lobe, GlossyLobe)]
        widths = [(lobe.distribution, float(np.max(lobe.alpha_x))) for lobe in glossy]
        total = directional_albedo(self.f, wo, widths)
        for lobe in glossy:
            if is_specular(np.max(lobe.alpha_x)):
                total = total + lobe.weight * _fresnel(lobe, wo[..., 2])
        return total


def lobe_f(lobe: GlossyLobe | DiffuseLobe, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """f (..., 3) of one lobe for directions above the surface, as Cycles' closure gives it."""
    if isinstance(lobe, DiffuseLobe):
        if lobe.color is None:
            return lobe.weight / np.pi * np.ones(wi.shape)
        return lobe.weight * oren_nayar(wi, wo, np.array(lobe.color), lobe.sigma_deg)
    if is_specular(np.max(lobe.alpha_x)):
        return np.zeros(wi.shape)
    x, y, n = _lobe_frame(wo, lobe.tilt)
    wh = half_vector(wi, wo)
    cos_i, cos_o = dot(wi, n), dot(wo, n)
    d = _distribution(lobe, dot(wh, x), dot(wh, y), dot(wh, n))
    lambda_o = _lambda(lobe, dot(wo, x), dot(wo, y), cos_o)
    lambda_i = _lambda(lobe, dot(wi, x), dot(wi, y), cos_i)
    # Cycles returns f times the cosine to the lobe's own normal; f refers to the surface's
    value = d / (4.0 * np.maximum(cos_o, 1e-20) * (1.0 + lambda_o + lambda_i)) / np.maximum(wi[..., 2], 1e-20)
    value = np.where((cos_o > 0.0) & (cos_i > 0.0), value, 0.0)
    return lobe.weight * value[..., None] * _fresnel(lobe, dot(wi, wh))


def _lobe_frame(wo, tilt):
    """Axes along and across the plane of incidence and the lobe's normal, turned by `tilt` to the viewer."""
    sin_o = np.hypot(wo[..., 0], wo[..., 1])[..., None]
    along = np.where(sin_o > 1e-12, wo * np.array([1.0, 1.0, 0.0]) / np.maximum(sin_o, 1e-12), np.array([1.0, 0.0, 0.0]))
    up = np.array([0.0, 0.0, 1.0])
    cos_t, sin_t = np.cos(tilt)[..., None], np.sin(tilt)[..., None]
    x = cos_t * along - sin_t * up
    n = cos_t * up + sin_t * along
    return x, np.cross(n, x), n


def _distribution(lobe, x, y, z):
    """Anisotropic D (Heitz14, eqs. 84 and 85) of the half vector (x, y, z) in the lobe's frame."""
    slope2 = (np.square(x / lobe.alpha_x) + np.square(y / lobe.alpha_y)) / np.maximum(np.square(z), 1e-20)
    scale = 1.0 / (np.pi * lobe.alpha_x * lobe.alpha_y * np.maximum(np.square(np.square(z)), 1e-40))
    density = scale / np.square(1.0 + slope2) if lobe.distribution == GGX else scale * np.exp(-slope2)
    return np.where(z > 0.0, density, 0.0)


def _lambda(lobe, x, y, z):
    # smith_lambda takes alpha and a cosine; an anisotropic lobe has the alpha of the direction's azimuth
    sin2 = np.maximum(np.square(x) + np.square(y), 1e-30)
    alpha = np.sqrt((np.square(lobe.alpha_x * x) + np.square(lobe.alpha_y * y)) / sin2)
    return smith_lambda(z / np.sqrt(sin2 + np.square(z)), alpha, lobe.distribution)


def _fresnel(lobe, cos_h):
    if isinstance(lobe.fresnel, DielectricCurve):
        return fresnel_dielectric(cos_h, lobe.fresnel.eta)[..., None]
    if isinstance(lobe.fresnel, SchlickCurve):
        rise = np.power(np.clip(1.0 - cos_h, 0.0, 1.0), 5)[..., None]
        return lobe.fresnel.f0 + (lobe.fresnel.f90 - lobe.fresnel.f0) * rise
    return np.ones(np.shape(cos_h) + (1,))
