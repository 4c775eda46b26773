# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk of light through a stack: a sequence of directions, without positions (Guo18).

Rays wait in one queue per surface and side, so that each step is one vectorised call with one index and one
alpha. A ray is known by `w`, which points back to where it came from, in the frame of the surface and side that
it meets next: that is, towards the surface's own half space. What a surface reflects keeps its frame on
the next surface, what it transmits is negated (`optics.microsurface`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...optics.directions import take
from .connect import LightPaths
from .surfaces import Surfaces

# A ray whose brightest channel falls below this survives by chance, with that much.
_ROULETTE = 0.1


@dataclass(frozen=True)
class Rays:
    """Rays that wait for a surface, one per row."""

    w: np.ndarray
    """(n, 3)"""
    throughput: np.ndarray
    """(n, 3), RGB"""
    path: np.ndarray
    """(n,), index of the walk"""
    carry: np.ndarray | None = None
    """(n,), what `connect` has to remember; None without a light"""

    def take(self, index: np.ndarray) -> "Rays":
        """The rays at an index (m,)."""
        carry = None if self.carry is None else self.carry[index]
        return Rays(take(self.w, index), take(self.throughput, index), self.path[index], carry)


def _joined(parts: list[Rays]) -> Rays:
    if len(parts) == 1:
        return parts[0]
    return Rays(
        np.concatenate([p.w.T for p in parts], axis=1).T,
        np.concatenate([p.throughput.T for p in parts], axis=1).T,
        np.concatenate([p.path for p in parts]),
        None if parts[0].carry is None else np.concatenate([p.carry for p in parts]),
    )


class Walk:
    """Walks from the viewer through `surfaces`, one per row of wo (n, 3), wo_z > 0.

    With `light` every rough surface is connected to it and nothing is yielded.
    """

    def __init__(self, surfaces: Surfaces, wo: np.ndarray, rng: np.random.Generator, light: LightPaths | None = None):
        n = len(wo)
        self.surfaces, self.rng, self.light = surfaces, rng, light
        self.deepest = np.zeros(n, int)
        """(n,) deepest surface that each walk has met so far."""
        carry = None if light is None else np.zeros(n)
        start = Rays(np.asfortranarray(wo, float), np.ones((3, n)).T, np.arange(n), carry)
        self._queues = {(0, False): [start]}
        last = len(surfaces) - 1
        self._sweep = [(i, False) for i in range(last + 1)] + [(i, True) for i in reversed(range(last))]

    def exits(self) -> Iterator[Rays]:
        """Rays that leave the stack, in portions; their w is wi. Each walk leaves once at most."""
        while self._queues:
            for place in self._sweep:
                if place in self._queues:
                    yield from self._step(place, _joined(self._queues.pop(place)))

    def _step(self, place: tuple[int, bool], rays: Rays) -> Iterator[Rays]:
        index, from_below = place
        surface = self.surfaces.all[index]
        light = None if surface.is_delta else self.light
        target = None if light is None else light.target(index, from_below, rays.path)
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
            after = Rays(w, take(throughput, rows), rays.path[rows])
            goes_up = is_reflected != from_below
            if index == 0 and goes_up:
                if self.light is None:
                    yield after
                continue
            carry = None
            if self.light is not None:
                carry = self.light.carry(index, from_below, rays.take(rows), w, goes_up)
            self._enqueue(index, goes_up, Rays(after.w, after.throughput, after.path, carry), event.weight is not None)

    def _enqueue(self, index: int, goes_up: bool, rays: Rays, is_dimmed: bool) -> None:
        """Cross the medium to the next surface."""
        tau = self.surfaces.tau[index - 1 if goes_up else index]
        if tau is not None:
            passed = np.exp(-tau[:, None] / np.maximum(rays.w[:, 2], 1e-12)).T
            rays = Rays(rays.w, rays.throughput * passed, rays.path, rays.carry)
        if tau is not None or is_dimmed:
            rays = self._roulette(rays)
        if not len(rays.path):
            return
        if not goes_up:
            self.deepest[rays.path] = np.maximum(self.deepest[rays.path], index + 1)
        self._queues.setdefault((index - 1, True) if goes_up else (index + 1, False), []).append(rays)

    def _roulette(self, rays: Rays) -> Rays:
        brightest = rays.throughput.T.max(axis=0)
        if brightest.min() >= _ROULETTE:
            return rays
        chance = np.minimum(brightest / _ROULETTE, 1.0)
        alive = np.flatnonzero(self.rng.random(len(chance)) < chance)
        rays = rays.take(alive)
        return Rays(rays.w, (rays.throughput.T / chance[alive]).T, rays.path, rays.carry)


def connected_f(surfaces: Surfaces, wo: np.ndarray, wi: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """One estimate of f (n, 3) in 1/sr per row of wo and wi (n, 3), by a walk from wo connected to wi."""
    light = LightPaths(surfaces, wi, rng)
    for _ in Walk(surfaces, wo, rng, light).exits():
        pass
    return light.f
