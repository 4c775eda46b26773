# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of f in closed form: one event on the topmost rough surface, seen through smooth interfaces.

A smooth interface keeps s = n sin(theta), so both directions refract about the surface normal, light that bounces
between smooth interfaces is a geometric series per direction, and f / n^2 is what is carried through.
"""

from itertools import takewhile

import numpy as np

from ...optics.frame import dot, half_vector
from ...optics.fresnel import cos_theta_t, fresnel_dielectric
from ...optics.microfacet import is_specular
from .effective_stack import EffectiveStack
from .facets import reflection_lobe


def direct_f(effective: EffectiveStack, surface: str, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """f (P, 3) in 1/sr of this part, for directions (P, 3) above the surface."""
    smooth = 0
    while smooth < len(effective.interfaces) and is_specular(effective.interfaces[smooth].alpha):
        smooth += 1
    factor = _throughput(effective, smooth, wo[:, 2]) * _throughput(effective, smooth, wi[:, 2])
    n = effective.interfaces[smooth - 1].n_below if smooth else 1.0
    wo, wi = _inside(wo, n), _inside(wi, n)
    return factor * _event(effective, smooth, surface, wo, wi) / (n * n)


def _inside(w, n):
    """The direction with the same s in a medium of index n."""
    return np.concatenate([w[:, :2] / n, cos_theta_t(w[:, 2:], n)], axis=-1)


def _throughput(effective: EffectiveStack, smooth: int, cos_theta) -> np.ndarray:
    """Share (P, 3) of the light along one direction that gets through the first `smooth` interfaces, all bounces."""
    cosines = [cos_theta, *(cos_theta_t(cos_theta, i.n_below) for i in effective.interfaces[:smooth])]
    taus = [effective.tau_above, *effective.taus[:smooth]]
    crossing = [np.exp(-tau / np.maximum(c, 1e-12)[:, None]) for tau, c in zip(taus, cosines)]
    # adding of scalars from the top: what came through, and what the layers so far reflect from below
    through, back = crossing[0], np.zeros(crossing[0].shape)
    for k, interface in enumerate(effective.interfaces[:smooth]):
        reflectance = fresnel_dielectric(cosines[k], interface.eta)[:, None]
        trips = 1.0 / np.maximum(1.0 - back * reflectance, 1e-13)
        share = crossing[k + 1]
        through = through * trips * (1.0 - reflectance) * share
        back = (reflectance + np.square(1.0 - reflectance) * back * trips) * np.square(share)
    return through


def specular_reflectance(effective: EffectiveStack, cos_theta: np.ndarray) -> np.ndarray:
    """Share (P, 3) of the light from cosines (P,) that the smooth surfaces at the top turn back as a mirror, all bounces."""
    run = list(takewhile(lambda i: is_specular(i.alpha), effective.interfaces))
    cosines = [cos_theta, *(cos_theta_t(cos_theta, i.n_below) for i in run)]
    reflected = np.zeros((len(cos_theta), 3))
    if len(run) == len(effective.interfaces) and effective.base.is_specular:
        reflected = effective.base.reflectance(cosines[-1])
    for interface, tau, above, below in reversed(list(zip(run, effective.taus, cosines, cosines[1:]))):
        reflected = reflected * np.exp(-2.0 * tau / np.maximum(below, 1e-12)[:, None])
        f = fresnel_dielectric(above, interface.eta)[:, None]
        reflected = f + np.square(1.0 - f) * reflected / np.maximum(1.0 - f * reflected, 1e-13)
    return reflected * np.exp(-2.0 * effective.tau_above / np.maximum(cos_theta, 1e-12)[:, None])


def _event(effective: EffectiveStack, k: int, surface: str, wo, wi) -> np.ndarray:
    """f (P, 3) of one event on interface k or the base, for directions in the medium above it."""
    wh = half_vector(wi, wo)
    cos_h = np.clip(dot(wi, wh), 0.0, 1.0)
    if k < len(effective.interfaces):
        interface = effective.interfaces[k]
        fresnel = fresnel_dielectric(cos_h, interface.eta)[:, None] * np.ones(3)
        lobe = reflection_lobe(wo[:, 2], wi[:, 2], wh[:, 2], interface.alpha, interface.distribution, surface)
        return fresnel * lobe[:, None]
    base = effective.base
    if base.facets is None:
        return base.f(wi, wo)
    if base.is_specular:
        return np.zeros(wo.shape)
    lobe = reflection_lobe(wo[:, 2], wi[:, 2], wh[:, 2], base.facets.alpha, base.facets.distribution, surface)
    return base.reflectance(cos_h) * lobe[:, None]
