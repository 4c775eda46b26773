# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions of Weidlich07's components: sections 3.2 (recursion) and 4 (densities) as printed.

A component is picked by a constant weight, equal ones here; its facet normal, or the cosine of a diffuse base, is
sampled; the direction refracts back up and is culled if it cannot leave. Facet normals have the density
D(wh) cos(wh), which does not depend on the view, as section 4.1 has it.

Known flaw, kept as printed: eq. 8 adds densities of directions inside the stack as if they were densities outside,
so `pdf` is neither that of the samples nor integrates to what survives culling. `weidlich_wilkie_repaired` has
the Jacobian. Components without finite f (mirrors) have no weight.
"""

from itertools import islice

import numpy as np

from ..optics import microfacet
from ..optics.frame import DOWN, dot, half_vector, normalize, reflect
from ..optics.microfacet import is_specular
from ..optics.quadrature import cosine_directions, facet_normals


def sample(model, wo: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """wi (n, 3) and valid (n,) of a `WeidlichWilkie` for rows wo; culled wi point straight down."""
    pick, u1, u2 = rng.random((3, len(wo)))
    wi, valid = np.zeros(wo.shape), np.zeros(len(wo), bool)
    finite = finite_components(model)
    chosen = (pick * len(finite)).astype(int)
    for place, k in enumerate(finite):
        rows = np.flatnonzero(chosen == place)
        wi[rows], valid[rows] = _sample_component(model, k, wo[rows], u1[rows], u2[rows])
    wi[~valid] = DOWN
    return wi, valid


def pdf(model, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """Weidlich07, eq. 8, (...) in 1/sr, for directions (..., 3); 0 below the horizon."""
    finite = finite_components(model)
    total = 0.0
    for k, level in enumerate(model.levels(wo, wi)):
        if k in finite:
            density = component_density(model.lobes[k], level.wo, level.wi)
            total = total + np.where(level.reaches, density, 0.0) / len(finite)
    return np.broadcast_to(total, level.reaches.shape)


def finite_components(model) -> list[int]:
    """Indices of the components with a finite f."""
    return [k for k, lobe in enumerate(model.lobes) if lobe is None or not is_specular(lobe[0])]


def _sample_component(model, k: int, wo, u1, u2) -> tuple[np.ndarray, np.ndarray]:
    lobe, n = model.lobes[k], index_above(model, k)
    if model.options["refraction"] == "macro_normal":
        wi, valid = leave(sample_component(lobe, enter(wo, n), u1, u2), n)
    else:
        # every interface shares the half vector of the outer directions, and w_o / n + w_i' lies along it
        wh = facet_normals(u1, u2, *lobe) if lobe else normalize(wo / n + cosine_directions(u1, u2))
        wi, valid = reflect(wo, wh), dot(wo, wh) > 0.0
    level = next(islice(model.levels(wo, wi), k, None))
    return wi, valid & level.reaches


def index_above(model, k: int) -> float:
    """Absolute index of the medium above component k."""
    return model.interfaces[k - 1].n_below if k else 1.0


def enter(w: np.ndarray, n: float) -> np.ndarray:
    """w (..., 3), refracted from vacuum about the surface normal into a medium of index n >= 1."""
    tangent = w[..., :2] / n
    cos = np.sqrt(np.maximum(1.0 - np.sum(np.square(tangent), axis=-1, keepdims=True), 0.0))
    return np.concatenate([tangent, cos], axis=-1)


def leave(w: np.ndarray, n: float) -> tuple[np.ndarray, np.ndarray]:
    """The inverse of `enter`, and where it exists: total reflection and directions below the horizon stay inside."""
    tangent = w[..., :2] * n
    cos2 = 1.0 - np.sum(np.square(tangent), axis=-1, keepdims=True)
    leaves = (w[..., 2] > 0.0) & (cos2[..., 0] > 0.0)
    return np.concatenate([tangent, np.sqrt(np.maximum(cos2, 0.0))], axis=-1), leaves


def sample_component(lobe: tuple[float, str] | None, wo: np.ndarray, u1: np.ndarray, u2: np.ndarray) -> np.ndarray:
    """wi (n, 3) of one component alone, in its own medium; below the horizon where a facet sends it there."""
    return reflect(wo, facet_normals(u1, u2, *lobe)) if lobe else cosine_directions(u1, u2)


def component_density(lobe: tuple[float, str] | None, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """Density (...) in 1/sr of `sample_component`, on the whole sphere; not for mirrors."""
    if lobe is None:
        return np.maximum(wi[..., 2], 0.0) / np.pi
    wh = half_vector(wi, wo)
    cos = np.abs(wh[..., 2])  # a normal that faces away from wo reflects downwards, where wh is its negative
    spread = microfacet.distribution(cos, *lobe) * cos
    return spread / np.maximum(4.0 * np.abs(dot(wo, wh)), 1e-30)
