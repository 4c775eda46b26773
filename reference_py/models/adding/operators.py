# SPDX-License-Identifier: GPL-3.0-or-later
"""Interfaces, media and bases as matrices on the direction grid.

A row belongs to the direction in which a walker arrives (from the viewer), a column to the one in which it leaves:
(K g)(i) = sum_j K[i, j] g(j) for a radiance g / n^2. So rows sum to directional energies, and by reciprocity
K[i, j] / weights[j] is symmetric between the two sides. Azimuth is that of travel: a mirror turns by 0.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...optics import microfacet
from ...optics.diffuse import oren_nayar, oren_nayar_shares
from ...optics.facet_reflectance import ConductorFacet, DielectricFacet
from ...optics.frame import spherical
from ...optics.fresnel import cos_theta_t
from ...optics.gauss import gauss_legendre
from ...optics.microfacet import is_specular
from ...optics.slab import slab
from .assembly import Layers, ScatteringMedium
from .bounces import NARROW_ALPHA, Microsurface, detail_of
from .direction_grid import Grid, chebyshev_moments, legendre
from .facets import MULTIPLE, dielectric_reflected, dielectric_refracted, seen_by_both, visible_facets

# Azimuths of the quadrature of an Oren-Nayar base over the half circle.
_OREN_NAYAR_AZIMUTHS = 128
# A reflected lobe of alpha * nodes above this is resolved by the grid; it is integrated over so many azimuths + 2 modes, and 2 more for
# up to so many of the modes that are left out.
RESOLVED, _LOBE_AZIMUTHS, _MORE = 2.0, 24, 8
# Below this alpha multiple scattering has no part in f, nor, in a draft, in what the grid holds of f.
_SPIKE, _DRAFT_SPIKE = 0.01, 0.05
# Directions and pairs of them handled at once, which bounds memory.
_CHUNK, _PAIRS = 64, 128


@dataclass(frozen=True)
class Resolution:
    """Azimuthal modes, and facets across and along the plane of incidence per direction; a draft is content with less."""

    modes: int
    across: int
    along: int
    is_draft: bool = False
    left_out: int = 0
    """Modes after these that quadratures are good for, and that nobody sees (`depth`)."""

    @property
    def dtype(self) -> type:
        """Precision of the sums over facets, and of those over modes."""
        return np.float32 if self.is_draft else np.float64


# Facets per direction: energies need fewer than azimuthal modes do.
ENERGY = Resolution(modes=1, across=16, along=36)


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceOperators(Layers):
    """Operators of one interface; `single` is the part of r_up that meets exactly one facet."""

    single: np.ndarray

    def cut(self, modes: int) -> "InterfaceOperators":
        """The first modes of them."""
        return InterfaceOperators(*(matrices[:modes] for matrices in (self.r_up, self.t_down, self.r_down, self.t_up, self.single)))


@lru_cache(maxsize=24)
def interface_operators(facet: DielectricFacet, alpha, distribution, surface, grid: Grid, resolution: Resolution) -> InterfaceOperators:
    """Operators of a dielectric interface of such facets, met from above; the grid has both their indices."""
    if is_specular(alpha):
        return _specular_operators(facet, grid, resolution.modes)
    setup = (alpha, distribution, surface, grid, resolution)
    below_cosines = grid.cosines(facet.n_other)
    single, multi, t_down = dielectric_rows(facet, grid.cosines(facet.n_own), *setup)
    if resolution.modes == 1:
        single_down, multi_down, t_up = dielectric_rows(facet.turned, below_cosines, *setup)
    else:
        # rows from above average the noise of few facets per mode, and by reciprocity say the way up
        single_down, multi_down, _ = dielectric_rows(facet.turned, below_cosines, *setup, transmits=False)
        above, below = (grid.weights(n) for n in (facet.n_own, facet.n_other))
        t_up = np.swapaxes(t_down, -1, -2) * above / below[:, None]
    return InterfaceOperators(single + multi, t_down, single_down + multi_down, t_up, single)


def _specular_operators(facet: DielectricFacet, grid, modes) -> InterfaceOperators:
    """Exactly diagonal, so that light which is trapped below a critical angle never leaks."""
    above, below = grid.count(facet.n_own), grid.count(facet.n_other)
    f_above, f_below = facet(grid.cosines(facet.n_own)), facet.turned(grid.cosines(facet.n_other))
    every = np.ones((modes, 1, 1))
    r_up, r_down = every * np.diag(f_above), every * np.diag(f_below)
    t_down, t_up = every * np.eye(above, below), every * np.eye(below, above)
    return InterfaceOperators(r_up, t_down * (1.0 - f_above)[:, None], r_down, t_up * (1.0 - f_below)[:, None], np.zeros_like(r_up))


def dielectric_rows(facet: DielectricFacet, cos_theta, alpha, distribution, surface, grid: Grid, resolution: Resolution, transmits: bool = True):
    """Rows for walkers that arrive at cosines (I,) on the side from which the facet is met: (reflected as `direct_f` knows, reflected otherwise, transmitted).

    A mirror reflects "otherwise": its part has no finite f. Without `transmits`, what is transmitted is zeros in its place.
    """
    n_own, n_other, modes = facet.n_own, facet.n_other, resolution.modes
    if is_specular(alpha):
        reflectance = facet(cos_theta)[:, None]
        specular = reflectance * grid.interpolation(n_own, cos_theta)
        refracted = (1.0 - reflectance) * grid.interpolation(n_other, cos_theta_t(cos_theta, facet.eta))
        every = np.ones((modes, 1, 1))
        return 0.0 * every * specular, every * specular, every * refracted
    setup = (alpha, distribution, surface, grid, resolution, transmits)
    parts = [_dielectric_chunk(facet, cos_theta[i : i + _CHUNK], *setup) for i in range(0, len(cos_theta), _CHUNK)]
    single, transmitted, crossed = (np.concatenate(rows, axis=-2) for rows in zip(*parts))
    if _is_resolved(alpha, grid):
        (single,) = _resolved_lobes([facet], cos_theta, n_own, alpha, distribution, surface, grid, modes, resolution.left_out)
    multi = np.zeros_like(single)
    if _scatters_more_than_once(surface, alpha, resolution):
        left = 1.0 - single[0].sum(axis=1, keepdims=True) - crossed
        detail = detail_of(modes, modes + resolution.left_out, resolution.is_draft)
        moments, twice = (shares * left for shares in Microsurface(alpha, distribution, facet).shares(cos_theta, detail))
        multi[: moments.shape[1]] = _spread(moments[0], grid, n_own)
        if transmits:
            transmitted[: moments.shape[1]] += _spread(moments[1], grid, n_other)
        if knows_two_events(surface, alpha, resolution):
            known = _spread(moments[0] if alpha < NARROW_ALPHA else twice, grid, n_own)
            single[: len(known)] += known
            multi[: len(known)] -= known
    return single, multi, transmitted


def _dielectric_chunk(facet, cos_theta, alpha, distribution, surface, grid, resolution, transmits):
    """Of one event: rows reflected, where lobes are not resolved, and transmitted, and the share (I, 1) that crosses."""
    spread = resolution if transmits or not _is_resolved(alpha, grid) else ENERGY
    facets = visible_facets(cos_theta, alpha, distribution, surface, spread.across, spread.along, facet.eta)
    wt, w_refracted = dielectric_refracted(facets, facet)
    single, transmitted = (np.zeros((resolution.modes, len(cos_theta), grid.count(n))) for n in (facet.n_own, facet.n_other))
    if not _is_resolved(alpha, grid):
        wi, w_reflected = dielectric_reflected(facets, facet)
        single = grid.project(facet.n_own, wi, resolution.modes, w_reflected, dtype=resolution.dtype)[0]
    if transmits:
        transmitted = grid.project(facet.n_other, wt, resolution.modes, w_refracted, dtype=resolution.dtype)[0]
    return single, transmitted, w_refracted.sum(axis=1, keepdims=True)


def _scatters_more_than_once(surface: str, alpha: float, resolution: Resolution) -> bool:
    """Whether light that meets several facets counts. Always for energies; in the shape of a narrow surface it is a
    spike at grazing directions, of less than 1e-3 of the energy below 85 degrees, which interpolation would spread.
    """
    return surface == MULTIPLE and (resolution.modes == 1 or alpha >= (_DRAFT_SPIKE if resolution.is_draft else _SPIKE))


def knows_two_events(surface: str, alpha: float, resolution: Resolution) -> bool:
    """Whether f holds what is reflected twice as a formula (`two_events`), beside what is once; of narrow surfaces all that is reflected."""
    return surface == MULTIPLE and resolution.modes > 1 and alpha >= _SPIKE


def _spread(moments, grid: Grid, n: float) -> np.ndarray:
    """Rows (modes, I, N) whose energy over d2p has the Legendre moments (modes, I, K) in 1 - 2 cos^2."""
    order = np.arange(moments.shape[-1])
    shapes = legendre(2.0 * np.square(grid.s(n) / n) - 1.0, len(order)) * (2.0 * order + 1.0)[:, None]
    return moments @ shapes * grid.weights(n) / (np.pi * n * n)


def transmittance(grid: Grid, n: float, tau: float) -> np.ndarray:
    """(N,) share left after one crossing of a medium of optical depth tau."""
    return np.exp(-tau / grid.cosines(n))


@lru_cache(maxsize=24)
def scattering_medium(n: float, tau: float, albedo: float, g: float, grid: Grid, modes: int) -> ScatteringMedium:
    """A medium of index n, of the grid, that scatters this share of what it does not let pass."""
    cosines = grid.cosines(n)
    weights = grid.weights(n) / (2.0 * np.pi * n * n * cosines)
    own = slab(cosines, weights, tau, albedo, g, modes, phase_terms(grid, n))
    return ScatteringMedium(own.passed, own)


def phase_terms(grid: Grid, n: float) -> int:
    """Legendre moments of a phase function in a medium of index n: as many as its directions carry."""
    return 2 * grid.count(n)


def lambert_rows(color: float, n: float, count: int, grid: Grid, modes: int) -> np.ndarray:
    """Rows (modes, count, N) of an ideally diffuse base below a medium of index n."""
    rows = np.zeros((modes, count, grid.count(n)))
    rows[0] = color * grid.weights(n) / (np.pi * n * n)
    return rows


def oren_nayar_rows(color: float, sigma_deg: float, n: float, cos_theta, grid: Grid, modes: int) -> np.ndarray:
    """Rows (modes, I, N) of an Oren-Nayar base for walkers at cosines (I,)."""
    white, once = oren_nayar_shares(np.array([color]), sigma_deg)
    of_white, of_once = _oren_nayar_rows(sigma_deg, n, tuple(cos_theta.tolist()), grid, modes)
    return white * of_white + once * of_once


@lru_cache(maxsize=8)
def _oren_nayar_rows(sigma_deg: float, n: float, cos_theta: tuple, grid: Grid, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of a white base, and of what meets one facet alone: a base of any color is made of these."""
    # mean over the half circle; azimuth pi of the light is a turn of 0
    phi = np.pi * (np.arange(_OREN_NAYAR_AZIMUTHS) + 0.5) / _OREN_NAYAR_AZIMUTHS
    wo = spherical(np.arccos(cos_theta), 0.0)[:, None, None]
    wi = spherical(np.arccos(grid.cosines(n))[:, None], np.pi - phi)
    dark = 1e-9
    white, once = np.moveaxis(oren_nayar(wi, wo, np.array([1.0, dark]), sigma_deg), -1, 0)
    harmonics = np.cos(np.arange(modes)[:, None] * phi) / len(phi)
    weights = grid.weights(n) / (n * n)
    return tuple(np.moveaxis(f @ harmonics.T, -1, 0) * weights for f in (white, once / dark))


def conductor_rows(metals: tuple[ConductorFacet, ...], cos_theta, alpha, distribution, surface, grid: Grid, resolution: Resolution):
    """By channel, rows (modes, I, N) of a conductor of such facets: (reflected once, reflected otherwise)."""
    setup = (alpha, distribution, surface, grid, resolution)
    return _conductor_rows(metals, tuple(cos_theta.tolist()), *setup)


@lru_cache(maxsize=8)
def _conductor_rows(metals, cos_theta: tuple, alpha, distribution, surface, grid, resolution):
    distinct = list(dict.fromkeys(metals))
    cosines = np.array(cos_theta)
    parts = [_conductor_chunk(distinct, cosines[i : i + _CHUNK], alpha, distribution, surface, grid, resolution) for i in range(0, len(cosines), _CHUNK)]
    by_channel = [tuple(np.concatenate(rows, axis=1) for rows in zip(*chunks)) for chunks in zip(*parts)]
    return tuple(by_channel[distinct.index(metal)] for metal in metals)


def _conductor_chunk(metals: list[ConductorFacet], cos_theta, alpha, distribution, surface, grid, resolution) -> list[tuple[np.ndarray, np.ndarray]]:
    n, modes = metals[0].n_above, resolution.modes
    if is_specular(alpha):
        every = np.ones((modes, 1, 1))
        specular = [metal(cos_theta)[:, None] * grid.interpolation(n, cos_theta) for metal in metals]
        return [(0.0 * every * rows, every * rows) for rows in specular]
    if _is_resolved(alpha, grid):
        lobe = (cos_theta, n, alpha, distribution, surface, grid)
        single, white = _resolved_lobes(metals, *lobe, modes, resolution.left_out), _resolved_lobes([np.ones_like], *lobe, 1)[0][0].sum(axis=1)
    else:
        # energies and drafts need fewer across the plane of incidence; along it a draft needs as many, or loses 2 % of a foil's light
        across = 2 * resolution.across if resolution.modes > 1 and not resolution.is_draft else resolution.across
        facets = visible_facets(cos_theta, alpha, distribution, surface, across, 2 * resolution.along)
        wi, weights = facets.reflected()
        cos_om = facets.cos_om
        single, white = grid.project(n, wi, modes, *(weights * metal(cos_om) for metal in metals), dtype=resolution.dtype), weights.sum(axis=1)
    multi = [np.zeros_like(rows) for rows in single]
    if _scatters_more_than_once(surface, alpha, resolution):
        left = np.maximum(1.0 - white, 0.0)[:, None]
        for once, rows, metal in zip(single, multi, metals):
            (moments,), twice = Microsurface(alpha, distribution, metal).shares(cos_theta, detail_of(modes, modes + resolution.left_out, resolution.is_draft))
            rows[: len(moments)] = _spread(moments * left, grid, n)
            if knows_two_events(surface, alpha, resolution):
                known = _spread((moments if alpha < NARROW_ALPHA else twice) * left, grid, n)
                once[: len(known)] += known
                rows[: len(known)] -= known
    return list(zip(single, multi))


def _is_resolved(alpha: float, grid: Grid) -> bool:
    return alpha * grid.nodes >= RESOLVED


def _resolved_lobes(curves: Sequence[Callable], cos_theta, n, alpha, distribution, surface, grid: Grid, modes: int, left_out: int = 0) -> list[np.ndarray]:
    """By Fresnel curve, rows (modes, I, N) of one reflection whose lobe is so wide that its values at the nodes do.

    Scattered facets would miss the root that radiance has at a critical angle; the grid's panels do not.
    """
    nodes = grid.cosines(n)
    if np.array_equal(cos_theta, nodes):  # f is reciprocal
        own, other = np.triu_indices(len(nodes))
    else:
        own, other = (index.ravel() for index in np.indices((len(cos_theta), len(nodes))))
    f = np.empty((len(curves), modes, len(cos_theta), len(nodes)))
    for start in range(0, len(own), _PAIRS):
        o, i = own[start : start + _PAIRS], other[start : start + _PAIRS]
        f[:, :, o, i] = _lobe_modes(curves, cos_theta[o], nodes[i], alpha, distribution, modes, _azimuths(curves, modes, left_out))
    if len(own) < len(cos_theta) * len(nodes):
        f[:, :, other, own] = f[:, :, own, other]
    known = seen_by_both(cos_theta[:, None], nodes, alpha, distribution, surface) * grid.weights(n) / (n * n)
    return list(f * known)


def _azimuths(curves: Sequence[Callable], modes: int, left_out: int) -> int:
    """Azimuths at which lobes are integrated over: a curve with a root, as that under total reflection, needs as many as all modes do."""
    has_root = any(isinstance(curve, DielectricFacet) and curve.eta < 1.0 for curve in curves)
    return _LOBE_AZIMUTHS + 2 * (modes + (left_out if has_root else min(left_out, _MORE)))


def _lobe_modes(curves, cos_o, cos_i, alpha, distribution, modes: int, azimuths: int) -> np.ndarray:
    """(curves, modes, P) means of D F cos(m turn) over azimuth, of one reflection between cosines (P,)."""
    # turn = 2 atan(width tan(u / 2)) is dense about the mirror direction; u crowds towards pi for the lobe's far tail
    x, gauss = gauss_legendre(azimuths)
    remainder = 0.5 * (1.0 - x)
    u, step = np.pi * (1.0 - remainder**4), 2.0 * gauss * remainder**3
    cos_o, cos_i = cos_o[:, None], cos_i[:, None]
    width = np.minimum(1.0, alpha * (cos_o + cos_i))
    # cos(turn / 2)^2
    near = 1.0 / (1.0 + np.square(width) * np.square(np.tan(0.5 * u)))
    sines = np.sqrt((1.0 - np.square(cos_o)) * (1.0 - np.square(cos_i)))
    # the azimuths of wo and wi differ by pi for a turn of 0
    cos_om = np.sqrt(np.maximum(0.5 * (1.0 + cos_o * cos_i + sines) - sines * near, 5e-31))
    facets = microfacet.distribution(np.minimum((0.5 * (cos_o + cos_i)) / cos_om, 1.0), alpha, distribution) * near
    facets *= step / np.square(np.cos(0.5 * u)) * width
    return chebyshev_moments(np.stack([facets * curve(cos_om) for curve in curves]), 2.0 * near - 1.0, modes)
