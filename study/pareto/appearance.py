# SPDX-License-Identifier: GPL-3.0-or-later
"""What people see: the truth's picture of a ball by numpy, the display transform, and CIEDE2000. Does not need bpy.

World frame: y up, z to the viewer, who is far away. Pictures have the top row first.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...reference_py.lobes.samples import view_of
from ...reference_py.optics.frame import dot, half_vector, reflect
from ...reference_py.optics.microfacet import GGX, distribution
from ...reference_py.optics.quadrature import cosine_directions, facet_normals, points
from ..paper.environment import STUDIO, Environment
from .reflectance import Reflectance

# Radii of a ball on which the truth is computed, and azimuths at each.
_RINGS, _AZIMUTHS = 40, 72
_COUNT = 1000
# Pixels nearer to the edge see more of the pixel's other half than of the ball.
EDGE = 0.97
# XYZ of linear sRGB (IEC 61966-2-1), and of its white.
_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
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
    picture[inside] = total + reflectance.mirror(n[:, 2]) * surroundings.radiance(mirrored)[:, None]
    return picture


def _ring(reflectance, angle: float, widths: list[float], surroundings: Surroundings) -> np.ndarray:
    """Radiance (_AZIMUTHS, 3) of the rough part, by directions of light warped by each width and by the cosine."""
    wo = view_of(np.cos(angle))
    u1, u2 = points(_COUNT)
    wi = np.concatenate([cosine_directions(u1, u2)] + [reflect(wo, facet_normals(u1, u2, a, GGX)) for a in widths])
    wi = wi[wi[:, 2] > 0.0]
    wh = half_vector(wi, wo)
    jacobian = wh[:, 2] / np.maximum(4.0 * dot(wi, wh), 1e-300)
    density = wi[:, 2] / np.pi + sum(distribution(wh[:, 2], a, GGX) * jacobian for a in widths)
    scattered = reflectance.f(np.broadcast_to(wo, wi.shape), wi) * (wi[:, 2] / (_COUNT * density))[:, None]
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


def lab(linear: np.ndarray) -> np.ndarray:
    """CIE 1976 L*a*b* (..., 3) of linear sRGB (..., 3), its white the reference."""
    t = linear @ _XYZ.T / _XYZ.sum(axis=1)
    root = np.where(t > (6.0 / 29.0) ** 3, np.cbrt(t), t * (29.0 / 6.0) ** 2 / 3.0 + 4.0 / 29.0)
    x, y, z = np.moveaxis(root, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def delta_e_2000(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """CIEDE2000 (...) of two L*a*b* (..., 3) (Sharma, Wu and Dalal 2005, eqs. 2 to 22)."""
    l1, a1, b1 = np.moveaxis(first, -1, 0)
    l2, a2, b2 = np.moveaxis(second, -1, 0)
    c7 = (0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))) ** 7
    stretch = 1.5 - 0.5 * np.sqrt(c7 / (c7 + 25.0**7))
    a1, a2 = a1 * stretch, a2 * stretch
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360.0, np.degrees(np.arctan2(b2, a2)) % 360.0
    grey = c1 * c2 == 0.0
    turn = np.where(grey, 0.0, (h2 - h1 + 180.0) % 360.0 - 180.0)
    dh = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(0.5 * turn))
    mean_l, mean_c = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    far = np.abs(h1 - h2) > 180.0
    mean_h = np.where(grey, h1 + h2, 0.5 * (h1 + h2) + np.where(far, np.where(h1 + h2 < 360.0, 180.0, -180.0), 0.0))

    def cos(degrees):
        return np.cos(np.radians(degrees))

    t = 1.0 - 0.17 * cos(mean_h - 30.0) + 0.24 * cos(2.0 * mean_h) + 0.32 * cos(3.0 * mean_h + 6.0) - 0.2 * cos(4.0 * mean_h - 63.0)
    away = (mean_l - 50.0) ** 2
    s_l = 1.0 + 0.015 * away / np.sqrt(20.0 + away)
    s_c, s_h = 1.0 + 0.045 * mean_c, 1.0 + 0.015 * mean_c * t
    c7 = mean_c**7
    rotation = -2.0 * np.sqrt(c7 / (c7 + 25.0**7)) * np.sin(np.radians(60.0 * np.exp(-(((mean_h - 275.0) / 25.0) ** 2))))
    dl, dc, dh = (l2 - l1) / s_l, (c2 - c1) / s_c, dh / s_h
    return np.sqrt(np.maximum(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0))


def difference(picture: np.ndarray, truth: np.ndarray, surroundings: Surroundings) -> float:
    """Mean CIEDE2000 of two pictures of radiance as they are displayed, over the pixels of the ball."""
    inside = np.isfinite(truth[..., 0])
    first, second = (lab(shown(p[inside] * surroundings.exposure)) for p in (picture, truth))
    return float(np.mean(delta_e_2000(first, second)))
