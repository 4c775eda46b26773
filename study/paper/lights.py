# SPDX-License-Identifier: GPL-3.0-or-later
"""White light for spheres: a dome that is brighter above, and soft discs. World frame: y up, z to the viewer."""

from dataclasses import dataclass

import numpy as np

from ...reference_py.optics.frame import normalize

_UP = np.array([0.0, 1.0, 0.0])
# The outer part of a disc's radius over which its radiance falls to 0.
_SOFT_EDGE = 0.15


@dataclass(frozen=True)
class Disc:
    """A far, round light."""

    direction: tuple[float, float, float]
    radius_deg: float
    radiance: float

    @property
    def cos_radius(self) -> float:
        return float(np.cos(np.radians(self.radius_deg)))

    def radiance_from(self, w: np.ndarray) -> np.ndarray:
        """Radiance (...) of world directions (..., 3)."""
        angle = np.arccos(np.clip(w @ normalize(np.array(self.direction)), -1.0, 1.0)) / np.radians(self.radius_deg)
        t = np.clip((1.0 - angle) / _SOFT_EDGE, 0.0, 1.0)
        return self.radiance * t * t * (3.0 - 2.0 * t)

    def sample(self, u1: np.ndarray, u2: np.ndarray) -> np.ndarray:
        """World directions (n, 3) of even density over the disc."""
        axis = normalize(np.array(self.direction))
        side = normalize(np.cross(axis, _UP))
        cos = 1.0 - u1 * (1.0 - self.cos_radius)
        sin, phi = np.sqrt(1.0 - cos * cos), 2.0 * np.pi * u2
        across = np.cos(phi)[:, None] * side + np.sin(phi)[:, None] * np.cross(side, axis)
        return cos[:, None] * axis + sin[:, None] * across

    def density(self, w: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample` at world directions (..., 3)."""
        inside = w @ normalize(np.array(self.direction)) >= self.cos_radius
        return np.where(inside, 1.0 / (2.0 * np.pi * (1.0 - self.cos_radius)), 0.0)


@dataclass(frozen=True)
class Environment:
    """A dome of radiance `level + rise * height` and discs."""

    level: float
    rise: float
    discs: tuple[Disc, ...]

    def radiance(self, w: np.ndarray) -> np.ndarray:
        """Radiance (...) from world directions (..., 3)."""
        return self.level + self.rise * w[..., 1] + sum(disc.radiance_from(w) for disc in self.discs)


STUDIO = Environment(0.3, 0.22, (Disc((-0.55, 0.62, 0.56), 11.0, 14.0), Disc((0.9, 0.12, 0.42), 16.0, 1.6)))
