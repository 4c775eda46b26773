# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that meets a microsurface more than once (Heitz16, "Multiple-Scattering Microfacet BSDFs with the Smith Model").

Its energy is known exactly: it is what one event leaves over. How it is shared out, between reflection and
transmission and over directions, is solved here without noise, as transport in height.

A height h enters through c = C1(h) alone: a ray of direction w is free from c to c' with probability
(c / c')^Lambda(w), where Lambda(w) = -1 - Lambda(-w) downwards. Below a dielectric the same holds upside down, with
1 - c, so a ray that crosses a facet goes on in the mirrored frame. The unknown is what a ray of direction w that
leaves height c gives after at least one more event; it is collocated at directions x heights nodes per side, with
the stretched polar angle (tan = alpha tan(theta)) and c = sin^2 as smooth variables. Energies need few polar moments
of what leaves; f needs many, and azimuthal modes (`detail_of`).
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ...optics.facet_reflectance import DielectricFacet, Facet
from .direction_grid import chebyshev, gauss_legendre, legendre
from .facets import MULTIPLE, smith_lambda, visible_facets

# Quadrature over heights along a ray.
_STEPS = 12
# Exponent of the damping of the last azimuthal mode and polar moment.
_DAMPED = 4.0
# A leftover below this is rounding.
_NOTHING = 1e-12
# What the collocation of a conductor is good to, as a part of the light; a leftover below it has no shape that is known.
_ACCURACY = 1e-4


@dataclass(frozen=True)
class Detail:
    """Azimuthal modes and polar moments of what leaves; facets across and along the plane of incidence that tell them; nodes of the
    collocation: directions, half of them up and half down, and heights."""

    azimuths: int
    moments: int
    across: int
    along: int
    directions: int = 20
    heights: int = 10
    damped: int = 0
    """Azimuths, or 0 for none: moments are those of what `two_events` does not know, damped to those of light that is spread by about 2.8 / azimuths."""

    @property
    def damping(self) -> np.ndarray:
        """(azimuths, 1, moments) factors: light that is spread stays positive, where a cut series puts as much light far from a lobe as in it."""
        if not self.damped:
            return np.ones((1, 1, 1))
        by_azimuth, by_moment = (
            np.exp(-_DAMPED * np.square(np.arange(count) / whole)) for count, whole in ((self.azimuths, self.damped), (self.moments, self.moments))
        )
        return by_azimuth[:, None, None] * by_moment


ENERGY = Detail(azimuths=1, moments=8, across=16, along=28)
# Of f, what `two_events` does not know: little, or smooth.
_REST = Detail(azimuths=24, moments=16, across=16, along=28, heights=6, damped=24)
# Fewer azimuths or moments would show, which is not so of the rest.
_DRAFT = replace(_REST, across=10, along=16, directions=12, heights=5)
# A surface narrower than this reflects what meets more facets about where two send it.
NARROW_ALPHA = 0.25


def detail_of(modes: int, whole: int | None = None, is_draft: bool = False) -> Detail:
    """What is told of a surface when operators have so many azimuthal modes, of a `whole` that is as many if not given."""
    rest = _DRAFT if is_draft else _REST
    return ENERGY if modes == 1 else replace(rest, azimuths=min(modes, rest.azimuths), damped=min(whole or modes, rest.azimuths))


@dataclass(frozen=True)
class Microsurface:
    """A surface of facets that light meets from side 0; a dielectric's has a second side."""

    alpha: float
    distribution: str
    facet: Facet

    @property
    def sides(self) -> tuple[Facet, ...]:
        """The facet as each side meets it."""
        return (self.facet, self.facet.turned) if isinstance(self.facet, DielectricFacet) else (self.facet,)

    def shares(self, cos_theta: np.ndarray, detail: Detail) -> tuple[np.ndarray, np.ndarray]:
        """How the leftover of light at cosines (I,) on side 0 is shared: (side, azimuths, I, moments), and the part of it that is two
        reflections, (azimuths, I, moments).

        Mean of P_k(1 - 2 cos^2) cos(m turn) per unit of leftover; [:, 0, :, 0] sums to 1 over the sides of a dielectric.
        """
        # The two sides of an interface are one problem, whichever the light comes from.
        surface, side = self, 0
        if isinstance(self.facet, DielectricFacet) and self.facet.eta < 1.0:
            surface, side = replace(self, facet=self.facet.turned), 1
        scatter = _Scatter(surface, side, cos_theta, detail)
        # from above the surface, where c = 1, every ray comes down to some height
        descent = _descent(np.ones(1), cos_theta, self, detail.heights)[:, 0]
        solution, source = _solution(surface, detail)
        again = np.einsum("ih,mihr->mir", descent, scatter.apply(solution))
        again = np.moveaxis(again.reshape(detail.azimuths, len(cos_theta), -1, detail.moments), 2, 0)
        again = again[::-1] if side else again
        own = source[:, side, ..., side * detail.moments :][..., : detail.moments]
        twice = np.einsum("ih,mihr->mir", descent, _through(scatter.reflect, own))
        # No moment exceeds the energy, which is positive and at most the leftover: where there is hardly any, as on
        # narrow Beckmann surfaces, the collocation's error says otherwise.
        energy = np.maximum(again[:, 0, :, 0], 0.0)
        least = _ACCURACY
        if len(self.sides) == 2:
            left = energy.sum(axis=0)  # what does not leave directly, up to the collocation's error, which this takes out
            least = _NOTHING
        else:
            left = np.einsum("ih,ih->i", descent, scatter.leftover())
        shape = np.clip(again / np.maximum(energy, least)[:, None, :, None], -1.0, 1.0)
        shape[:, 0, :, 0] = 1.0
        share = np.where(left > _NOTHING, np.minimum(energy / np.maximum(left, _NOTHING), 1.0), 0.0)
        again = shape * share[:, None, :, None] * detail.damping
        energy = np.maximum(twice[0, :, 0], 0.0)
        shape = np.clip(twice / np.maximum(energy, least)[:, None], -1.0, 1.0)
        shape[0, :, 0] = 1.0
        share_of_two = np.where(left > _NOTHING, np.minimum(energy / np.maximum(left, _NOTHING), share[0]), 0.0)
        return again, shape * share_of_two[:, None] * detail.damping


@lru_cache(maxsize=64)
def _solution(surface: Microsurface, detail: Detail) -> tuple[np.ndarray, np.ndarray]:
    """(azimuths, side, directions, heights, sides * moments) of the unknown at the nodes, and of its part that meets one facet more."""
    sides = len(surface.sides)
    directions, heights = detail.directions, detail.heights
    cosines = _node_cosines(surface.alpha, directions)
    walk = _path(_node_heights(heights), cosines, surface)
    scatters = [_Scatter(surface, side, -cosines, detail) for side in range(sides)]
    single = np.stack([s.single(sides) for s in scatters])
    source = np.einsum("jhk,smjkr->msjhr", walk, single)
    size = sides * directions * heights
    result = []
    for m in range(detail.azimuths):
        kernel = np.zeros((sides, directions, heights, sides, directions, heights))
        for side, s in enumerate(scatters):
            kernel[side, :, :, side] += np.einsum("jhk,jl->jhlk", walk, s.reflect[m])
            if sides == 2:
                kernel[side, :, :, 1 - side] += np.einsum("jhk,jl->jhlk", walk, s.refract[m])[..., ::-1]
        right = source[m].reshape(size, -1)
        result.append(np.linalg.solve(np.eye(size) - kernel.reshape(size, size), right))
    return np.stack(result).reshape(source.shape), source


class _Scatter:
    """One event of rays that come from directions of cosines (I,), which may lie below the horizon, on one side."""

    def __init__(self, surface: Microsurface, side: int, cos_theta: np.ndarray, detail: Detail):
        self.surface, self.side, self.detail = surface, side, detail
        facet = surface.sides[side]
        eta = facet.eta if isinstance(facet, DielectricFacet) else 1.0
        facets = visible_facets(cos_theta, surface.alpha, surface.distribution, MULTIPLE, detail.across, detail.along, eta)
        cos = np.clip(facets.cos_om, 0.0, 1.0)
        reflectance = facet(cos)
        if isinstance(facet, DielectricFacet):
            cos_t = np.sqrt(np.maximum(1.0 - (1.0 - cos * cos) / eta**2, 0.0))
            refracted = (cos / eta - cos_t)[..., None] * facets.wm - facets.wo / eta
            self._refracted = _Rays(surface, refracted * np.array([1.0, 1.0, -1.0]), facets.weights * (1.0 - reflectance), detail)
        self._mirrored, self._weights = 2.0 * cos[..., None] * facets.wm - facets.wo, facets.weights
        self._reflected = _Rays(surface, self._mirrored, facets.weights * reflectance, detail)
        self.reflect = self._reflected.at_directions()
        self.refract = self._refracted.at_directions() if isinstance(facet, DielectricFacet) else None

    def single(self, sides: int) -> np.ndarray:
        """(azimuths, I, heights, sides * moments): what leaves directly after this event, at the heights' nodes."""
        heights = _node_heights(self.detail.heights)
        result = np.zeros((self.detail.azimuths, len(self._weights), len(heights), sides, self.detail.moments))
        result[:, :, :, self.side] = self._reflected.leaving(heights)
        if sides == 2:
            result[:, :, :, 1 - self.side] = self._refracted.leaving(1.0 - heights)
        return result.reshape(*result.shape[:3], -1)

    def leftover(self) -> np.ndarray:
        """(I, heights): share of the light that does not leave a conductor directly after this event, without absorption."""
        heights = _node_heights(self.detail.heights)
        return np.einsum("iq,hiq->ih", self._weights, 1.0 - _free(self._mirrored[..., 2], heights, self.surface))

    def apply(self, solution: np.ndarray) -> np.ndarray:
        """(azimuths, I, heights, ...): the unknown after this event, at the heights' nodes."""
        result = _through(self.reflect, solution[:, self.side])
        if self.refract is not None:
            result += _through(self.refract, solution[:, 1 - self.side, :, ::-1])
        return result


class _Rays:
    """Rays of travel w (I, Q, 3) and weights (I, Q) after an event. In each row those that rise come first, then those that fall, and none that is empty."""

    def __init__(self, surface: Microsurface, w: np.ndarray, weights: np.ndarray, detail: Detail):
        part = np.where(weights > 0.0, w[..., 2] < 0.0, np.int8(2))
        self._ends = [np.count_nonzero(part <= last, axis=1) for last in (0, 1)]
        order = np.argsort(part, axis=1, kind="stable")[:, : np.max(self._ends)]
        x, y, self._z = (np.take_along_axis(component, order, axis=1) for component in np.moveaxis(w, -1, 0))
        self._weights, self._across = np.take_along_axis(weights, order, axis=1), np.hypot(x, y)
        self._surface, self._detail = surface, detail
        # the ray travelled along -x before
        self._turns = chebyshev(-x / np.maximum(self._across, 1e-12), detail.azimuths)

    def at_directions(self) -> np.ndarray:
        """(azimuths, I, directions): weights of the direction nodes, half of them up and half down."""
        polar, half = np.arctan2(self._surface.alpha * self._across, self._z), self._detail.directions // 2
        # the unknown jumps at the horizon: of two rays from the top, one leaves and one comes down again
        basis = legendre(4.0 / np.pi * (polar - np.where(self._z < 0.0, 0.5 * np.pi, 0.0)) - 1.0, half) * self._weights
        moments = np.empty((2, len(polar), len(self._turns), half))
        for i, (rising, filled) in enumerate(zip(*self._ends)):
            for moment, rays in zip(moments, (slice(rising), slice(rising, filled))):
                np.matmul(self._turns[:, i, rays], basis[:, i, rays].T, out=moment[i])
        return np.swapaxes(np.concatenate(moments @ _to_nodes(half), axis=-1), 0, 1)

    def leaving(self, heights) -> np.ndarray:
        """(azimuths, I, heights, moments): what leaves directly."""
        free = self._weights * _free(self._z, heights, self._surface)
        shapes = legendre(1.0 - 2.0 * np.square(self._z), self._detail.moments)
        left = np.empty((len(self._z), len(self._turns), len(heights) * len(shapes)))
        for i, rising in enumerate(self._ends[0]):
            both = (free[:, None, i, :rising] * shapes[:, i, :rising]).reshape(left.shape[-1], rising)
            np.matmul(self._turns[:, i, :rising], both.T, out=left[i])
        return np.swapaxes(left, 0, 1).reshape(len(self._turns), len(left), len(heights), -1)


def _through(matrix, values) -> np.ndarray:
    """(m, i, ...) of matrix (m, i, j) on values (m, j, ...)."""
    return (matrix @ values.reshape(*values.shape[:2], -1)).reshape(*matrix.shape[:2], *values.shape[2:])


def _node_cosines(alpha: float, directions: int) -> np.ndarray:
    """Cosines (directions,) of travel, from up to down."""
    up = 0.25 * np.pi * (gauss_legendre(directions // 2)[0] + 1.0)
    polar = np.concatenate([up, up + 0.5 * np.pi])
    return alpha * np.cos(polar) / np.hypot(np.sin(polar), alpha * np.cos(polar))


def _node_heights(heights: int) -> np.ndarray:
    """c (heights,), symmetric about 1/2."""
    return np.square(np.sin(0.25 * np.pi * (gauss_legendre(heights)[0] + 1.0)))


def _lambda(cos_theta, surface: Microsurface):
    return smith_lambda(np.abs(cos_theta), surface.alpha, surface.distribution)


def _free(cos_theta, heights, surface: Microsurface) -> np.ndarray:
    """(len(heights), ...) probability that a ray of these cosines of travel leaves without another event."""
    log_c = np.log(heights).reshape(-1, *(1,) * np.ndim(cos_theta))
    return np.where(cos_theta > 0.0, np.exp(np.maximum(_lambda(cos_theta, surface) * log_c, -700.0)), 0.0)


def _path(start, cos_theta, surface: Microsurface) -> np.ndarray:
    """(I, heights, heights): weights of the height of the next event for rays of cosines of travel (I,) from `start` (heights,)."""
    up = (cos_theta > 0.0)[:, None, None]
    return np.where(up, _ascent(start, cos_theta, surface), _descent(start, cos_theta, surface, len(start)))


def _descent(start, cos_theta, surface: Microsurface, heights: int) -> np.ndarray:
    u, gauss = gauss_legendre(_STEPS)
    t = 0.5 * (u + 1.0)  # the probability is t^2, which softens the root at 0
    fall = t ** (2.0 / (1.0 + _lambda(cos_theta, surface)))[:, None]
    return np.einsum("ihtk,t->ihk", _at_heights(start[:, None] * fall[:, None, :], heights), gauss * t)


def _ascent(start, cos_theta, surface: Microsurface) -> np.ndarray:
    u, gauss = gauss_legendre(_STEPS)
    log_c, rise = np.log(start)[:, None], np.maximum(_lambda(cos_theta, surface), 1e-12)[:, None, None]
    hit = -np.expm1(np.maximum(rise * log_c, -700.0))
    c = np.exp(np.minimum(log_c - np.log1p(-hit * 0.5 * (u + 1.0)) / rise, 0.0))
    return np.einsum("ihtk,t->ihk", _at_heights(c, len(start)), 0.5 * gauss) * hit


def _at_heights(c, heights: int) -> np.ndarray:
    """(..., heights) weights that interpolate values at the heights' nodes at c."""
    y = 4.0 / np.pi * np.arcsin(np.sqrt(np.clip(c, 0.0, 1.0))) - 1.0
    return np.moveaxis(legendre(y, heights), 0, -1) @ _to_nodes(heights)


def _to_nodes(count: int) -> np.ndarray:
    """(count, count): from values of the Legendre polynomials at a point to weights of Gauss nodes."""
    nodes, gauss = gauss_legendre(count)
    return legendre(nodes, count) * gauss * (np.arange(count) + 0.5)[:, None]
