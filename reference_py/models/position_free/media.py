# SPDX-License-Identifier: GPL-3.0-or-later
"""Flights through a medium that scatters: a distance, and a direction by the Henyey-Greenstein phase function (Henyey41).

Depth is the one position that counts. Where channels differ in extinction, a flight's distance is that of one channel, which is drawn by how
likely the walk so far is in each (`Rays.share`): the balance heuristic over channels, so that no channel's weight grows (Wilkie14).
"""

from dataclasses import replace

import numpy as np

from ...errors import LaminaError
from ...optics.directions import components, vectors
from ...optics.frame import dot
from ...optics.interface import Interface
from ...optics.slab import henyey_greenstein
from .rays import Rays

# Events of a mean walk in a medium, above which walks are refused: the longest take hundreds of times as many.
MOST_EVENTS = 500
_ISOTROPIC = 1e-7


class ScatteringMedium:
    """The medium below an interface."""

    def __init__(self, layer: Interface, where: str):
        self.tau, self.albedo, self.g = layer.tau, layer.scattering.albedo, layer.scattering.g
        self.is_grey = bool(np.all(self.tau == self.tau[0]))
        self.absorbs = bool(np.any(self.albedo < 1.0))
        # uniform light crosses a slab in 2 tau mean free paths on average; the roulette ends the rest
        events = np.min([2.0 * self.tau, 3.0 / np.maximum(1.0 - self.albedo, 1e-9)], axis=0).max()
        if events > MOST_EVENTS:
            depth, albedo = self.tau.max(), self.albedo.max()
            raise LaminaError(
                f"model position_free: {where} has the optical depth {depth:.4g} and the albedo {albedo:.4g}, in which a walk scatters some"
                f" {events:.2g} times; choose adding, or a thinner layer"
            )

    def fly(self, rays: Rays, rng: np.random.Generator) -> tuple[Rays, np.ndarray]:
        """Rays, whose w is their travel here, at their next event, and whether each is (n,): -1 over the top, 1 below the bottom, 0 inside."""
        z, depth = rays.w[:, 2], rays.depth
        free = rng.standard_exponential(len(depth))
        if self.is_grey:
            new = depth - z * (free / self.tau[0])
            place = (new > 1.0).astype(np.int8) - (new < 0.0)
            throughput = rays.throughput
            if self.absorbs:
                throughput = (throughput.T * np.where(place == 0, self.albedo[:, None], 1.0)).T
            return replace(rays, throughput=throughput, depth=new), place
        chosen = np.sum(rng.random(len(depth)) >= np.cumsum(rays.share.T[:-1], axis=0), axis=0)
        length = free / np.maximum(self.tau[chosen], 1e-12)
        with np.errstate(divide="ignore"):
            edge = np.where(z > 0.0, depth, depth - 1.0) / np.where(z == 0.0, 1e-300, z)
        stays = length < edge
        place = np.where(stays, 0, np.where(z > 0.0, -1, 1))
        length = np.minimum(length, edge)
        # what each channel lets come so far, all relative to the chosen one's
        passed = np.exp(np.clip((self.tau[chosen] - self.tau[:, None]) * length, -700.0, 700.0)) * np.where(stays, self.tau[:, None], 1.0)
        share = rays.share.T * passed
        mean = np.sum(share, axis=0)
        throughput = rays.throughput.T * (passed * np.where(stays, self.albedo[:, None], 1.0) / mean)
        return replace(rays, throughput=throughput.T, share=(share / mean).T, depth=depth - z * length), place

    def turn(self, w: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """New directions of travel (n, 3), and the cosines (n,) by which they turned."""
        g, u = self.g, rng.random(len(w))
        phi = 2.0 * np.pi * rng.random(len(w))
        if abs(g) < _ISOTROPIC:
            z = 2.0 * u - 1.0
            radius = np.sqrt(1.0 - z * z)
            out = vectors(radius * np.cos(phi), radius * np.sin(phi), z)
            return out, z  # any cosine is as likely
        cos = np.clip((1.0 + g * g - np.square((1.0 - g * g) / (1.0 - g + 2.0 * g * u))) / (2.0 * g), -1.0, 1.0)
        radius = np.sqrt(1.0 - cos * cos)
        a, b = radius * np.cos(phi), radius * np.sin(phi)
        x, y, z = components(w)
        # the basis of Duff17
        sign = np.copysign(1.0, z)
        c = -1.0 / (sign + z)
        d = x * y * c
        return vectors(a * (1.0 + sign * x * x * c) + b * d + cos * x, a * sign * d + b * (sign + y * y * c) + cos * y, -a * sign * x - b * y + cos * z), cos

    def phase(self, cos: np.ndarray) -> np.ndarray:
        """Density (n,) in 1/sr of turning by these cosines."""
        return henyey_greenstein(cos, self.g)

    def toward(self, w: np.ndarray, target: np.ndarray) -> np.ndarray:
        """Density (n,) in 1/sr of turning from travel w to the target, both (n, 3)."""
        return self.phase(dot(w, target))

    def passed(self, depth: np.ndarray, cos_theta: np.ndarray) -> np.ndarray:
        """(n, 3) what straight light lets come from the top to these depths."""
        return np.exp(-self.tau[:, None] * (depth / np.maximum(cos_theta, 1e-12))).T
