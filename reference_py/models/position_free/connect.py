# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections of a walk to a light direction (next event estimation of Guo18, for any number of interfaces).

From wi one light path per walk refracts straight down: u[0] = wi, u[1] below the first interface, and so on.
A walk at surface j evaluates its scattering towards u[j]. A path whose last stretch rises straight from surface
K to the light can be found by evaluating any of the surfaces K ... 0: the walk samples what lies before
that surface and the light path what lies above. The balance heuristic (Veach95) weights these techniques by

    p_j = prod_{i > j} p_walk(i, u[i]) prod_{i < j} p_light(i, u[i + 1]).

`carry` and `_lower` are the two running sums of its quotients. A smooth interface cannot be evaluated; its deltas
cancel in the quotients and leave the ratio of solid angles (`SmoothDielectric.density`). The densities of
`multiple` surfaces are approximate; weights of one path still add to 1, so the estimate stays unbiased.
"""

import numpy as np

from ...optics.directions import take
from .media import ScatteringMedium
from .rays import Rays
from .walk_surfaces import Surfaces

# Light that smooth surfaces trap for good meets no one.
_TRAPPED = 1e-13
_MIRROR = np.array([1.0, 1.0, -1.0])


class LightPaths:
    """One light path per row of wi (n, 3), wi_z > 0, and the sum `f` (n, 3) in 1/sr of the walks' connections."""

    def __init__(self, surfaces: Surfaces, wi: np.ndarray, rng: np.random.Generator):
        self.surfaces = surfaces
        self.f = np.zeros((len(wi), surfaces.channels))
        self._u = [np.asfortranarray(wi, float)]
        self._weight = [(1.0 / wi[:, 2])[:, None] * np.ones(surfaces.channels)]
        self._lower = [np.zeros(len(wi))]
        crossed, passed = [], []
        for index, surface in enumerate(surfaces.all[:-1]):
            u, lower = self._u[index], self._lower[index]
            event = surface.transmit(u, False, rng)
            below = -event.direction
            # what is turned back carries nothing; its direction only has to be a valid one
            below = np.asfortranarray(np.where(below[:, 2:] > 0.0, below, [0.0, 0.0, 1.0]))
            crossed.append(event.weight)
            tau = surfaces.tau[index]
            passed.append(1.0 if tau is None else np.exp(-tau / np.maximum(below[:, 2:], 1e-12)))
            self._u.append(below)
            before = surface.density(below, -u, True) * lower + (not surface.is_delta)
            self._lower.append(_quotient(before, surface.density(u, -below, False)))
        self._set_energies(crossed, passed)

    def _set_energies(self, crossed: list, passed: list) -> None:
        """Light just below each surface, on the next one, and what the smooth ones below turn back to the bottom of a medium.

        No walk can be connected above the smooth surfaces that a stack begins with, so there the light is that after all reflections between
        them. `crossed` and `passed` are the shares (n, 3 or 1) that one crossing of each surface and of the medium below it leaves.
        """
        surfaces = self.surfaces.all
        smooth = next((i for i, surface in enumerate(surfaces) if not surface.is_delta), len(surfaces))
        mirrored: dict[int, np.ndarray] = {smooth: np.zeros(1)}
        if smooth == len(surfaces):
            smooth -= 1
            mirrored[smooth] = surfaces[-1].reflectance(self._u[-1][:, 2])
        turned_back = {}
        for i in reversed(range(smooth)):
            turned_back[i] = 1.0 / np.maximum(1.0 - (1.0 - crossed[i]) * mirrored[i + 1] * np.square(passed[i]), _TRAPPED)
            mirrored[i] = 1.0 - crossed[i] + np.square(crossed[i] * passed[i]) * mirrored[i + 1] * turned_back[i]
        self._entering, self._rising = [], []
        energy = np.ones(self.f.shape)
        for i, (through, left) in enumerate(zip(crossed, passed)):
            # f_t(a, b) / n_b^2 = f_t(b, a) / n_a^2 (Walter07), telescoped over the interfaces
            spread = self.surfaces.n_above[i + 1] ** 2 * self._u[i + 1][:, 2:]
            energy = energy * through * turned_back.get(i, 1.0)
            self._entering.append(energy / spread)
            energy = energy * left
            self._weight.append(energy / spread)
            self._rising.append(energy * mirrored[i + 1] / spread if i < smooth else None)

    def target(self, index: int, from_below: bool, path: np.ndarray) -> np.ndarray:
        """Direction (n, 3) to evaluate at a surface, in the frame of its side."""
        u = take(self._u[index], path)
        return -u if from_below else u

    def connect(self, index: int, from_below: bool, rays, target: np.ndarray, toward: np.ndarray) -> None:
        """Add what rays at a rough surface send to the light: `toward` (n, 3 or 1) is BSDF times cosine."""
        surface = self.surfaces.all[index]
        techniques = 1.0 + surface.density(rays.w, target, from_below) * self._lower[index][rays.path]
        if from_below:
            techniques = techniques + surface.density(-target, -rays.w, False) * rays.carry
        self.f[rays.path] += rays.throughput * toward * (self._weight[index][rays.path] / techniques[:, None])

    def connect_medium(self, index: int, medium: ScatteringMedium, rays: Rays) -> None:
        """Add what rays that an event in the medium below surface `index` meets send to the light; their w is the travel before it.

        Such an event is one technique more, as one on a surface is that rises straight; the chances to fly on are left out of the
        weights, of which the light path and the walk then use the same. Where all surfaces above are smooth, light also comes from below.
        """
        target = take(self._u[index + 1], rays.path)
        toward = medium.toward(rays.w, target)
        techniques = 1.0 + toward * self._lower[index + 1][rays.path]
        passed = medium.passed(rays.depth, target[:, 2]) * self._entering[index][rays.path]
        sent = passed * (toward / techniques)[:, None]
        if self._rising[index] is not None:
            rising = medium.passed(1.0 - rays.depth, target[:, 2]) * self._rising[index][rays.path]
            sent = sent + rising * medium.toward(rays.w, target * _MIRROR)[:, None]
        self.f[rays.path] += rays.throughput * sent

    def carry_medium(self, medium: ScatteringMedium, w: np.ndarray, cos: np.ndarray) -> np.ndarray:
        """The deeper techniques' sum for rays that an event in a medium turned by these cosines (n,) into travel w (n, 3)."""
        return np.where(w[:, 2] > 0.0, 1.0 / medium.phase(cos), 0.0)

    def carry(self, index: int, from_below: bool, rays, w: np.ndarray, goes_up: bool) -> np.ndarray:
        """The deeper techniques' sum for rays that leave a surface along w, (n, 3) in the next one's frame."""
        if not goes_up:
            return np.zeros(len(w))
        surface = self.surfaces.all[index]
        techniques = np.full(len(w), 0.0 if surface.is_delta else 1.0)
        if not from_below:
            return _quotient(techniques, surface.density(rays.w, w, False))
        techniques = techniques + surface.density(w, -rays.w, False) * rays.carry
        return _quotient(techniques, surface.density(rays.w, -w, True))


def _quotient(a, b) -> np.ndarray:
    # bounded, so that paths of no weight stay finite through many layers
    return np.minimum(a / np.maximum(b, 1e-100), 1e100)
