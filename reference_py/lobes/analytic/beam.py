# SPDX-License-Identifier: GPL-3.0-or-later
"""A beam of light through the layers: adding of scalars over interfaces.

A beam has a transverse momentum p = n sin(theta), which smooth interfaces keep, and a variance of it. A facet that is
inclined by a slope m changes p by m times the change of the momentum along the normal: (n2 c2 - n1 c1) m when it
refracts, 2 n1 c1 m when it reflects. So variances of p add without Jacobians, all the way out, and give the alpha of
the lobe that leaves: sqrt(variance) / (2 cos_o). Belcour 2018 ("Efficient Rendering of Layered Materials using an Atomic
Decomposition with Statistical Operators") adds variances of slopes instead, which blurs too much at rough tops.

Energies: an interface reflects R of a beam and transmits 1 - R, both from tables, so nothing is lost and a white
stack is white. The constants are in `calibration.py`, fitted to `models.adding`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...optics.fresnel import fresnel_dielectric
from ...optics.microfacet import BECKMANN, GGX
from .calibration import (
    BACK_SPREAD,
    LEAN_BECKMANN,
    LEAN_GGX,
    LEAST_COS2,
    LOBE_SPREAD,
    MOST_SHARE,
    SPREAD_GRAZING,
    SPREAD_HALF,
    SPREAD_INCIDENCE,
    SPREAD_LIMIT,
    TAU_SHARE,
    TAU_SPREAD,
    TRAPPED_COS,
    TRAPPED_SPREAD,
)
from .interface_tables import diffuse_reflectance, reflectance, side


@dataclass(frozen=True, eq=False, repr=False)
class Crossing:
    """One interface in the order of travel and the medium behind it; `tau` (3,) per perpendicular crossing.

    Of many stacks at once the numbers are (B, 1), `tau` is (B, 1, 3), and all of them refract alike (`interface_tables.side`).
    """

    n_own: float | np.ndarray
    n_other: float | np.ndarray
    alpha: float | np.ndarray
    distribution: str
    tau: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Passage:
    """What becomes of a beam; energies (..., 3) per unit of energy that arrives."""

    transmitted: np.ndarray
    first: np.ndarray
    """Reflected by the first interface."""
    inner: np.ndarray
    """Reflected by all others."""
    inner_variance: np.ndarray
    """(...) variance of p of `inner` where it leaves, weighted by energy."""
    p: np.ndarray
    variance: np.ndarray
    """p and its variance (...) of what is transmitted."""


def cosine(p, n) -> np.ndarray:
    """Cosine of a beam in a medium of index n; a floor keeps trapped ones finite."""
    return np.sqrt(np.maximum(1.0 - np.square(p / n), 0.0) + LEAST_COS2)


def widened_reflectance(cos_theta, variance, n_own, eta, alpha, distribution: str) -> np.ndarray:
    """Reflectance (...) of an interface for a beam: that of a rougher interface, towards that of uniform light when wide."""
    if side(eta) == 0:
        return np.zeros(np.shape(cos_theta))
    spread = SPREAD_INCIDENCE * variance / np.square(n_own * cos_theta)
    wide = np.square(spread / (spread + SPREAD_HALF))
    alpha_wide = np.minimum(np.sqrt(alpha * alpha + spread / (1.0 + spread / SPREAD_LIMIT)), 1.0)
    narrow = reflectance(cos_theta, alpha_wide, eta, distribution)
    return narrow + wide * (diffuse_reflectance(alpha, eta, distribution) - narrow)


def attenuation(tau: np.ndarray, p, variance, n) -> np.ndarray:
    """Share (..., 3) that one crossing of a medium leaves of a beam: the mean of its two sides."""
    step = TAU_SPREAD * np.sqrt(variance)
    low = cosine(np.abs(p - step), n)[..., None]
    high = cosine(np.minimum(p + step, np.maximum(p, TAU_SHARE * n)), n)[..., None]
    return 0.5 * (np.exp(-tau / low) + np.exp(-tau / high))


def refracted(p, variance, crossing: Crossing):
    """p and variance of a beam after it is refracted by a rough interface; seen facets lean towards the beam."""
    n1, n2, alpha = crossing.n_own, crossing.n_other, crossing.alpha
    c1, c2 = cosine(p, n1), cosine(p, n2)
    turn = (n2 * c2 - n1 * c1) * alpha
    tangent = alpha * np.sqrt(np.maximum(1.0 / np.square(c1) - 1.0, 0.0))
    a, b, c = {GGX: LEAN_GGX, BECKMANN: LEAN_BECKMANN}[crossing.distribution]
    lean = turn * a * tangent / (1.0 + b * alpha + c * tangent * (alpha if crossing.distribution == GGX else 1.0))
    variance = variance + LOBE_SPREAD * np.square(turn / (1.0 + SPREAD_GRAZING * tangent))
    p = np.where(np.asarray(alpha) > 0.0, np.minimum(p, MOST_SHARE * n2), p)
    room = np.maximum(MOST_SHARE * n2 - p, 1e-3)
    p = np.where(lean > 0.0, p + room * (1.0 - np.exp(-np.maximum(lean, 0.0) / room)), np.maximum(p + lean, 0.0))
    return np.minimum(p, 0.9999 * n2), variance


def through(crossings: Sequence[Crossing], p: np.ndarray, variance: np.ndarray, seen_alpha: np.ndarray | None = None) -> Passage:
    """Send beams (...) through interfaces, all orders of reflection between them; `seen_alpha` (...) is what they see of the first.

    What an interface turns back must pass those before it: their reflectance from behind is evaluated for a beam
    widened by that reflection, its totally reflected part for one beyond the critical angle.
    """
    shape = np.shape(p) + (3,)
    transmitted, back, out = np.ones(shape), np.zeros(shape), np.ones(shape)
    first, inner, spread = np.zeros(shape), np.zeros(shape), np.zeros(np.shape(p))
    before = None
    for index, crossing in enumerate(crossings):
        n1, eta = crossing.n_own, crossing.n_other / crossing.n_own
        if side(eta):
            c1 = cosine(p, n1)
            seen = crossing if index or seen_alpha is None else replace(crossing, alpha=seen_alpha)
            r12 = widened_reflectance(c1, variance, n1, eta, seen.alpha, crossing.distribution)
            if before is not None:
                returned = _returned_reflectance(before[0], crossing, c1, variance, r12)[..., None]
                back, out = _close(returned, *before[1:])
            r12 = r12[..., None]
            trips = 1.0 / (1.0 - back * r12)
            lobe = transmitted * r12 * out * trips
            if index == 0:
                first = lobe
            else:
                inner = inner + lobe
                spread = spread + np.mean(lobe, axis=-1) * (2.0 * variance + np.square(2.0 * n1 * c1 * crossing.alpha))
            transmitted = transmitted * (1.0 - r12) * trips
            p, variance = refracted(p, variance, seen)
            before = [crossing, (1.0 - r12) * trips * back, out * trips, np.ones(shape)]
        if np.any(crossing.tau):
            left = attenuation(crossing.tau, p, variance, crossing.n_other)
            transmitted = transmitted * left
            if before is None:
                out = out * left
            else:
                before[3] = before[3] * left
    return Passage(transmitted, first, inner, spread / np.maximum(np.mean(inner, axis=-1), 1e-12), p, variance)


def _close(r21, around, out, left):
    """(reflectance, transmittance) from behind of all so far, once the light that comes back is known."""
    return (r21 + (1.0 - r21) * around) * left * left, (1.0 - r21) * out * left


def _returned_reflectance(before: Crossing, crossing: Crossing, c1, variance, r12) -> np.ndarray:
    """Reflectance (...) from behind of the interface `before` for what `crossing` reflects."""
    n1, eta = crossing.n_own, crossing.n_other / crossing.n_own
    variance = variance + BACK_SPREAD * np.square(2.0 * n1 * c1 * crossing.alpha)
    eta_back = before.n_own / before.n_other
    r21 = widened_reflectance(c1, variance, n1, eta_back, before.alpha, before.distribution)
    if side(eta) < 0:
        total = np.clip((r12 - fresnel_dielectric(c1, eta)) / np.maximum(r12, 1e-9), 0.0, 1.0)
        trapped_cos = np.broadcast_to(TRAPPED_COS * np.sqrt(1.0 - eta * eta), np.shape(c1))
        trapped = widened_reflectance(trapped_cos, TRAPPED_SPREAD * variance, n1, eta_back, before.alpha, before.distribution)
        r21 = r21 + total * np.maximum(trapped - r21, 0.0)
    return r21
