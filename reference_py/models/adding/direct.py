# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of f in closed form: one or two reflections on the topmost rough surface, or one event in a medium above that, seen through smooth
interfaces.

A smooth interface keeps s = n sin(theta), so both directions refract about the surface normal, light that bounces
between smooth interfaces is a geometric series per direction, and f / n^2 is what is carried through.
"""

from itertools import takewhile

import numpy as np

from ...optics.facet_reflectance import DielectricFacet, Facet
from ...optics.frame import dot, half_vector
from ...optics.fresnel import cos_theta_t
from ...optics.interface import Interface
from ...optics.microfacet import is_specular
from ...optics.slab import henyey_greenstein, peak, single_scattering, without_peak
from .direction_grid import Grid
from .effective_stack import EffectiveStack
from .facets import reflection_lobe
from .film_operators import told_by_few
from .operators import Resolution, knows_two_events, phase_terms
from .two_events import two_reflections

# Fresnel curves that one table of two reflections holds.
_AT_ONCE = 12


def direct_f(effective: EffectiveStack, surface: str, wo: np.ndarray, wi: np.ndarray, grid: Grid, resolution: Resolution) -> np.ndarray:
    """f (P, 3) in 1/sr of this part, for directions (P, 3) above the surface; the rest comes from `grid` at this resolution."""
    run_o, run_i = _SmoothRun(effective, wo[:, 2]), _SmoothRun(effective, wi[:, 2])
    n = effective.interfaces[run_o.depth - 1].n_below if run_o.depth else 1.0
    event = _event(effective, run_o.depth, surface, _inside(wo, n), _inside(wi, n), resolution)
    f = run_o.through * run_i.through * event / (n * n)
    for k, interface in enumerate(effective.interfaces[: run_o.depth]):
        if interface.scattering is not None:
            f = f + _scattered_once(interface, run_o.at(k), run_i.at(k), _inside(wo, interface.n_below), _inside(wi, interface.n_below), grid)
    return f


def _inside(w, n):
    """The direction with the same s in a medium of index n."""
    if n == 1.0:
        return w
    return np.concatenate([w[:, :2] / n, cos_theta_t(w[:, 2:], n)], axis=-1)


class _SmoothRun:
    """Light along one direction, of cosines (P,), through the smooth surfaces at the top: all reflections between them, a series each.

    `depth` interfaces are smooth; `through` (P, 3) of the light meets the next surface, `mirrored` comes back.
    """

    def __init__(self, effective: EffectiveStack, cos_theta: np.ndarray):
        run = list(takewhile(lambda i: is_specular(i.alpha), effective.interfaces))
        cosines = [cos_theta, *(cos_theta_t(cos_theta, i.n_below) for i in run)]
        crossing = [
            np.exp(-tau / np.maximum(c, 1e-12)[:, None]) if np.any(tau) else np.ones((len(c), len(tau)))
            for tau, c in zip((effective.tau_above, *effective.taus), cosines)
        ]
        reflectances = [i.reflectance(cosine) for cosine, i in zip(cosines, run)]
        self.depth = len(run)
        self.mirrored = np.zeros((len(cos_theta), effective.base.channels))
        if self.depth == len(effective.interfaces) and effective.base.is_specular:
            self.mirrored = effective.base.reflectance(cosines[-1])
        self._below, trips = [], []
        for f, share in reversed(list(zip(reflectances, crossing[1:]))):
            self._below.insert(0, self.mirrored)
            back = self.mirrored * np.square(share)
            trips.insert(0, 1.0 / np.maximum(1.0 - f * back, 1e-13))
            self.mirrored = f + np.square(1.0 - f) * back * trips[0]
        self.mirrored = self.mirrored * np.square(crossing[0])
        self.through, self._entering, self._shares = crossing[0], [], crossing[1:]
        for f, share, more in zip(reflectances, crossing[1:], trips):
            self._entering.append(self.through * (1.0 - f) * more)
            self.through = self._entering[-1] * share

    def at(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Light (P, 3) that enters the medium below interface k from above, and that then comes from below."""
        entering = self._entering[k]
        return entering, entering * self._shares[k] * self._below[k]


def specular_reflectance(effective: EffectiveStack, cos_theta: np.ndarray) -> np.ndarray:
    """Share (P, 3) of the light from cosines (P,) that the smooth surfaces at the top turn back as a mirror, all bounces."""
    return _SmoothRun(effective, cos_theta).mirrored


def _scattered_once(interface: Interface, light_o, light_i, wo, wi, grid: Grid) -> np.ndarray:
    """f (P, 3) of one event in the medium below an interface, by the whole phase function (Nakajima88: what a cut one leaves is smooth)."""
    scattering, terms = interface.scattering, phase_terms(grid, interface.n_below)
    tau, albedo = without_peak(interface.tau, scattering.albedo, scattering.g, terms)
    albedo = albedo / (1.0 - peak(scattering.g, terms))
    (down_o, up_o), (down_i, up_i) = light_o, light_i
    back, on = single_scattering(np.maximum(wo[:, 2:], 1e-12), np.maximum(wi[:, 2:], 1e-12), tau)
    mirrored = wi * np.array([1.0, 1.0, -1.0])
    turned_back, turned_on = (henyey_greenstein(-dot(wo, w), scattering.g)[:, None] for w in (wi, mirrored))
    f = turned_back * back * (down_o * down_i + up_o * up_i) + turned_on * on * (down_o * up_i + up_o * down_i)
    return albedo * f / interface.n_below**2


def _event(effective: EffectiveStack, k: int, surface: str, wo, wi, resolution: Resolution) -> np.ndarray:
    """f (P, 3) of one or two events on interface k or the base, for directions in the medium above it."""
    wh = half_vector(wi, wo)
    cos_h = np.clip(dot(wi, wh), 0.0, 1.0)
    base = effective.base
    if k < len(effective.interfaces):
        interface = effective.interfaces[k]
        facets, fresnel = interface.facets, interface.reflectance(cos_h)
        met = [interface.facet(c) for c in range(fresnel.shape[1])]
    elif base.facets is None:
        return base.f(wi, wo)
    elif base.is_specular:
        return np.zeros((len(wo), base.channels))
    else:
        facets, fresnel, met = base.facets, base.reflectance(cos_h), [base.facet(c) for c in range(base.channels)]
    lobe = (facets.alpha, facets.distribution)
    f = fresnel * reflection_lobe(wo[:, 2], wi[:, 2], wh[:, 2], *lobe, surface)[:, None]
    if knows_two_events(surface, facets.alpha, resolution):
        f = f + _two_events(wo, wi, *lobe, met)
    return f


def _two_events(wo, wi, alpha: float, distribution: str, met: list[Facet]) -> np.ndarray:
    """f (P, len(met)) of two reflections on such facets."""
    distinct = tuple(dict.fromkeys(met))
    known, shares = told_by_few(distinct) if isinstance(distinct[0], DielectricFacet) else (distinct, np.eye(len(distinct)))
    sines = np.maximum(np.hypot(wo[:, 0], wo[:, 1]) * np.hypot(wi[:, 0], wi[:, 1]), 1e-12)
    turn = (wo[:, 2], wi[:, 2], -(wo[:, 0] * wi[:, 0] + wo[:, 1] * wi[:, 1]) / sines)
    # of many channels a few at a time, which bounds memory
    tables = (two_reflections(alpha, distribution, known[i : i + _AT_ONCE]) for i in range(0, len(known), _AT_ONCE))
    f = np.concatenate([table(*turn) for table in tables], axis=1) @ shares.T
    return f[:, [distinct.index(facet) for facet in met]]
