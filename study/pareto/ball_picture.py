# SPDX-License-Identifier: GPL-3.0-or-later
"""What people see: the truth's picture of a ball by numpy, the display transform, and CIEDE2000. Does not need bpy.

World frame: y up, z to the viewer, who is far away. Pictures have the top row first.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...reference_py.lobes.samples import view_of
from ...reference_py.optics.frame import reflect
from ...reference_py.optics.microfacet import GGX
from ...reference_py.optics.quadrature import balanced_directions, cosine_directions, points
from ..colorimetry import delta_e_2000, xyz_of_linear
from ..paper.lights import STUDIO, Environment
from .reflectance import Reflectance

# Radii of a ball on which the truth is computed, and azimuths at each.
_RINGS, _AZIMUTHS = 40, 72
_COUNT = 1000
# Pixels nearer to the edge see more of the pixel's other half than of the ball.
EDGE = 0.97
# What a white, matte ball shows at its brightest.
_WHITE_SHOWN = 0.8


@dataclass(frozen=True)
class Surroundings:
    """An environment as the picture (h, w) that Cycles and numpy both look up, linear between its pixels."""

    environment: Environment = STUDIO
    height: int = 256

    @cached_property
    def texels(self) -> np.ndarray:
        """Radiance (h, w), the bottom row first, longitudes as in Cycles' equirectangular projection about z."""
        h, w = self.height, 2 * self.height
        elevation = ((np.arange(h) + 0.5) / h - 0.5)[:, None] * np.pi
        phi = -((np.arange(w) + 0.5) / w - 0.5) * 2.0 * np.pi
        directions = np.stack(np.broadcast_arrays(np.cos(elevation) * np.cos(phi), np.cos(elevation) * np.sin(phi), np.sin(elevation)), axis=-1)
        return self.environment.radiance(directions)

    def radiance(self, w: np.ndarray) -> np.ndarray:
        """Radiance (...) from world directions (..., 3)."""
        height, width = self.texels.shape
        x = (0.5 - np.arctan2(w[..., 1], w[..., 0]) / (2.0 * np.pi)) * width - 0.5
        y = np.clip((np.arctan2(w[..., 2], np.hypot(w[..., 0], w[..., 1])) / np.pi + 0.5) * height - 0.5, 0.0, height - 1.0)
        i, j = np.floor(x).astype(int), np.minimum(y.astype(int), height - 2)
        s, t = x - i, y - j
        left, right = i % width, (i + 1) % width
        rows = [self.texels[k, left] * (1.0 - s) + self.texels[k, right] * s for k in (j, j + 1)]
        return rows[0] * (1.0 - t) + rows[1] * t

    @cached_property
    def exposure(self) -> float:
        """What radiance is multiplied by before it is displayed."""
        u1, u2 = points(4096)
        normals = ball_normals(16)
        normals = normals[np.isfinite(normals[..., 0])]
        local = cosine_directions(u1, u2)
        return float(_WHITE_SHOWN / np.max([np.mean(self.radiance(local @ _frame(n))) for n in normals]))


def ball_normals(size: int) -> np.ndarray:
    """Normals (size, size, 3) at the pixels' centres of a ball that fills the picture, nan beyond EDGE."""
    place = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    x, y = np.meshgrid(place, -place)
    r2 = x * x + y * y
    normals = np.stack([x, y, np.sqrt(np.maximum(1.0 - r2, 0.0))], axis=-1)
    normals[r2 > EDGE**2] = np.nan
    return normals


def _frame(normal: np.ndarray) -> np.ndarray:
    """Rows: the axes of the local frame of a normal, x towards the viewer."""
    side = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    length = np.linalg.norm(side)
    x = side / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return np.stack([x, np.cross(normal, x), normal])


def ball_picture(reflectance: Reflectance, widths: list[float], size: int, surroundings: Surroundings) -> np.ndarray:
    """Radiance (size, size, 3) of a ball, nan beyond EDGE; `widths` are the alphas of its lobes.

    The rough part comes from rings of equal view, linear in between; the mirror-like one from each pixel.
    """
    normals = ball_normals(size)
    inside = np.isfinite(normals[..., 0])
    n = normals[inside]
    picture = np.full((size, size, 3), np.nan)
    # rings are even in the angle, as the Fresnel curves turn at the edge
    angles = np.linspace(0.0, np.arcsin(EDGE), _RINGS)
    rings = np.array([_ring(reflectance, angle, widths, surroundings) for angle in angles])
    place = np.arccos(n[:, 2]) / angles[-1] * (_RINGS - 1)
    turn = np.arctan2(n[:, 1], n[:, 0]) / (2.0 * np.pi) * _AZIMUTHS % _AZIMUTHS
    i, j = np.minimum(place.astype(int), _RINGS - 2), turn.astype(int)
    s, t = (place - i)[:, None], (turn - j)[:, None]
    total = np.zeros_like(n)
    for di, wi in ((0, 1.0 - s), (1, s)):
        for dj, wj in ((0, 1.0 - t), (1, t)):
            total += wi * wj * rings[i + di, (j + dj) % _AZIMUTHS]
    mirrored = reflect(np.array([0.0, 0.0, 1.0]), n)
    picture[inside] = total + reflectance.specular_albedo(n[:, 2]) * surroundings.radiance(mirrored)[:, None]
    return picture


def _ring(reflectance, angle: float, widths: list[float], surroundings: Surroundings) -> np.ndarray:
    """Radiance (_AZIMUTHS, 3) of the rough part, by directions of light warped by each width and by the cosine."""
    wo = view_of(np.cos(angle))
    wi, measure = balanced_directions(wo, [(GGX, alpha) for alpha in widths], _COUNT)
    scattered = reflectance.f(np.broadcast_to(wo, wi.shape), wi) * measure[:, None]
    ring = np.empty((_AZIMUTHS, 3))
    for k, phi in enumerate(2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS):
        normal = np.array([np.sin(angle) * np.cos(phi), np.sin(angle) * np.sin(phi), np.cos(angle)])
        ring[k] = surroundings.radiance(wi @ _frame(normal)) @ scattered
    return ring


def shown(radiance: np.ndarray) -> np.ndarray:
    """What a display shows, linear sRGB (..., 3) in 0 to 1: Khronos PBR Neutral, as in this project's studio pictures."""
    start, desaturation = 0.76, 0.15
    low = np.min(radiance, axis=-1, keepdims=True)
    color = radiance - np.where(low < 0.08, low - 6.25 * low * low, 0.04)
    peak = np.maximum(np.max(color, axis=-1, keepdims=True), 1e-9)
    room = 1.0 - start
    new_peak = 1.0 - room * room / np.maximum(peak + room - start, 1e-9)
    grey = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0)
    compressed = color * (new_peak / peak) * (1.0 - grey) + new_peak * grey
    return np.clip(np.where(peak < start, color, compressed), 0.0, 1.0)


def encoded(linear: np.ndarray) -> np.ndarray:
    """8-bit sRGB of linear values in 0 to 1."""
    value = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)
    return (value.clip(0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)


def difference(picture: np.ndarray, truth: np.ndarray, surroundings: Surroundings) -> float:
    """Mean CIEDE2000 of two pictures of radiance as they are displayed, over the pixels of the ball."""
    inside = np.isfinite(truth[..., 0])
    first, second = (xyz_of_linear(shown(p[inside] * surroundings.exposure)) for p in (picture, truth))
    return float(np.mean(delta_e_2000(first, second)))
