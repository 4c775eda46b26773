# SPDX-License-Identifier: GPL-3.0-or-later
"""What layers and the base exchange: uniform light below the layers, and the lobe of a metal base.

For a diffuse base the exact total is R(o) + T(o) rho T_d / (1 - rho R_d), with T_d and R_d of uniform light from below.
T_d follows from the same T(o) by reciprocity; without absorption R_d = 1 - T_d, so a white stack is exactly white.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...optics.fresnel import fresnel_conductor
from ...optics.microfacet import GGX, smith_lambda
from .beam import Crossing, attenuation, cosine, through
from .calibration import (
    BASE_LOSS, EXIT_SPREAD, KEPT_ORDER, KEPT_SCALE, LEAST_COS, MOST_LOBE_SHARE, NODE_SPREAD, STIR_SCALE,
)
from .tables import closure_energy

# Gauss nodes over the cosine outside, over the light trapped below, and over the lobe of a base.
ESCAPING, TRAPPED = 4, 3
LOBE_RADII, LOBE_AZIMUTHS = 3, 3
# Mean of a metal's Fresnel curve over the directions between its facets.
MEAN_COSINES, MEAN_WEIGHTS = np.array([0.35, 0.6, 0.85, 1.0]), np.array([0.2, 0.3, 0.35, 0.15])


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (count,) of Gauss-Legendre on 0..1."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (x + 1.0), 0.5 * w


def uniform_below(down: Sequence[Crossing], up: Sequence[Crossing], n_base: float) -> tuple[np.ndarray, np.ndarray]:
    """(R_d, T_d), each (3,), of the layers for uniform light from below.

    `up` are the crossings from the base; its first tau is that of the medium above the base, where a beam starts.
    """
    u, w = gauss(ESCAPING)
    p = np.sqrt(1.0 - u * u)
    transmitted = np.sum((2.0 * w * u)[:, None] * through(down, p, np.zeros_like(p)).transmitted, axis=0) / n_base**2
    if not any(np.any(c.tau) for c in down):
        return 1.0 - transmitted, transmitted
    p, weight = _streams(up, n_base)
    passage = from_base(up, n_base, p, np.zeros_like(p), np.zeros_like(p))
    absorbed = np.sum(weight[:, None] * (1.0 - passage.reflected - passage.escaped), axis=0)
    return np.maximum(1.0 - transmitted - np.maximum(absorbed, 0.0), 0.0), transmitted


def _streams(up: Sequence[Crossing], n_base: float):
    """p (n,) and weights (n,) of uniform light in the medium above the base: what may escape, then what is trapped."""
    least = min([1.0] + [c.n_other for c in up])
    u, w = gauss(ESCAPING)
    p, weight = least * np.sqrt(1.0 - u * u), 2.0 * w * u * (least / n_base) ** 2
    critical = np.sqrt(max(1.0 - (least / n_base) ** 2, 0.0))
    u, w = gauss(TRAPPED)
    c = critical * u
    return np.concatenate([p, n_base * np.sqrt(1.0 - c * c)]), np.concatenate([weight, 2.0 * w * critical * c])


@dataclass(frozen=True)
class FromBase:
    """Light that leaves the base: shares (..., 3) that return to it and that escape; `left` of one crossing of its medium."""

    reflected: np.ndarray
    escaped: np.ndarray


def from_base(up: Sequence[Crossing], n_base: float, p, variance, spread) -> FromBase:
    """Send beams (...) from the base; `up[0].tau` belongs to the medium they start in. `spread` widens absorption alone."""
    left = attenuation(up[0].tau, p, spread, n_base)
    shifted = [Crossing(c.n_own, c.n_other, c.alpha, c.kind, up[i + 1].tau if i + 1 < len(up) else np.zeros(3)) for i, c in enumerate(up)]
    passage = through(shifted, p, variance)
    return FromBase((passage.first + passage.inner) * left * left, passage.transmitted * left)


@dataclass(frozen=True)
class MetalLobe:
    """Energies (..., 3) of light that a metal base sends out through the layers, per unit that reaches it."""

    first: np.ndarray
    """After one reflection on the base."""
    later: np.ndarray
    """After more of them."""


def bare_metal(cos_theta, alpha: float, kind: str, eta: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Directional albedo (..., 3) of a lossless-faceted metal without layers."""
    p = np.sqrt(1.0 - np.square(cos_theta))
    once, more, _ = _reflected(p, 0.0 * p, 1.0, alpha, kind, kind, eta, k)
    return np.sum(once, axis=-2) + more


def metal_lobe(up: Sequence[Crossing], n_base: float, p, variance, alpha: float, kind: str, eta, k, uniform) -> MetalLobe:
    """The base's lobe for beams (...) that reach it; eta, k (3,) are relative to the medium above it.

    The lobe is carried out through the layers at a few of its directions. Its later orders return along the
    directions that were reflected, mixed with uniform light the more the wider the lobe is.
    """
    widened = np.sqrt(variance * EXIT_SPREAD) / (2.0 * n_base * cosine(p, n_base))
    share, facets, p_out = _reflected(p, widened, n_base, alpha, kind, up[0].kind, eta, k)
    total_alpha = np.minimum(np.sqrt(alpha * alpha + np.square(widened)), 1.0)
    node_variance = np.square(NODE_SPREAD * 2.0 * n_base * cosine(p, n_base) * total_alpha)[..., None] * np.ones_like(p_out)
    passage = from_base(up, n_base, p_out, node_variance, np.zeros_like(p_out))
    back_d, out_d = uniform
    first = np.sum(share * passage.escaped, axis=-2) + facets * out_d
    returned = share * passage.reflected
    back = np.sum(returned, axis=-2)
    scale = np.maximum(back, 1e-12)
    out_again, back_again = (np.sum(returned * part, axis=-2) / scale for part in (passage.escaped, passage.reflected))
    roughest = max(c.alpha if c.n_own != c.n_other else 0.0 for c in up)
    kept = out_again * (1.0 - KEPT_ORDER * roughest / (roughest + KEPT_SCALE))
    back_again = back_again + out_again - kept
    stirred = (total_alpha / (total_alpha + STIR_SCALE))[..., None]
    out_again, back_again = kept + stirred * (out_d - kept), back_again + stirred * (back_d - back_again)
    albedo = np.sum(share, axis=-2) + facets
    return MetalLobe(first, (back + facets * back_d) * albedo * out_again / (1.0 - albedo * back_again))


def _reflected(p, widened, n: float, alpha: float, kind: str, kind_above: str, eta, k):
    """What a metal reflects: by one facet, per node (..., Q, 3), by more of them (..., 3), and p of the nodes (..., Q)."""
    seen, hidden, p_out, cos_om = _lobe_nodes(p, widened, n, alpha, kind, kind_above)
    fresnel = fresnel_conductor(cos_om[..., None], eta, k)
    again = np.sum(hidden[..., None] * fresnel, axis=-2)
    return seen[..., None] * fresnel, again * _later_facets(alpha, eta, k), p_out


def _later_facets(alpha: float, eta, k) -> np.ndarray:
    """Share (3,) of light that leaves a metal after it met one facet and was not let go (after Kulla and Conty 2017)."""
    mean = np.sum(MEAN_WEIGHTS[:, None] * fresnel_conductor(MEAN_COSINES[:, None], eta, k), axis=0)
    kept = BASE_LOSS * alpha * alpha / (1.0 + (1.0 + BASE_LOSS) * alpha * alpha)
    return mean * (1.0 - kept) / (1.0 - mean * kept)


def lobe_nodes() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(u, weight, cos, sin of the azimuth), each (Q,), of points of a cap; half of the azimuth is enough."""
    u, w = gauss(LOBE_RADII)
    azimuth = np.pi * (np.arange(LOBE_AZIMUTHS) + 0.5) / LOBE_AZIMUTHS
    return (
        np.repeat(u, LOBE_AZIMUTHS), np.repeat(w, LOBE_AZIMUTHS) / LOBE_AZIMUTHS,
        np.tile(np.cos(azimuth), LOBE_RADII), np.tile(np.sin(azimuth), LOBE_RADII),
    )  # fmt: skip


def _lobe_nodes(p, widened, n: float, alpha: float, kind: str, kind_above: str):
    """(seen, hidden, p, cosine on the facet), each (..., Q): directions of a metal's lobe from its visible facets.

    `seen` is the share of light that one facet lets go, `hidden` that which meets another.
    Nodes of a spherical cap (Dupuy23), then moved apart by what `widened`, the spread of the beam as an alpha, adds.
    """
    u, node_weight, turn_x, turn_y = lobe_nodes()
    slope2 = {True: u / (1.0 - u), False: -np.log1p(-u)}
    own, above = slope2[kind == GGX], slope2[kind_above == GGX]
    stretch = alpha * np.sqrt(own / slope2[True])
    apart = np.sqrt(alpha * alpha * own + np.square(widened[..., None]) * above) - alpha * np.sqrt(own)
    c, s = cosine(p, n)[..., None], np.minimum(p / n, 1.0)[..., None]
    length = np.sqrt(np.square(stretch * s) + c * c)
    ax, az = stretch * s / length, c / length
    hz = (1.0 - u) * (1.0 + az)
    sin = np.sqrt(np.maximum(1.0 - np.square(hz - az), 0.0))
    hx, hy = stretch * (sin * turn_x + ax), stretch * sin * turn_y
    length = np.sqrt(hx * hx + hy * hy + hz * hz)
    hx, hy, hz = hx / length, hy / length, hz / length
    cos_om = s * hx + c * hz
    iz = 2.0 * cos_om * hz - c
    lambda_o, lambda_i = smith_lambda(c, stretch, GGX), smith_lambda(np.maximum(iz, LEAST_COS), stretch, GGX)
    seen = np.where(iz > 0.0, (1.0 + lambda_o) / (1.0 + lambda_o + lambda_i), 0.0)
    ix, iy = 2.0 * cos_om * hx - s + 2.0 * c * apart * turn_x, 2.0 * cos_om * hy + 2.0 * c * apart * turn_y
    # the nodes know the lobe's shape, the table its energy
    energy = closure_energy(c[..., 0], alpha, kind)[..., None]
    hidden = node_weight * (1.0 - seen)
    hidden = hidden * (1.0 - energy) / np.maximum(np.sum(hidden, axis=-1, keepdims=True), 1e-9)
    seen = node_weight * seen
    seen = seen * energy / np.sum(seen, axis=-1, keepdims=True)
    return seen, hidden, n * np.minimum(np.sqrt(ix * ix + iy * iy), MOST_LOBE_SHARE), np.minimum(cos_om, 1.0)
