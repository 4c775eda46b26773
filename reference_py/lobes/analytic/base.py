# SPDX-License-Identifier: GPL-3.0-or-later
"""What layers and the base exchange: uniform light below the layers, and the lobe of a metal base.

Numbers of many stacks are arrays, as in `beam.Crossing`. For a diffuse base the exact total is R(o) + T(o) rho T_d / (1 - rho R_d), with T_d and R_d of uniform light from below.
T_d follows from the same T(o) by reciprocity; without absorption R_d = 1 - T_d, so a white stack is exactly white.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce

import numpy as np

from ...optics.fresnel import fresnel_conductor
from ...optics.gauss import gauss_legendre
from ...optics.microfacet import GGX, distribution_of, smith_lambda_stretched
from .beam import Crossing, attenuation, cosine, through
from .calibration import (
    ANISOTROPIC_RETAINED,
    BASE_LOSS,
    EXIT_SPREAD,
    LEAST_COS,
    MOST_LOBE_SHARE,
    NODE_SPREAD,
    REMIX_BACK,
    REMIX_POWER,
    REMIX_SCALE,
    RETAINED_ORDER,
    RETAINED_SCALE,
)
from .interface_tables import side

# Gauss nodes over the cosine outside, over the light trapped below, and over the lobe of a base.
ESCAPING, TRAPPED = 4, 3
LOBE_RADII, LOBE_AZIMUTHS = 4, 3
# Mean of a metal's Fresnel curve over the directions between its facets.
MEAN_COSINES, MEAN_WEIGHTS = np.array([0.35, 0.6, 0.85, 1.0]), np.array([0.2, 0.3, 0.35, 0.15])


@cache
def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (count,) of Gauss-Legendre on 0..1."""
    x, w = gauss_legendre(count)
    return 0.5 * (x + 1.0), 0.5 * w


def uniform_below(down: Sequence[Crossing], up: Sequence[Crossing], n_base) -> tuple[np.ndarray, np.ndarray]:
    """(R_d, T_d), each (1, 3), of the layers for uniform light from below.

    `up` are the crossings from the base; its first tau is that of the medium above the base, where a beam starts.
    """
    u, w = gauss(ESCAPING)
    p = np.sqrt(1.0 - u * u)
    transmitted = _total((2.0 * w * u)[:, None] * through(down, p, np.zeros_like(p)).transmitted) / np.asarray(n_base**2)[..., None]
    if not any(np.any(c.tau) for c in down):
        return 1.0 - transmitted, transmitted
    p, weight = _streams(up, n_base)
    back, out = from_base(up, n_base, p, np.zeros_like(p))
    absorbed = _total(weight[..., None] * (1.0 - back - out))
    return np.maximum(1.0 - transmitted - np.maximum(absorbed, 0.0), 0.0), transmitted


def _total(shares: np.ndarray) -> np.ndarray:
    """(..., 1, 3): the sum over beams (..., n, 3)."""
    return np.sum(shares, axis=-2, keepdims=True)


def _least(up: Sequence[Crossing]):
    """The least index of those that light from the base comes through."""
    return reduce(np.minimum, [c.n_other for c in up], 1.0)


def _streams(up: Sequence[Crossing], n_base):
    """p (..., n) and weights (..., n) of uniform light in the medium above the base: what may escape, then what is trapped."""
    least = _least(up)
    u, w = gauss(ESCAPING)
    p, weight = least * np.sqrt(1.0 - u * u), 2.0 * w * u * np.square(least / n_base)
    critical = np.sqrt(np.maximum(1.0 - np.square(least / n_base), 0.0))
    u, w = gauss(TRAPPED)
    c = critical * u
    trapped = n_base * np.sqrt(1.0 - c * c)
    p = np.broadcast_to(p, (*np.shape(trapped)[:-1], ESCAPING))
    return np.concatenate([p, trapped], axis=-1), np.concatenate([weight, 2.0 * w * critical * c], axis=-1)


def from_base(up: Sequence[Crossing], n_base, p, variance) -> tuple[np.ndarray, np.ndarray]:
    """Shares (..., 3) that return and that escape of beams (...) that leave the base; `up[0].tau` is of their own medium."""
    left = attenuation(up[0].tau, p, 0.0, n_base)
    shifted = [replace(c, tau=up[i + 1].tau if i + 1 < len(up) else np.zeros(3)) for i, c in enumerate(up)]
    passage = through(shifted, p, variance)
    return (passage.first + passage.inner) * left * left, passage.transmitted * left


@dataclass(frozen=True, eq=False, repr=False)
class Below:
    """The layers for light from below: polynomials through the nodes of light that may escape and of trapped light."""

    least: float | np.ndarray
    n_base: float | np.ndarray
    escaping: tuple[np.ndarray, np.ndarray]
    """Coefficients (..., ESCAPING, 3) of the shares that return and that escape, over the cosine in the thinnest medium."""
    trapped: tuple[np.ndarray, np.ndarray]
    """(..., TRAPPED, 3), over the cosine below, from 0 at grazing to 1 at the critical angle."""
    uniform: tuple[np.ndarray, np.ndarray]
    """Shares (..., 1, 3) of uniform light."""

    def at(self, p, width) -> tuple[np.ndarray, np.ndarray]:
        """Shares (..., Q, 3) that return and that escape of beams of transverse momentum p and some width (..., Q)."""
        least, n_base = (np.asarray(n)[..., None] for n in (self.least, self.n_base))
        u = np.sqrt(np.maximum(1.0 - np.square(p / least), 0.0))
        inside = [_polynomial(c, u) for c in self.escaping]
        if not np.any(least < n_base):
            return tuple(inside)
        critical2 = np.maximum(1.0 - np.square(least / n_base), 1e-12)
        v = np.sqrt(np.clip((1.0 - np.square(p / n_base)) / critical2, 0.0, 1.0))
        beyond = np.clip(0.5 + (p - least) / np.maximum(width, 1e-4), 0.0, 1.0)[..., None]
        return tuple(i + beyond * (_polynomial(c, v) - i) for i, c in zip(inside, self.trapped))


def _polynomial(coefficients, x):
    """(..., n, Q, 3) of coefficients (..., count, 3) at x (..., n, Q)."""
    x = x[..., None]
    parts = [coefficients[..., k, None, None, :] for k in reversed(range(coefficients.shape[-2]))]
    total = parts[0] * x
    for c in parts[1:-1]:
        total += c
        total *= x
    total += parts[-1]
    return np.clip(total, 0.0, 1.0, out=total)


def layers_below(up: Sequence[Crossing], n_base) -> Below:
    """The layers for light from below; `up` are the crossings from the base, which lies in a medium of index `n_base`."""
    p, weight = _streams(up, n_base)
    shares = from_base(up, n_base, p, np.zeros_like(p))
    inside, beyond = polynomial_fit(ESCAPING), polynomial_fit(TRAPPED)
    return Below(
        _least(up), n_base, tuple(inside @ s[..., :ESCAPING, :] for s in shares), tuple(beyond @ s[..., ESCAPING:, :] for s in shares),
        tuple(_total(weight[..., None] * s) for s in shares),
    )  # fmt: skip


@cache
def polynomial_fit(count: int) -> np.ndarray:
    """(count, count): coefficients, from the constant on, of the polynomial through values at the Gauss nodes."""
    return np.linalg.inv(np.vander(gauss(count)[0], increasing=True))


@dataclass(frozen=True, eq=False, repr=False)
class Facets:
    """A metal's facets as beams (...) see them: their alphas along and across the plane of incidence, and the share `white` (...)
    of light that one facet of a white surface lets go; `gap` is the difference of the alphas' squares over their sum."""

    sides: tuple[np.ndarray | float, np.ndarray | float]
    white: np.ndarray
    gap: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class MetalLobe:
    """Energies (..., 3) of light that a metal base sends out through the layers, per unit that reaches it."""

    first: np.ndarray
    """After one reflection on the base."""
    later: np.ndarray
    """After more of them."""


def bare_metal(cos_theta, alpha, distribution: str, eta: np.ndarray, k: np.ndarray, facets: Facets) -> np.ndarray:
    """Directional albedo (..., 3) of a lossless-faceted metal without layers."""
    p = np.sqrt(1.0 - np.square(cos_theta))
    single, multi, _ = _reflected(p, 0.0 * p, 1.0, alpha, distribution, distribution, eta, k, facets)
    return np.sum(single, axis=-2) + multi


def metal_lobe(up: Sequence[Crossing], n_base, p, variance, alpha, distribution: str, eta, k, seen: Facets) -> MetalLobe:
    """The base's lobe for beams (...) that reach it and see its facets; eta, k (..., 3) are relative to the medium above it.

    The lobe is carried out through the layers at a few of its directions. Its later orders return along the
    directions that were reflected, mixed with uniform light the more the wider the lobe is.
    """
    widened = np.sqrt(variance * EXIT_SPREAD) / (2.0 * n_base * cosine(p, n_base))
    share, facets, p_out = _reflected(p, widened, n_base, alpha, distribution, up[0].distribution, eta, k, seen)
    total_alpha = np.minimum(np.sqrt(alpha * alpha + np.square(widened)), 1.0)
    width = (NODE_SPREAD * 2.0 * n_base * cosine(p, n_base) * total_alpha)[..., None] * lobe_nodes()[4]
    below = layers_below(up, n_base)
    returns, escapes = below.at(p_out, width)
    back_d, out_d = below.uniform
    first = np.sum(share * escapes, axis=-2) + facets * out_d
    returned = share * returns
    back = np.sum(returned, axis=-2)
    scale = np.maximum(back, 1e-12)
    out_again, back_again = (np.sum(returned * part, axis=-2) / scale for part in (escapes, returns))
    roughest = reduce(np.maximum, [c.alpha for c in up if side(c.n_other / c.n_own)], 0.0)
    retained = out_again * (1.0 - RETAINED_ORDER * np.asarray(roughest / (roughest + RETAINED_SCALE))[..., None])
    back_again = back_again + out_again - retained
    width = total_alpha**REMIX_POWER
    remixed, remixed_back = ((width / (width + scale))[..., None] for scale in (REMIX_SCALE, REMIX_BACK))
    out_again, back_again = retained + remixed * (out_d - retained), back_again + remixed_back * (back_d - back_again)
    albedo = np.sum(share, axis=-2) + facets
    return MetalLobe(first, (back + facets * back_d) * albedo * out_again / (1.0 - albedo * back_again))


def _reflected(p, widened, n, alpha, distribution: str, distribution_above: str, eta, k, facets: Facets):
    """What a metal reflects: by one facet, per node (..., Q, 3), by more of them (..., 3), and p of the nodes (..., Q)."""
    seen, hidden, p_out, cos_om = _lobe_nodes(p, widened, n, distribution, distribution_above, facets)
    fresnel = fresnel_conductor(cos_om[..., None], eta[..., None, :], k[..., None, :])
    again = np.sum(hidden[..., None] * fresnel, axis=-2)
    later = _later_facets(alpha, eta, k)
    later = later + facets.gap * (_later_anisotropic(again, 1.0 - facets.white[..., None]) - later)
    return seen[..., None] * fresnel, again * later, p_out


def _later_facets(alpha, eta, k) -> np.ndarray:
    """Share (..., 3) of light that leaves a metal after it met one facet and was not let go (after Kulla and Conty 2017)."""
    mean = np.sum(MEAN_WEIGHTS[:, None] * fresnel_conductor(MEAN_COSINES[:, None], eta[..., None, :], k[..., None, :]), axis=-2)
    retained = np.asarray(BASE_LOSS * alpha * alpha / (1.0 + (1.0 + BASE_LOSS) * alpha * alpha))[..., None]
    return mean * (1.0 - retained) / (1.0 - mean * retained)


def _later_anisotropic(again: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """The same share (..., 3) where facets are anisotropic, whose light stays near the plane it came in: `again` (..., 3) is what the
    first facet reflected of the share `hidden` (..., 1) that it did not let go."""
    mean = again / np.maximum(hidden, 1e-9)
    retained = ANISOTROPIC_RETAINED * hidden
    return mean * (1.0 - retained) / (1.0 - mean * retained)


@cache
def lobe_nodes() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(u, weight, cos, sin of the azimuth, range of slopes for alpha 1), each (Q,), of points of a cap.

    Half of the azimuth is enough.
    """
    u, w = gauss(LOBE_RADII)
    azimuth = np.pi * (np.arange(LOBE_AZIMUTHS) + 0.5) / LOBE_AZIMUTHS
    return (
        np.repeat(u, LOBE_AZIMUTHS), np.repeat(w, LOBE_AZIMUTHS) / LOBE_AZIMUTHS,
        np.tile(np.cos(azimuth), LOBE_RADII), np.tile(np.sin(azimuth), LOBE_RADII),
        np.repeat(w / (2.0 * np.sqrt(u) * (1.0 - u) ** 1.5), LOBE_AZIMUTHS),
    )  # fmt: skip


def _lobe_nodes(p, widened, n, distribution: str, distribution_above: str, facets: Facets):
    """(seen, hidden, p, cosine on the facet), each (..., Q): directions of a metal's lobe from its visible facets.

    `seen` is the share of light that one facet lets go, `hidden` that which meets another.
    Nodes of a spherical cap (Dupuy23), then moved apart by what `widened`, the spread of the beam as an alpha, adds.
    """
    u, node_weight, turn_x, turn_y, _ = lobe_nodes()
    own, above, nodes = (distribution_of(name).slope2_quantile(u) for name in (distribution, distribution_above, GGX))
    scale = np.sqrt(own / nodes)
    along, across = (np.asarray(alpha)[..., None] for alpha in facets.sides)
    apart_x, apart_y = (np.sqrt(a * a * own + np.square(widened[..., None]) * above) - a * np.sqrt(own) for a in (along, across))
    along, across = along * scale, across * scale
    c, s = cosine(p, n)[..., None], np.minimum(p / n, 1.0)[..., None]
    length = np.sqrt(np.square(along * s) + c * c)
    ax, az = along * s / length, c / length
    hz = (1.0 - u) * (1.0 + az)
    sin = np.sqrt(np.maximum(1.0 - np.square(hz - az), 0.0))
    hx, hy = along * (sin * turn_x + ax), across * sin * turn_y
    length = np.sqrt(hx * hx + hy * hy + hz * hz)
    hx, hy, hz = hx / length, hy / length, hz / length
    cos_om = s * hx + c * hz
    iz, ix, iy = 2.0 * cos_om * hz - c, 2.0 * cos_om * hx - s, 2.0 * cos_om * hy
    lambda_o = smith_lambda_stretched(np.square(along * s / c), GGX)
    lambda_i = smith_lambda_stretched((np.square(along * ix) + np.square(across * iy)) / np.square(np.maximum(iz, LEAST_COS)), GGX)
    seen = np.where(iz > 0.0, (1.0 + lambda_o) / (1.0 + lambda_o + lambda_i), 0.0)
    ix, iy = ix + 2.0 * c * apart_x * turn_x, iy + 2.0 * c * apart_y * turn_y
    # the nodes know the lobe's shape, the tables its energy
    energy = facets.white[..., None]
    hidden = node_weight * (1.0 - seen)
    hidden = hidden * (1.0 - energy) / np.maximum(np.sum(hidden, axis=-1, keepdims=True), 1e-9)
    seen = node_weight * seen
    seen = seen * energy / np.sum(seen, axis=-1, keepdims=True)
    return seen, hidden, np.asarray(n)[..., None] * np.minimum(np.sqrt(ix * ix + iy * iy), MOST_LOBE_SHARE), np.minimum(cos_om, 1.0)
