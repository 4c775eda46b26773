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
from functools import cached_property, lru_cache

import numpy as np

from ...optics.facet_reflectance import DielectricFacet, Facet
from ...optics.gauss import gauss_legendre
from .direction_grid import chebyshev, legendre, to_nodes
from .facets import MULTIPLE, Facets, smith_lambda, visible_facets

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
# Fewer moments would show, which is not so of the rest.
_DRAFT = replace(_REST, azimuths=16, across=10, along=16, directions=12, heights=5)
# A surface narrower than this reflects what meets more facets about where two send it.
NARROW_ALPHA = 0.25


def detail_of(modes: int, whole: int | None = None, is_draft: bool = False) -> Detail:
    """What is told of a surface when operators have so many azimuthal modes, of a `whole` that is as many if not given."""
    rest = _DRAFT if is_draft else _REST
    return ENERGY if modes == 1 else replace(rest, azimuths=min(modes, rest.azimuths), damped=min(whole or modes, _REST.azimuths))


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
        descent = _from_top(self.alpha, self.distribution, tuple(np.asarray(cos_theta).tolist()), detail.heights)
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
    walk = _node_path(surface.alpha, surface.distribution, directions, heights)
    scatters = [_Scatter(surface, side, -cosines, detail) for side in range(sides)]
    single = np.stack([s.single(sides) for s in scatters])
    source = np.einsum("jhk,smjkr->msjhr", walk, single)
    size = sides * directions * heights
    result = []
    # less a step to each height, for the side on which light stays and for the other
    own, other = -walk[:, :, None], -walk[:, :, None, ::-1]
    for m in range(detail.azimuths):
        # energy is the first mode's; the others are good enough in single precision, in half the time
        equations = np.empty((sides, directions, heights, sides, directions, heights), np.float32 if m else np.float64)
        for side, s in enumerate(scatters):
            np.multiply(own, s.reflect[m][:, None, :, None], out=equations[side, :, :, side], casting="same_kind")
            if sides == 2:
                np.multiply(other, s.refract[m][:, None, :, None], out=equations[side, :, :, 1 - side], casting="same_kind")
        equations = equations.reshape(size, size)
        equations[np.diag_indices(size)] += 1.0
        result.append(np.linalg.solve(equations, source[m].reshape(size, -1).astype(equations.dtype)))
    return np.stack(result).reshape(source.shape).astype(float, copy=False), source


class _Scatter:
    """One event of rays that come from directions of cosines (I,), which may lie below the horizon, on one side."""

    def __init__(self, surface: Microsurface, side: int, cos_theta: np.ndarray, detail: Detail):
        self.side, self.detail = side, detail
        facet = surface.sides[side]
        eta = facet.eta if isinstance(facet, DielectricFacet) else 1.0
        self._met = _met(surface.alpha, surface.distribution, eta, tuple(np.asarray(cos_theta).tolist()), detail)
        cos, facets = self._met.cos, self._met.facets
        reflectance = facet(cos)
        if isinstance(facet, DielectricFacet):
            cos_t = np.sqrt(np.maximum(1.0 - (1.0 - cos * cos) / eta**2, 0.0))
            refracted = ((cos / eta - cos_t)[..., None] * facets.wm - facets.wo / eta) * np.array([1.0, 1.0, -1.0])
            self._crossing = facets.weights * (1.0 - reflectance)
            self._refracted = _Rays(surface.alpha, surface.distribution, refracted, self._crossing > 0.0, detail)
        self._kept = facets.weights * reflectance
        self.reflect = self._met.mirrored.at_directions(self._kept)
        self.refract = self._refracted.at_directions(self._crossing) if isinstance(facet, DielectricFacet) else None

    def single(self, sides: int) -> np.ndarray:
        """(azimuths, I, heights, sides * moments): what leaves directly after this event, at the heights' nodes."""
        heights = self.detail.heights
        result = np.zeros((self.detail.azimuths, len(self._kept), heights, sides, self.detail.moments))
        result[:, :, :, self.side] = self._met.mirrored.leaving(self._kept)
        if sides == 2:
            result[:, :, ::-1, 1 - self.side] = self._refracted.leaving(self._crossing)  # the other side's heights are 1 - c
        return result.reshape(*result.shape[:3], -1)

    def leftover(self) -> np.ndarray:
        """(I, heights): share of the light that does not leave a conductor directly after this event, without absorption."""
        return self._met.leftover

    def apply(self, solution: np.ndarray) -> np.ndarray:
        """(azimuths, I, heights, ...): the unknown after this event, at the heights' nodes."""
        result = _through(self.reflect, solution[:, self.side])
        if self.refract is not None:
            result += _through(self.refract, solution[:, 1 - self.side, :, ::-1])
        return result


@dataclass(frozen=True, eq=False, repr=False)
class _Met:
    """Facets that rays meet, the cosines (I, Q) between both, and the rays as mirrors turn them: alike for all channels of a metal."""

    facets: Facets
    cos: np.ndarray
    mirrored: "_Rays"

    @cached_property
    def leftover(self) -> np.ndarray:
        """As `_Scatter.leftover`."""
        weights = self.facets.weights
        return weights.sum(axis=1)[:, None] - self.mirrored.leaving(weights)[0, :, :, 0]


# a surface's own directions and those of its collocation, in turns
@lru_cache(maxsize=2)
def _met(alpha: float, distribution: str, eta: float, cos_theta: tuple[float, ...], detail: Detail) -> _Met:
    facets = visible_facets(np.array(cos_theta), alpha, distribution, MULTIPLE, detail.across, detail.along, eta)
    cos = np.clip(facets.cos_om, 0.0, 1.0)
    mirrored = 2.0 * cos[..., None] * facets.wm - facets.wo
    return _Met(facets, cos, _Rays(alpha, distribution, mirrored, facets.weights > 0.0, detail))


class _Rays:
    """Rays of travel w (I, Q, 3) after an event, of which some are `lit` (I, Q). In each row those that rise come first, then those that fall, and none that is not."""

    def __init__(self, alpha: float, distribution: str, w: np.ndarray, lit: np.ndarray, detail: Detail):
        part = np.where(lit, w[..., 2] < 0.0, np.int8(2))
        self._ends = [np.count_nonzero(part <= last, axis=1) for last in (0, 1)]
        self._order = np.argsort(part, axis=1, kind="stable")[:, : np.max(self._ends)]
        x, y, self._z = (np.take_along_axis(component, self._order, axis=1) for component in np.moveaxis(w, -1, 0))
        self._across = np.hypot(x, y)
        self._alpha, self._distribution, self._detail = alpha, distribution, detail
        # the ray travelled along -x before
        self._turns = chebyshev(-x / np.maximum(self._across, 1e-12), detail.azimuths)

    @cached_property
    def _polar(self) -> np.ndarray:
        """(directions / 2, I, Q) polynomials of the stretched polar angle, of rays up and of rays down."""
        polar = np.arctan2(self._alpha * self._across, self._z)
        # the unknown jumps at the horizon: of two rays from the top, one leaves and one comes down again
        return legendre(4.0 / np.pi * (polar - np.where(self._z < 0.0, 0.5 * np.pi, 0.0)) - 1.0, self._detail.directions // 2)

    @cached_property
    def _nodes(self) -> np.ndarray:
        """(I, Q, directions): weights of the direction nodes for rays of weight 1."""
        nodes, falls = np.moveaxis(self._polar, 0, -1) @ to_nodes(self._detail.directions // 2), (self._z < 0.0)[..., None]
        return np.concatenate([np.where(falls, 0.0, nodes), np.where(falls, nodes, 0.0)], axis=-1)

    @cached_property
    def _free(self) -> np.ndarray:
        """(heights, I, Q): probability that a ray leaves."""
        return _free(self._z, _node_heights(self._detail.heights), self._alpha, self._distribution)

    @cached_property
    def _shapes(self) -> np.ndarray:
        """(moments, I, Q): polynomials of what leaves."""
        return legendre(1.0 - 2.0 * np.square(self._z), self._detail.moments)

    def at_directions(self, weights: np.ndarray) -> np.ndarray:
        """(azimuths, I, directions): weights of the direction nodes, half of them up and half down, for rays of weights (I, Q)."""
        weights = np.take_along_axis(weights, self._order, axis=1)
        if len(self._turns) == 1:
            return np.swapaxes(weights[:, None] @ self._nodes, 0, 1)
        rising = np.where(self._z < 0.0, 0.0, weights)
        turns = np.swapaxes(self._turns, 0, 1)
        moments = np.stack([turns @ np.moveaxis(self._polar * part, 0, -1) for part in (rising, weights - rising)])
        return np.swapaxes(np.concatenate(moments @ to_nodes(self._detail.directions // 2), axis=-1), 0, 1)

    def leaving(self, weights: np.ndarray) -> np.ndarray:
        """(azimuths, I, heights, moments): what leaves directly from the heights' nodes, of rays of weights (I, Q)."""
        free, shapes = self._free * np.take_along_axis(weights, self._order, axis=1), self._shapes
        if len(self._turns) == 1:
            return (np.swapaxes(free, 0, 1) @ np.moveaxis(shapes, 0, -1))[None]
        left = np.empty((len(self._z), len(self._turns), len(free) * len(shapes)))
        for i, rising in enumerate(self._ends[0]):
            both = (free[:, None, i, :rising] * shapes[:, i, :rising]).reshape(left.shape[-1], rising)
            np.matmul(self._turns[:, i, :rising], both.T, out=left[i])
        return np.swapaxes(left, 0, 1).reshape(len(self._turns), len(left), len(free), -1)


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


def _free(cos_theta, heights, alpha: float, distribution: str) -> np.ndarray:
    """(len(heights), ...) probability that a ray of these cosines of travel leaves without another event."""
    log_c = np.log(heights).reshape(-1, *(1,) * np.ndim(cos_theta))
    return np.where(cos_theta > 0.0, np.exp(np.maximum(smith_lambda(np.abs(cos_theta), alpha, distribution) * log_c, -700.0)), 0.0)


# facets of a few widths, which all channels of a metal have in common
@lru_cache(maxsize=8)
def _node_path(alpha: float, distribution: str, directions: int, heights: int) -> np.ndarray:
    """(directions, heights, heights): weights of the height of the next event for rays of the nodes' cosines of travel and heights; not to be written to."""
    cosines, start = _node_cosines(alpha, directions), _node_heights(heights)
    lambda_ = smith_lambda(np.abs(cosines), alpha, distribution)
    return np.where((cosines > 0.0)[:, None, None], _ascent(start, lambda_), _descent(start, lambda_, heights))


@lru_cache(maxsize=8)
def _from_top(alpha: float, distribution: str, cos_theta: tuple[float, ...], heights: int) -> np.ndarray:
    """(I, heights): the same for rays that come from above the surface; not to be written to."""
    return _descent(np.ones(1), smith_lambda(np.abs(np.array(cos_theta)), alpha, distribution), heights)[:, 0]


def _descent(start, lambda_, heights: int) -> np.ndarray:
    """(I, start, heights) of `_node_path`, for rays down whose cosines have these Lambdas (I,)."""
    u, gauss = gauss_legendre(_STEPS)
    t = 0.5 * (u + 1.0)  # the probability is t^2, which softens the root at 0
    fall = t ** (2.0 / (1.0 + lambda_))[:, None]
    return np.einsum("ihtk,t->ihk", _at_heights(start[:, None] * fall[:, None, :], heights), gauss * t)


def _ascent(start, lambda_) -> np.ndarray:
    """The same for rays up."""
    u, gauss = gauss_legendre(_STEPS)
    log_c, rise = np.log(start)[:, None], np.maximum(lambda_, 1e-12)[:, None, None]
    hit = -np.expm1(np.maximum(rise * log_c, -700.0))
    c = np.exp(np.minimum(log_c - np.log1p(-hit * 0.5 * (u + 1.0)) / rise, 0.0))
    return np.einsum("ihtk,t->ihk", _at_heights(c, len(start)), 0.5 * gauss) * hit


def _at_heights(c, heights: int) -> np.ndarray:
    """(..., heights) weights that interpolate values at the heights' nodes at c."""
    y = 4.0 / np.pi * np.arcsin(np.sqrt(np.clip(c, 0.0, 1.0))) - 1.0
    return np.moveaxis(legendre(y, heights), 0, -1) @ to_nodes(heights)
