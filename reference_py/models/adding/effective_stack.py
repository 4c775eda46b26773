# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as adding reads it: interfaces that do something, the media between them, the base, channel by channel."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...optics.bases import ConductorBase, DiffuseBase
from ...optics.facet_reflectance import DielectricFacet
from ...optics.interface import Interface, Microfacets
from ...optics.microfacet import is_specular
from ...optics.optical_stack import OpticalStack
from .assembly import Medium
from .direction_grid import Grid
from .operators import RESOLVED, Resolution, conductor_rows, lambert_rows, oren_nayar_rows, scattering_medium, transmittance

# Wide interfaces through which a root of radiance still shows. With 1, f of three of them moves by up to 1 % of itself; with 3, by less than 2e-5.
_BLURS = 2


@dataclass(frozen=True, eq=False, repr=False)
class EffectiveStack:
    """`tau_above` (channels,) is absorption above the first interface; `tau` of an interface is that of the medium below it.

    Interfaces between equal indices are left out: they do not exist, whatever their roughness. Where a medium that scatters
    ends at one, it stays, smooth, and does nothing.
    """

    tau_above: np.ndarray
    interfaces: tuple[Interface, ...]
    taus: tuple[np.ndarray, ...]
    base: DiffuseBase | ConductorBase

    @classmethod
    def of(cls, optics: OpticalStack) -> "EffectiveStack":
        """That of a resolved stack."""
        tau_above, kept, taus = np.zeros(optics.channels), [], []
        for interface in optics.interfaces:
            if interface.does_nothing and (interface.scattering or (kept and kept[-1].scattering)):
                interface = replace(interface, facets=Microfacets(interface.distribution, 0.0))
                kept.append(interface)
                taus.append(interface.tau)
            elif not interface.does_nothing:
                kept.append(interface)
                taus.append(interface.tau)
            elif kept:
                taus[-1] = taus[-1] + interface.tau
            else:
                tau_above = tau_above + interface.tau
        return cls(tau_above, tuple(kept), tuple(taus), optics.base)

    def grid(self, nodes: int) -> Grid:
        """Directions in all media, vacuum included; `nodes` from the normal to s = 1.

        Where light grazes a medium, or is about to be reflected totally at its end, radiance has a root, at which directions are cut. Smooth interfaces
        hand roots on, and so do those whose lobes are narrower than the nodes are apart; of what passes `_BLURS` wide ones nothing shows.
        """
        narrow = [i for i in self.interfaces if i.alpha * nodes < RESOLVED]
        roots = {n: {n} for n in (1.0, *(i.n_below for i in self.interfaces))}
        for passed in range(_BLURS + 1):
            roots = _handed_on(roots, self.interfaces) if passed else roots
            for _ in narrow:
                roots = _handed_on(roots, narrow)
        return Grid(tuple(tuple(sorted(root for root in roots[n] if root <= n)) for n in sorted(roots)), nodes)

    def narrowest_lobe(self) -> float:
        """Width in s of the narrowest lobe that passes a rough interface and is reflected below; infinite without any.

        A facet tilted by alpha turns s by (n_below - n_above) alpha where it refracts and 2 n alpha where it reflects.
        """
        surfaces = [(i.n_above, i.n_below - i.n_above, i.alpha) for i in self.interfaces]
        if self.base.facets is not None:
            surfaces.append((self.base.n_above, 0.0, self.base.facets.alpha))
        narrowest, passed = np.inf, 0.0
        for n, step, alpha in surfaces:
            alpha = 0.0 if is_specular(alpha) else alpha
            if passed > 0.0:
                narrowest = min(narrowest, np.hypot(passed, 2.0 * n * alpha))
            passed = np.hypot(passed, np.sqrt(2.0) * step * alpha)  # on the way down and up
        return narrowest

    def rough_alphas(self) -> list[float]:
        """Alphas of all surfaces that are not smooth."""
        facets = [i.facets for i in self.interfaces] + ([self.base.facets] if self.base.facets else [])
        return [f.alpha for f in facets if not is_specular(f.alpha)]

    def facets(self, channel: int) -> tuple[DielectricFacet, ...]:
        """What the interfaces' facets reflect in a channel of light from above."""
        return tuple(i.facet(channel) for i in self.interfaces)

    @cached_property
    def distinct_facets(self) -> list[tuple[DielectricFacet, ...]]:
        """What the facets of each interface reflect in any channel."""
        return [tuple(dict.fromkeys(interface.facet(channel) for channel in range(self.base.channels))) for interface in self.interfaces]

    def channels(self) -> list[tuple[int, list[int]]]:
        """(representative, members) of each set of channels that are alike."""
        groups: dict = {}
        for c in range(self.base.channels):
            scattered = (i.scattering.albedo[c] for i in self.interfaces if i.scattering)
            key = (self.base.channel_key(c), self.facets(c), self.tau_above[c], *(tau[c] for tau in self.taus), *scattered)
            groups.setdefault(key, []).append(c)
        return [(members[0], members) for members in groups.values()]

    def is_smooth_above(self, k: int) -> bool:
        """Whether light reaches the medium above interface k by smooth interfaces alone."""
        return all(is_specular(interface.alpha) for interface in self.interfaces[:k])

    def medium(self, k: int, channel: int, grid: Grid, modes: int) -> Medium:
        """The medium above interface k, or above the base if there are k interfaces."""
        if k == 0:
            return Medium(transmittance(grid, 1.0, self.tau_above[channel]))
        above, tau = self.interfaces[k - 1], float(self.taus[k - 1][channel])
        if above.scattering is None or above.scattering.albedo[channel] == 0.0:
            return Medium(transmittance(grid, above.n_below, tau))
        return scattering_medium(above.n_below, tau, float(above.scattering.albedo[channel]), above.scattering.g, grid, modes)


def _handed_on(roots: dict[float, set[float]], interfaces: Iterable[Interface]) -> dict[float, set[float]]:
    """By index of a medium, its roots and those of the media beyond these interfaces."""
    met = {n: set(own) for n, own in roots.items()}
    for i in interfaces:
        met[i.n_above] |= roots[i.n_below]
        met[i.n_below] |= roots[i.n_above]
    return met


def base_rows(base: DiffuseBase | ConductorBase, channel: int, cos_theta: np.ndarray, surface: str, grid: Grid, resolution: Resolution):
    """(reflected once, reflected otherwise), each (modes, I, N), of a base for walkers at cosines (I,)."""
    match base:
        case ConductorBase():
            metals = tuple(base.facet(c) for c in range(base.channels))
            setup = (base.facets.alpha, base.facets.distribution, surface, grid, resolution)
            return conductor_rows(metals, cos_theta, *setup)[channel]
        case DiffuseBase(sigma_deg=0.0):
            rows = lambert_rows(float(base.color[channel]), base.n_above, len(cos_theta), grid, resolution.modes)
        case DiffuseBase():
            rows = oren_nayar_rows(float(base.color[channel]), base.sigma_deg, base.n_above, cos_theta, grid, resolution.modes)
    return rows, np.zeros_like(rows)
