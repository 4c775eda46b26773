# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles makes of one lobe: its f, and its energy.

The lobe's frame: x along the plane of incidence, z the lobe's normal, which is N turned by `tilt` towards the viewer.
A lobe with a `frame` has x in the surface instead, that angle from the tangent, and no tilt.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from ..optics.diffuse import oren_nayar, oren_nayar_albedo
from ..optics.fresnel import fresnel_conductor, fresnel_dielectric
from ..optics.gauss import gauss_legendre
from ..optics.ggx import turn_of
from ..optics.microfacet import GGX, anisotropic_distribution, distribution_of, is_specular, smith_lambda_stretched
from ..optics.quadrature import GOLDEN
from ..optics.thin_film import film_reflectance
from .diffuse_ramp import ramp_f
from .lobe import ConductorCurve, DielectricCurve, DiffuseLobe, FilmCurve, GlossyLobe, SchlickCurve

# Cycles drops a closure whose mean weight is below this.
WEIGHT_CUTOFF = 1e-5
# Directions per view, as rings about the lobe's axis and places on each: for an energy, and for a ratio of energies.
ENERGY_RULE, _SHARE_RULE = (192, 32), (64, 16)
# Directions at once: with fewer most of the time goes into beginning numpy's steps, more would not fit into a processor's cache.
_IN_CACHE = 24576


def lobe_f(lobe: GlossyLobe | DiffuseLobe, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """f (..., 3) of one lobe for directions above the surface, as Cycles' closure gives it; 0 for a mirror-like one."""
    # a closure that has a color counts it as its weight
    weighted = lobe.weight if isinstance(lobe, GlossyLobe) or lobe.color is None else lobe.weight * np.asarray(lobe.color)
    weight = np.where(np.mean(weighted, axis=-1, keepdims=True) < WEIGHT_CUTOFF, 0.0, lobe.weight)
    if isinstance(lobe, DiffuseLobe):
        if lobe.ramp is not None:
            return weight * ramp_f(lobe.ramp, wi[..., 2])
        if lobe.color is None:
            return weight / np.pi * np.ones(wi.shape)
        return weight * oren_nayar(wi, wo, np.array(lobe.color), lobe.sigma_deg, lobe.power)
    if is_specular_lobe(lobe):
        return np.zeros(wi.shape)
    sharp = is_specular(np.sqrt(lobe.alpha_x * lobe.alpha_y))  # at some views only: a mirror there
    alpha_x, alpha_y = np.where(sharp, 1.0, lobe.alpha_x), np.where(sharp, 1.0, lobe.alpha_y)
    value, cos_ih = unit_glossy(lobe.distribution, alpha_x, alpha_y, lobe.tilt, wo, wi, lobe.frame)
    return weight * np.where(sharp, 0.0, value)[..., None] * fresnel(lobe, cos_ih)


def is_specular_lobe(lobe: GlossyLobe) -> bool:
    """Whether a lobe is a mirror at all its views, so that it has no finite f."""
    return is_specular(np.max(np.sqrt(lobe.alpha_x * lobe.alpha_y)))


def fresnel(lobe: GlossyLobe, cos_h: np.ndarray) -> np.ndarray:
    """The lobe's Fresnel curve, (..., 1) or (..., 3), or of as many channels as a metal has, at the cosine of wi and the half vector."""
    if isinstance(lobe.fresnel, DielectricCurve):
        return fresnel_dielectric(cos_h, lobe.fresnel.eta)[..., None]
    if isinstance(lobe.fresnel, ConductorCurve):
        return fresnel_conductor(cos_h[..., None], np.array(lobe.fresnel.eta), np.array(lobe.fresnel.k))
    if isinstance(lobe.fresnel, SchlickCurve):
        rise = np.power(np.clip(1.0 - cos_h, 0.0, 1.0), 5)[..., None]
        return lobe.fresnel.f0 + (lobe.fresnel.f90 - lobe.fresnel.f0) * rise
    if isinstance(lobe.fresnel, FilmCurve):
        return film_reflectance(cos_h, 1.0, lobe.fresnel.film, lobe.fresnel.eta)
    return np.ones(np.shape(cos_h) + (1,))


def unit_glossy(distribution: str, alpha_x, alpha_y, tilt, wo: np.ndarray, wi: np.ndarray, frame: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """f (...) of a glossy lobe of weight 1 without its Fresnel curve, and cos(wi, half vector)."""
    (ix, iy, iz), (ox, oy, oz) = _in_lobe_frame(tilt, wo, wi) if frame is None else (_rotated(wi, frame), _rotated(wo, frame))
    hx, hy, hz = ix + ox, iy + oy, iz + oz
    length = np.sqrt(hx * hx + hy * hy + hz * hz)
    # both on the horizon, opposite: the half vector is the normal (`frame.half_vector`)
    safe, level = np.where(length > 1e-12, length, 1.0), length <= 1e-12
    d = anisotropic_distribution(distribution, alpha_x, alpha_y, hx / safe, hy / safe, np.where(level, 1.0, hz / safe))
    lambda_i = _lambda(np.square(alpha_x * ix) + np.square(alpha_y * iy), iz, distribution)
    lambda_o = _lambda(np.square(alpha_x * ox) + np.square(alpha_y * oy), oz, distribution)
    # Cycles returns f times the cosine to the lobe's own normal; f refers to the surface's
    value = d / (4.0 * np.maximum(oz, 1e-20) * (1.0 + lambda_o + lambda_i) * np.maximum(wi[..., 2], 1e-20))
    return np.where((oz > 0.0) & (iz > 0.0), value, 0.0), 0.5 * length


def _in_lobe_frame(tilt, wo, wi):
    """Components of wi and of wo, whose y is 0."""
    sin_o = np.hypot(wo[..., 0], wo[..., 1])
    safe = np.maximum(sin_o, 1e-12)
    along = sin_o > 1e-12
    ax, ay = np.where(along, wo[..., 0] / safe, 1.0), np.where(along, wo[..., 1] / safe, 0.0)
    cos_t, sin_t = np.cos(tilt), np.sin(tilt)
    x, y = wi[..., 0] * ax + wi[..., 1] * ay, wi[..., 1] * ax - wi[..., 0] * ay
    z, cos_o = wi[..., 2], wo[..., 2]
    return (cos_t * x - sin_t * z, y, cos_t * z + sin_t * x), (cos_t * sin_o - sin_t * cos_o, 0.0, cos_t * cos_o + sin_t * sin_o)


def _rotated(w, angle: float):
    """Components of w in a frame whose x is `angle` from the tangent."""
    c, s = np.cos(angle), np.sin(angle)
    return c * w[..., 0] + s * w[..., 1], c * w[..., 1] - s * w[..., 0], w[..., 2]


def _lambda(stretched2, cos, distribution):
    """Smith's Lambda where `stretched2` is (alpha_x x)^2 + (alpha_y y)^2."""
    return smith_lambda_stretched(stretched2 / np.maximum(np.square(cos), 1e-30), distribution)


def unit_energy(lobe: GlossyLobe, cos_theta_o: np.ndarray, phi: float = 0.0, rule: tuple[int, int] = ENERGY_RULE) -> np.ndarray:
    """Directional albedo (n, 3), or of as many channels as a metal has, that a glossy lobe has with weight 1, for views (n,) at the azimuth phi from the tangent.

    `rule` is how many rings of directions, and how many on each.

    GGX visible normals of the lobe's own widths carry both distributions. Errors are below 3e-4; those of a tilted lobe, whose horizon
    cuts through it, below 3e-3, median 1e-4 (tests/reference_py/test_closure.py).
    """
    cos_o = np.asarray(cos_theta_o, float)
    if is_specular_lobe(lobe):
        return fresnel(lobe, cos_o) * np.ones(3)
    points, weights = _rings(*rule)
    energy, cos_ih = _throughput(lobe, _shapes(lobe, cos_o), _views(lobe, cos_o, phi), points)
    if cos_ih is None:
        return (energy @ weights)[:, None] / np.sum(weights) * np.ones(3)
    reflected = ((energy * weights)[:, None] @ fresnel(lobe, cos_ih))[:, 0] / np.sum(weights)
    return reflected * np.ones(3) if reflected.shape[-1] == 1 else reflected


def fresnel_share(lobe: GlossyLobe, cos_theta_o: np.ndarray, phi: float = 0.0) -> np.ndarray:
    """Energy (n, 3) of a glossy lobe over that of the lobe without its Fresnel curve, for views (n,) at the azimuth phi.

    A Schlick curve may be another one at each view, (n, 3). A mirror has what its curve has at the view. The error is below 3e-4,
    median 1e-5; 7e-4 and 3e-5 for a lobe with a frame, 3e-3 and 2e-4 for a curve with total reflection (tests/reference_py/test_closure.py).
    """
    cos_o, curve = np.asarray(cos_theta_o, float), lobe.fresnel
    if isinstance(curve, SchlickCurve):  # the same for all directions of a view
        curve = SchlickCurve(*(np.broadcast_to(value, cos_o.shape + (3,))[:, None] for value in (curve.f0, curve.f90)))
        lobe = replace(lobe, fresnel=curve)
    at_view = fresnel(lobe, cos_o[:, None])[:, 0] * np.ones(3)
    if is_specular_lobe(lobe):
        return at_view
    alpha_x, alpha_y, tilt = _shapes(lobe, cos_o)
    specular = is_specular(np.sqrt(alpha_x * alpha_y))
    points, weights = _rings(*_SHARE_RULE)
    alphas = np.where(specular, 1.0, alpha_x), np.where(specular, 1.0, alpha_y)
    energy, cos_ih = _throughput(lobe, np.stack([*alphas, tilt]), _views(lobe, cos_o, phi), points)
    if cos_ih is None:
        return at_view
    energy *= weights
    share = (energy[:, None] @ fresnel(lobe, cos_ih))[:, 0] / np.sum(energy, axis=1)[:, None]
    return np.where(specular[:, None], at_view, share)


@cache
def _rings(rings: int, places: int) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Points of the unit square, places by rings: the first coordinate (rings,), the second (places, rings) as `turn_of` has it, and their weights
    (places * rings,), not to be written to: Gauss' rule of rings.

    Each is turned from the one before, so that few of them meet a horizon alike.
    """
    nodes, weights = gauss_legendre(rings)
    turns = (np.arange(rings) * GOLDEN + np.arange(places)[:, None] + 0.5) / places
    return (0.5 - 0.5 * nodes, *turn_of(turns % 1.0)), np.tile(weights, places)


def _shapes(lobe: GlossyLobe, cos_o: np.ndarray) -> np.ndarray:
    """alpha_x, alpha_y and tilt (3, n) at the views."""
    return np.array([np.broadcast_to(np.asarray(v, float), cos_o.shape) for v in (lobe.alpha_x, lobe.alpha_y, lobe.tilt)])


def _views(lobe: GlossyLobe, cos_o: np.ndarray, phi) -> np.ndarray:
    """Views (n, 3) about the lobe's own axis; where it has none, in the plane of incidence."""
    turn = 0.0 if lobe.frame is None else phi - lobe.frame
    sin_o = np.sqrt(np.maximum(1.0 - cos_o**2, 0.0))
    return np.stack([sin_o * np.cos(turn), sin_o * np.sin(turn), cos_o], axis=-1)


def _throughput(lobe: GlossyLobe, shapes: np.ndarray, wo: np.ndarray, points: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray | None]:
    """What light carries of a lobe's energy that GGX visible normals for the points of `_rings` mirror to views (n, 3), and, if the lobe has a curve,
    its cosine to these normals, both (n, points). The lobe has weight 1 and no curve; `shapes` (3, n) are as `_shapes` has them."""
    size = points[1].size
    energy, cos_ih = np.empty((len(wo), size)), np.empty((len(wo), size)) if lobe.fresnel else None
    at_once = max(1, _IN_CACHE // size)
    for i in range(0, len(wo), at_once):
        part = slice(i, i + at_once)
        energy[part], cosines = _throughput_at_once(lobe, *shapes[:, part], wo[part], points)
        if cos_ih is not None:
            cos_ih[part] = cosines
    return energy, cos_ih


def _throughput_at_once(lobe: GlossyLobe, alpha_x, alpha_y, tilt, wo: np.ndarray, points: tuple[np.ndarray, ...]):
    law = distribution_of(lobe.distribution)
    u1, cos_turn, sin_turn = points
    alpha_x, alpha_y, tilt, ox, oy, oz = (column[:, None, None] for column in (alpha_x, alpha_y, tilt, *wo.T))
    cos_t, sin_t = np.cos(tilt), np.sin(tilt)
    ox, oz = cos_t * ox - sin_t * oz, cos_t * oz + sin_t * ox
    # normals as `ggx_visible_columns` has them, but of any length: of z a ring has one
    along, aside = alpha_x * ox, alpha_y * oy
    stretched_o = along * along + aside * aside
    scale = 1.0 / np.sqrt(stretched_o + oz * oz)
    hz = (1.0 - u1) * (1.0 + oz * scale)
    cap_z = hz - oz * scale
    sin = np.sqrt(np.maximum(1.0 - cap_z * cap_z, 0.0))
    hx, hy = sin * cos_turn, sin * sin_turn
    hx += along * scale
    hy += aside * scale
    ratio = None if lobe.distribution == GGX else _slope_ratio(law, hx, hy, hz)
    hx *= alpha_x
    hy *= alpha_y
    length2 = hx * hx
    length2 += hy * hy
    length2 += hz * hz
    turned = ox * hx
    turned += oy * hy
    turned += oz * hz
    cosines = turned / np.sqrt(length2) if lobe.fresnel else None
    turned /= length2
    turned *= 2.0
    hx *= turned
    hx -= ox
    hy *= turned
    hy -= oy
    iz = np.multiply(turned, hz, out=turned)
    iz -= oz
    seen = (oz > 0.0) & (iz > 0.0) & (cos_t * iz > sin_t * hx)
    hx *= alpha_x
    hx *= hx
    hy *= alpha_y
    hy *= hy
    hx += hy
    iz *= iz
    hx /= np.maximum(iz, 1e-30, out=iz)
    lost = law.smith_lambda(hx)
    stretched_o = stretched_o / np.maximum(oz * oz, 1e-30)
    lost += 1.0 + law.smith_lambda(stretched_o)
    throughput = np.divide(1.0 + distribution_of(GGX).smith_lambda(stretched_o), lost, out=lost)
    if ratio is not None:
        throughput *= ratio
    throughput[~seen] = 0.0
    return (values if values is None else values.reshape(len(wo), -1) for values in (throughput, cosines))


def _slope_ratio(law, x, y, z):
    """Density of a distribution's slopes over GGX's at normals of x and y in units of their alpha."""
    slope2 = x * x
    slope2 += y * y
    slope2 /= z * z
    return law.slope_density(slope2) / distribution_of(GGX).slope_density(slope2)


def lobe_energy(lobe: GlossyLobe | DiffuseLobe, cos_theta_o: np.ndarray, phi: float = 0.0) -> np.ndarray:
    """Directional albedo (n, 3) of a lobe with its weight, for views (n,) at the azimuth phi."""
    if isinstance(lobe, GlossyLobe):
        return lobe.weight * unit_energy(lobe, cos_theta_o, phi)
    if lobe.color is None:
        return lobe.weight * np.ones(3)
    return lobe.weight * oren_nayar_albedo(cos_theta_o, lobe.color, lobe.sigma_deg, lobe.power)
