# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `closure_model`: a lobe set evaluated as Cycles evaluates its closures.

Equal to the render up to float32 rounding (`make test`, goniometer tests). It is not a model of the stack:
its distance from one is the lobe set's error. Limits: weights of lobes know the view alone, so f is not reciprocal;
energy is that of the method, which exceeds 1 where the method's own model does.

option | default | meaning
------ | ------- | -------
method | auto    | how Cycles is told about the stack: weidlich_wilkie, analytic, baked or auto (`lobes.methods`)

>>> model = make_model("closure_model", presets.load("glazed_mug"), method="analytic")
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.07, 0.131, 0.193]
"""

from dataclasses import replace

import numpy as np

from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...optics.directions import components, take, vectors
from ...optics.frame import DOWN, azimuth, color_axis, dot, half_vector, no_axis, per_direction, sampled
from ...optics.microfacet import anisotropic_distribution
from ...optics.optical_stack import supports
from ...optics.quadrature import cosine_directions, directional_albedo
from ...optics.sampling import projected_area, sample_visible_normals
from ..closure import fresnel, is_specular_lobe, lobe_f
from ..lobe import DiffuseLobe, GlossyLobe
from . import DEFAULT_METHOD, make_lobe_set

# Share of its weight that a lobe keeps where its Fresnel factor vanishes, as the factor rises around that view.
_LEAST_SHARE = 1e-3
_MEAN = np.full(3, 1.0 / 3.0)
# Directions drawn at once: so many stay in a processor's cache.
_AT_ONCE = 1 << 14


@supports("model", spectral=False, features=(ANISOTROPY, THIN_FILM, SCATTERING))
class ClosureModel:
    """What Cycles renders: the closures of a method, evaluated."""

    name = "closure_model"
    stochastic = False
    channels = 3

    def __init__(self, stack: Stack, method: str = DEFAULT_METHOD):
        self.lobe_set = make_lobe_set(stack, method)

    @per_direction(color_axis)
    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like lobes have none and count as 0."""
        visible = (wo[..., 2] > 0.0) & (wi[..., 2] > 0.0)
        lobes = self.lobe_set.lobes(np.where(visible, wo[..., 2], 1.0), azimuth(wo))
        total = sum(lobe_f(lobe, wo, wi) for lobe in lobes)
        return np.where(visible[..., None], total, 0.0)

    @per_direction(color_axis)
    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like lobes included."""
        return np.concatenate([self._albedo(wo[i : i + 1]) for i in range(len(wo))])

    def _albedo(self, wo: np.ndarray) -> np.ndarray:
        """That of one view (1, 3), whose lobes have widths of their own."""
        glossy = [lobe for lobe in self.lobe_set.lobes(wo[:, 2], azimuth(wo)) if isinstance(lobe, GlossyLobe)]
        widths = [(lobe.distribution, float(np.max(alpha))) for lobe in glossy for alpha in (lobe.alpha_x, lobe.alpha_y)]
        total = directional_albedo(self.f, wo, widths)
        return sum((lobe.weight * fresnel(lobe, wo[:, 2]) for lobe in glossy if is_specular_lobe(lobe)), total)

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo and whether it is above the horizon, (...).

        A lobe is picked by its energy at the view and sampled by its visible normals or cosine, as in Cycles.
        Mirror-like lobes are never picked; where there are no others, wi points straight down.
        """
        wi = vectors(*(np.full(len(wo), part) for part in DOWN))
        for start in range(0, len(wo), _AT_ONCE):
            self._draw(wo[start : start + _AT_ONCE], wi[start : start + _AT_ONCE], rng)
        return wi, (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)

    def _draw(self, wo: np.ndarray, wi: np.ndarray, rng: np.random.Generator) -> None:
        """Write one direction per wo into wi, both (n, 3), where a lobe is picked."""
        lobes, shares = self._finite_lobes(wo)
        picked, chosen = rng.random(len(wo)), np.zeros(len(wo), np.int8)
        bound = np.zeros(len(wo))
        for share in shares[:-1]:
            bound += share
            chosen += picked >= bound
        for i, lobe in enumerate(lobes):
            rows = np.flatnonzero(chosen == i)
            if len(rows):
                wi.T[:, rows] = _sample_lobe(_at(lobe, rows, len(wo)), take(wo, rows), rng)

    @per_direction(no_axis)
    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample` for wi on the whole sphere; 0 for viewers below the horizon."""
        lobes, shares = self._finite_lobes(wo)
        total = sum((shares[i] * _lobe_density(lobe, wo, wi) for i, lobe in enumerate(lobes)), np.zeros(len(wo)))
        return np.where(wo[:, 2] > 0.0, total, 0.0)

    def _finite_lobes(self, wo):
        """The lobes with a finite f and the probabilities (lobes, n) of picking them for wo (n, 3)."""
        cos_o = np.where(wo[:, 2] > 0.0, wo[:, 2], 1.0)
        lobes = [lobe for lobe in self.lobe_set.lobes(cos_o, azimuth(wo)) if not (isinstance(lobe, GlossyLobe) and is_specular_lobe(lobe))]
        shares = np.ones((len(lobes), len(wo)))
        for share, lobe in zip(shares, lobes):
            reflectance = _reflectance(lobe, cos_o)
            if reflectance.shape[-1] == 1:
                np.multiply(lobe.weight @ _MEAN, reflectance[..., 0], out=share)
            else:
                share[:] = (lobe.weight * reflectance) @ _MEAN
        total = np.sum(shares, axis=0)
        shares[:, total <= 0.0] = 1.0
        shares /= np.where(total > 0.0, total, len(lobes))
        return lobes, shares


def _reflectance(lobe, cos_o):
    """What a lobe of weight 1 reflects, about: (..., 1) where it is the same in all channels, or (..., 3)."""
    if isinstance(lobe, DiffuseLobe):
        return np.ones(1) if lobe.color is None else np.array(lobe.color)
    return np.maximum(fresnel(lobe, cos_o), _LEAST_SHARE)


def _at(lobe, rows: np.ndarray, count: int):
    """What `_sample_lobe` needs of a lobe at some of its `count` views."""
    if isinstance(lobe, DiffuseLobe):
        return lobe
    widths = {name: value.take(rows) if np.shape(value) == (count,) else value for name in ("alpha_x", "alpha_y", "tilt") for value in (getattr(lobe, name),)}
    return replace(lobe, **widths)


def _sample_lobe(lobe, wo, rng) -> np.ndarray:
    """The three columns (3, n) of wi of one lobe; below the surface where its facets send it there. Column by column, which is fastest."""
    if isinstance(lobe, DiffuseLobe):
        return cosine_directions(rng.random(len(wo)), rng.random(len(wo))).T
    x, y, z = components(wo)
    sin_o = np.hypot(x, y)
    if lobe.frame is None:
        safe, cos_t, sin_t = np.maximum(sin_o, 1e-12), np.cos(lobe.tilt), np.sin(lobe.tilt)
        has_plane = sin_o > 1e-12
        c, s = np.where(has_plane, x / safe, 1.0), np.where(has_plane, y / safe, 0.0)
        own = cos_t * sin_o - sin_t * z, np.zeros(len(wo)), cos_t * z + sin_t * sin_o
    else:
        c, s, cos_t, sin_t = np.cos(lobe.frame), np.sin(lobe.frame), 1.0, 0.0
        own = c * x + s * y, c * y - s * x, z
    # a surface of alphas (x, y) is one of alpha 1, compressed: so are its visible normals (Heitz14)
    across = lobe.alpha_x * own[0], lobe.alpha_y * own[1]
    length = 1.0 / np.sqrt(across[0] ** 2 + across[1] ** 2 + own[2] ** 2)
    stretched = vectors(across[0] * length, across[1] * length, own[2] * length)
    mx, my, mz = components(sample_visible_normals(stretched, 1.0, lobe.distribution, rng))
    mx, my = lobe.alpha_x * mx, lobe.alpha_y * my
    along = 2.0 * (own[0] * mx + own[1] * my + own[2] * mz) / (mx * mx + my * my + mz * mz)
    x, y, z = (along * m - w for m, w in zip((mx, my, mz), own))
    x, z = cos_t * x + sin_t * z, cos_t * z - sin_t * x
    return np.stack([c * x - s * y, s * x + c * y, z])


def _lobe_density(lobe, wo, wi) -> np.ndarray:
    """Density (n,) in 1/sr of `_sample_lobe`."""
    if isinstance(lobe, DiffuseLobe):
        return np.maximum(wi[:, 2], 0.0) / np.pi
    x, y, n = axes = _lobe_frame(wo, lobe)
    stretched, length = _stretched(lobe, wo, axes)
    wh = half_vector(wi, wo)
    d = anisotropic_distribution(lobe.distribution, lobe.alpha_x, lobe.alpha_y, dot(wh, x), dot(wh, y), dot(wh, n))
    return d / (4.0 * length * projected_area(stretched, 1.0, lobe.distribution))


def _stretched(lobe, wo, axes):
    """wo (n, 3) as seen by the lobe's surface stretched to alpha 1, and the length (n,) that this gave it."""
    x, y, n = axes
    w = vectors(lobe.alpha_x * dot(wo, x), lobe.alpha_y * dot(wo, y), dot(wo, n))
    length = np.linalg.norm(w, axis=-1)
    return w / length[:, None], length


def _lobe_frame(wo, lobe: GlossyLobe):
    """The lobe's axes (n, 3): along and across the plane of incidence, or its own frame, and its normal."""
    if lobe.frame is not None:
        c, s = np.cos(lobe.frame), np.sin(lobe.frame)
        return np.broadcast_to([c, s, 0.0], wo.shape), np.broadcast_to([-s, c, 0.0], wo.shape), np.broadcast_to([0.0, 0.0, 1.0], wo.shape)
    tilt = lobe.tilt
    sin_o = np.hypot(wo[..., 0], wo[..., 1])[..., None]
    along = np.where(sin_o > 1e-12, wo * np.array([1.0, 1.0, 0.0]) / np.maximum(sin_o, 1e-12), np.array([1.0, 0.0, 0.0]))
    up = np.array([0.0, 0.0, 1.0])
    cos_t, sin_t = np.cos(tilt)[..., None], np.sin(tilt)[..., None]
    x = cos_t * along - sin_t * up
    n = cos_t * up + sin_t * along
    return x, np.cross(n, x), n
