# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk of light through a stack: a sequence of directions, without positions (Guo18).

Rays wait in one queue per surface and side, so that each step is one vectorised call with one index and one
alpha. A ray is known by `w`, which points back to where it came from, in the frame of the surface and side that
it meets next: that is, towards the surface's own half space. What a surface reflects keeps its frame on
the next surface, what it transmits is negated (`optics.microsurface`).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...optics.directions import take
from .connect import LightPaths
from .rays import Rays
from .walk_surfaces import Surfaces

# A ray whose brightest channel falls below this survives by chance, with that much.
_ROULETTE = 0.1
# Rays in a medium are followed until this share of them is left, which waits for others.
_LEFT = 0.25
_MEDIUM = None


class Walk:
    """Walks from the viewer through `surfaces`, one per row of wo (n, 3), wo_z > 0.

    With `light` every rough surface is connected to it and nothing is yielded. With `splits` what the first interface reflects and what it lets
    pass are rays of their own where it has no film: where the light below is dim, few bright reflections would be most of the noise.
    """

    def __init__(self, surfaces: Surfaces, wo: np.ndarray, rng: np.random.Generator, light: LightPaths | None = None, splits: bool = False):
        n = len(wo)
        self._splits = splits and len(surfaces) > 1 and surfaces.all[0].film is None
        self.surfaces, self.rng, self.light = surfaces, rng, light
        self.deepest = np.zeros(n, int)
        """(n,) deepest surface that each walk has met so far."""
        carry = None if light is None else np.zeros(n)
        is_grey = all(medium is None or medium.is_grey for medium in surfaces.media)
        share = None if is_grey else np.full((surfaces.channels, n), 1.0 / surfaces.channels).T
        start = Rays(np.asfortranarray(wo, float), np.ones((surfaces.channels, n)).T, np.arange(n), carry, share)
        self._queues = {(0, False): [start]}
        last = len(surfaces) - 1
        down = [place for i in range(last) for place in ((i, False), (i, _MEDIUM))] + [(last, False)]
        self._sweep = down + [place for i in reversed(range(last)) for place in ((i, _MEDIUM), (i, True))]

    def exits(self) -> Iterator[Rays]:
        """Rays that leave the stack, in portions; their w is wi. Each walk leaves once at most, twice if it is split."""
        while self._queues:
            for place in self._sweep:
                if place not in self._queues:
                    continue
                rays = Rays.joined(self._queues.pop(place))
                if place[1] is _MEDIUM:
                    self._fly(place[0], rays)
                else:
                    yield from self._step(place, rays)

    def _step(self, place: tuple[int, bool], rays: Rays) -> Iterator[Rays]:
        index, from_below = place
        surface = self.surfaces.all[index]
        light = None if surface.is_delta else self.light
        target = None if light is None else light.target(index, from_below, rays.path)
        if self._splits:
            event, rays = surface.split(rays.w, self.rng), Rays.joined([rays, rays])
            self._splits = False
        else:
            event = surface.scatter(rays.w, from_below, self.rng, target)
        if light is not None:
            light.connect(index, from_below, rays, target, event.toward)
        throughput = rays.throughput if event.weight is None else rays.throughput * event.weight
        reflected = event.direction[:, 2] > 0.0
        is_base = index == len(self.surfaces) - 1
        # `single` gives directions below the base no weight: nothing follows them
        for is_reflected in (True,) if is_base else (True, False):
            rows = np.flatnonzero(reflected == is_reflected)
            if not len(rows):
                continue
            w = take(event.direction, rows)
            w = w if is_reflected else -w
            before = rays.take(rows)
            after = replace(before, w=w, throughput=take(throughput, rows))
            goes_up = is_reflected != from_below
            if index == 0 and goes_up:
                if self.light is None:
                    yield after
                continue
            if self.light is not None:
                after = replace(after, carry=self.light.carry(index, from_below, before, w, goes_up))
            self._enqueue(index, goes_up, after, event.weight is not None)

    def _enqueue(self, index: int, goes_up: bool, rays: Rays, is_dimmed: bool) -> None:
        """Cross the medium to the next surface."""
        below = index - 1 if goes_up else index
        tau = self.surfaces.tau[below]
        if self.surfaces.media[below] is not None:
            if is_dimmed:
                rays = self._roulette(rays)
            w = rays.w if goes_up else -rays.w
            self._wait((below, _MEDIUM), replace(rays, w=w, depth=np.full(len(w), 1.0 if goes_up else 0.0)))
            return
        if tau is not None:
            passed = np.exp(-tau[:, None] / np.maximum(rays.w[:, 2], 1e-12)).T
            rays = replace(rays, throughput=rays.throughput * passed)
        if tau is not None or is_dimmed:
            rays = self._roulette(rays)
        self._wait((index - 1, True) if goes_up else (index + 1, False), rays)

    def _wait(self, place: tuple[int, bool | None], rays: Rays) -> None:
        if not len(rays.path):
            return
        if place[1] is False:
            self.deepest[rays.path] = np.maximum(self.deepest[rays.path], place[0])
        self._queues.setdefault(place, []).append(rays)

    def _fly(self, index: int, rays: Rays) -> None:
        """Events in the medium below surface `index`, until most rays have left it."""
        medium, few = self.surfaces.media[index], int(_LEFT * len(rays.path))
        while len(rays.path) > few:
            rays, place = medium.fly(rays, self.rng)
            if np.any(place):
                for where, to in ((-1, (index, True)), (1, (index + 1, False))):
                    left = rays.take(np.flatnonzero(place == where))
                    self._wait(to, replace(left, w=-where * left.w, depth=None))
                rays = rays.take(np.flatnonzero(place == 0))
            if medium.absorbs:
                rays = self._roulette(rays)
            w, cos = medium.turn(rays.w, self.rng)
            if self.light is None:
                rays = replace(rays, w=w)
            else:
                self.light.connect_medium(index, medium, rays)
                rays = replace(rays, w=w, carry=self.light.carry_medium(medium, w, cos))
        self._wait((index, _MEDIUM), rays)

    def _roulette(self, rays: Rays) -> Rays:
        brightest = rays.throughput.T.max(axis=0)
        if not len(brightest) or brightest.min() >= _ROULETTE:
            return rays
        chance = np.minimum(brightest / _ROULETTE, 1.0)
        alive = np.flatnonzero(self.rng.random(len(chance)) < chance)
        rays = rays.take(alive)
        return replace(rays, throughput=(rays.throughput.T / chance[alive]).T)


def connected_f(surfaces: Surfaces, wo: np.ndarray, wi: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """One estimate of f (n, 3) in 1/sr per row of wo and wi (n, 3), by a walk from wo connected to wi."""
    light = LightPaths(surfaces, wi, rng)
    for _ in Walk(surfaces, wo, rng, light).exits():
        pass
    return light.f
