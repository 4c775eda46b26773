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
from .surfaces import Surfaces


class LightPaths:
    """One light path per row of wi (n, 3), wi_z > 0, and the sum `f` (n, 3) in 1/sr of the walks' connections."""

    def __init__(self, surfaces: Surfaces, wi: np.ndarray, rng: np.random.Generator):
        self.surfaces = surfaces
        self.f = np.zeros((len(wi), 3))
        self._u = [np.asfortranarray(wi, float)]
        self._weight = [(1.0 / wi[:, 2])[:, None] * np.ones(3)]
        self._lower = [np.zeros(len(wi))]
        self._entering: list[np.ndarray] = []
        energy = np.ones((len(wi), 3))
        for index, surface in enumerate(surfaces.all[:-1]):
            u, lower = self._u[index], self._lower[index]
            event = surface.transmit(u, False, rng)
            below = -event.direction
            # what is turned back carries nothing; its direction only has to be a valid one
            below = np.asfortranarray(np.where(below[:, 2:] > 0.0, below, [0.0, 0.0, 1.0]))
            energy = energy * event.weight
            # f_t(a, b) / n_b^2 = f_t(b, a) / n_a^2 (Walter07), telescoped over the interfaces
            spread = surfaces.n_above[index + 1] ** 2 * below[:, 2:]
            self._entering.append(energy / spread)
            if surfaces.tau[index] is not None:
                energy = energy * np.exp(-surfaces.tau[index] / np.maximum(below[:, 2:], 1e-12))
            self._weight.append(energy / spread)
            self._u.append(below)
            before = surface.density(below, -u, True) * lower + (not surface.is_delta)
            self._lower.append(_quotient(before, surface.density(u, -below, False)))

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
        weights, of which the light path and the walk then use the same.
        """
        target = take(self._u[index + 1], rays.path)
        toward = medium.toward(rays.w, target)
        techniques = 1.0 + toward * self._lower[index + 1][rays.path]
        passed = medium.passed(rays.depth, target[:, 2]) * self._entering[index][rays.path]
        self.f[rays.path] += rays.throughput * passed * (toward / techniques)[:, None]

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
