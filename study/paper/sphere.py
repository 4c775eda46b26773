# SPDX-License-Identifier: GPL-3.0-or-later
"""A sphere under an environment, seen from far away: direct light through a model's f, without noise.

The light of a pixel is integrated by multiple importance sampling (Veach95) with the same evenly spread points in
every pixel: one strategy per disc, per width of lobe and for the cosine. Mirror-like components look up the mirror
direction. Any model with `f`, `lobes`, `channels` and `specular_albedo` will do.
"""

from dataclasses import dataclass

import numpy as np

from ...reference_py.models.weidlich_wilkie_sampling import component_density
from ...reference_py.optics.frame import normalize, reflect
from ...reference_py.optics.microfacet import is_specular
from ...reference_py.optics.quadrature import cosine_directions, facet_normals, points
from .lights import STUDIO, Environment

# Directions that are in memory at a time: few enough for the processor's cache.
_CHUNK = 60_000
_VIEWER = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Picture:
    """Square picture of a sphere that fills it."""

    radiance: np.ndarray
    """(size, size, channels), 0 beside the sphere."""
    theta_deg: np.ndarray
    """(size, size) view angle at the centre of the pixel; nan beside the sphere."""

    @property
    def on_sphere(self) -> np.ndarray:
        return np.isfinite(self.theta_deg)


def render(model, size: int, environment: Environment = STUDIO, count: int = 48) -> Picture:
    """The sphere of a model, `size` pixels across, with `count` points per strategy."""
    x, y = np.meshgrid(*2 * [(np.arange(size) + 0.5) / size * 2.0 - 1.0])
    r2 = x * x + y * y
    inside = r2 < 1.0
    normals = np.stack([x, -y, np.sqrt(np.maximum(1.0 - r2, 0.0))], axis=-1)[inside]
    light = radiance(model, normals, environment, count)
    picture = np.zeros((size, size, light.shape[-1]))
    picture[inside] = light
    theta = np.full((size, size), np.nan)
    theta[inside] = np.degrees(np.arccos(normals[:, 2]))
    return Picture(picture, theta)


def radiance(model, normals: np.ndarray, environment: Environment = STUDIO, count: int = 48) -> np.ndarray:
    """Radiance (m, channels) towards the viewer of surfaces with unit normals (m, 3) in the world."""
    lobes = sorted({lobe for lobe in model.lobes if lobe and not is_specular(lobe[0])})
    rows = max(1, _CHUNK // (count * (1 + len(lobes) + len(environment.discs))))
    parts = [_radiance(model, normals[i : i + rows], environment, lobes, count) for i in range(0, len(normals), rows)]
    return np.concatenate(parts)


def _radiance(model, normals, environment, lobes, count) -> np.ndarray:
    frame = _frames(normals)
    wo = frame @ _VIEWER
    u1, u2 = points(count)
    world = np.concatenate([disc.sample(u1, u2) for disc in environment.discs])
    samples = [np.broadcast_to(cosine_directions(u1, u2), (len(wo), count, 3)), world @ np.swapaxes(frame, 1, 2)]
    samples += [reflect(np.broadcast_to(wo[:, None], (len(wo), count, 3)), facet_normals(u1, u2, *lobe)) for lobe in lobes]
    wi = np.concatenate(samples, axis=1)
    view = np.broadcast_to(wo[:, None], wi.shape)
    wi_world = wi @ frame
    density = component_density(None, view, wi) + sum(disc.density(wi_world) for disc in environment.discs)
    density = density + sum((component_density(lobe, view, wi) for lobe in lobes), 0.0)
    weight = environment.radiance(wi_world) * np.maximum(wi[..., 2], 0.0) / np.maximum(density, 1e-30) / count
    lit = weight > 0.0
    values = np.zeros(lit.shape + (model.channels,))
    values[lit] = model.f(view[lit], wi[lit]) * weight[lit][:, None]
    mirrored = np.squeeze((wo * np.array([-1.0, -1.0, 1.0]))[:, None] @ frame, axis=1)
    return np.sum(values, axis=1) + model.specular_albedo(wo) * environment.radiance(mirrored)[:, None]


def _frames(normals: np.ndarray) -> np.ndarray:
    """(m, 3, 3): rows are tangent, bitangent and normal in the world."""
    # Any tangent: every surface here is isotropic. The sphere's centre never has a normal along y.
    tangent = normalize(np.cross(np.array([0.0, 1.0, 0.0]), normals))
    tangent = np.where(np.any(tangent != 0.0, axis=-1, keepdims=True), tangent, np.array([1.0, 0.0, 0.0]))
    return np.stack([tangent, np.cross(normals, tangent), normals], axis=1)
