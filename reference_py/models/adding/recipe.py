# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as adding reads it: interfaces that do something, the media between them, the base, channel by channel."""

from dataclasses import dataclass

import numpy as np

from ...material.stack import Stack
from ...optics.microfacet import alpha_from_roughness, is_specular
from ...optics.optical_stack import Interface, conductor_index, interfaces, n_above_base
from .direction_grid import Grid
from .operators import Resolution, conductor_rows, lambert_rows, oren_nayar_rows


@dataclass(frozen=True)
class Base:
    """The opaque base. `n` is the absolute index of the medium above it."""

    kind: str
    n: float
    color: tuple[float, ...] = (0.0, 0.0, 0.0)
    sigma_deg: float = 0.0
    alpha: float = 0.0
    distribution: str = ""
    index: tuple[tuple[float, float], ...] = ()
    """(eta, k) of each channel, relative to n."""

    @property
    def is_specular(self) -> bool:
        return self.kind == "conductor" and is_specular(self.alpha)

    def channel_key(self, channel: int):
        """Equal for channels that this base treats alike."""
        return self.index[channel] if self.index else self.color[channel]

    def rows(self, channel: int, cos_theta: np.ndarray, surface: str, grid: Grid, resolution: Resolution):
        """(reflected once, reflected otherwise), each (modes, I, N), for walkers at cosines (I,)."""
        if self.kind == "conductor":
            return conductor_rows(self.index, channel, self.n, cos_theta, self.alpha, self.distribution, surface, grid, resolution)
        color, modes = self.color[channel], resolution.modes
        if self.kind == "lambert":
            rows = lambert_rows(color, self.n, len(cos_theta), grid, modes)
        else:
            rows = oren_nayar_rows(color, self.sigma_deg, self.n, cos_theta, grid, modes)
        return rows, np.zeros_like(rows)


@dataclass(frozen=True)
class Recipe:
    """`tau_above` (3,) is absorption above the first interface; `tau` of an interface is that of the medium below it.

    Interfaces between equal indices are left out: they do not exist, whatever their roughness.
    """

    tau_above: np.ndarray
    interfaces: tuple[Interface, ...]
    taus: tuple[np.ndarray, ...]
    base: Base

    @classmethod
    def of(cls, stack: Stack) -> "Recipe":
        tau_above, kept, taus = np.zeros(3), [], []
        for interface in interfaces(stack):
            if interface.eta != 1.0:
                kept.append(interface)
                taus.append(interface.tau)
            elif kept:
                taus[-1] = taus[-1] + interface.tau
            else:
                tau_above = tau_above + interface.tau
        return cls(tau_above, tuple(kept), tuple(taus), _base(stack))

    def grid(self, nodes: int) -> Grid:
        return Grid(tuple(sorted({1.0, *(i.n_below for i in self.interfaces)})), nodes)

    def narrowest_lobe(self) -> float:
        """Width in s of the narrowest lobe that passes a rough interface and is reflected below; infinite without any.

        A facet tilted by alpha turns s by (n_below - n_above) alpha where it refracts and 2 n alpha where it reflects.
        """
        surfaces = [(i.n_above, i.n_below - i.n_above, i.alpha) for i in self.interfaces]
        if self.base.kind == "conductor":
            surfaces.append((self.base.n, 0.0, self.base.alpha))
        narrowest, passed = np.inf, 0.0
        for n, step, alpha in surfaces:
            alpha = 0.0 if is_specular(alpha) else alpha
            if passed > 0.0:
                narrowest = min(narrowest, np.hypot(passed, 2.0 * n * alpha))
            passed = np.hypot(passed, np.sqrt(2.0) * step * alpha)  # on the way down and up
        return narrowest

    def channels(self) -> list[tuple[int, list[int]]]:
        """(representative, members) of each set of channels that are alike."""
        groups: dict = {}
        for c in range(3):
            key = (self.base.channel_key(c), self.tau_above[c], *(tau[c] for tau in self.taus))
            groups.setdefault(key, []).append(c)
        return [(members[0], members) for members in groups.values()]


def _base(stack: Stack) -> Base:
    base, n = stack.base, n_above_base(stack)
    if base.kind == "lambert":
        return Base(base.kind, n, color=base["color"])
    if base.kind == "oren_nayar":
        return Base(base.kind, n, color=base["color"], sigma_deg=base["sigma_deg"])
    eta, k = conductor_index(base)
    index = tuple((float(a) / n, float(b) / n) for a, b in zip(eta, k))
    return Base(base.kind, n, alpha=float(alpha_from_roughness(base["roughness"])), distribution=base["distribution"], index=index)
