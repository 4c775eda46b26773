# SPDX-License-Identifier: GPL-3.0-or-later
"""A slab that scatters, solved for chosen directions: what it turns back and lets through, all orders.

Discrete ordinates (Stamnes88) by azimuthal modes of the Henyey-Greenstein phase function (Henyey41). What enters both sides
alike and what enters them oppositely are two problems of half a slab, each with one bounded function of the eigenvalues k:
k tanh(k tau / 2) and k coth(k tau / 2). So no optical depth is too thick, none too thin, and albedo 1 is no special case (k = 0).
It is what doubling (de Hulst; Grant69) tends to from an infinitely thin slab on the same directions, without its steps.

- The phase function is cut after `terms` Legendre moments. What a forward one has beyond them counts as not scattered (delta-M: Wiscombe77),
  and what a backward one has, as sent straight back.
- It is scaled, symmetrically in its two directions, so that what it scatters sums to 1 on the given quadrature: energy is kept to
  rounding (Grant69 renormalise likewise).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .gauss import gauss_legendre

# Of the scaling: sums are within this of 1, or the rounds are over.
_SUMS_TO, _ROUNDS = 1e-14, 200


@dataclass(frozen=True, eq=False, repr=False)
class Slab:
    """Operators (modes, N, N): a radiance g becomes `reflection` g on its own side and `transmission` g on the other.

    `passed` (N,) is the diagonal part of `transmission` that met nothing; `reflected_once` and `transmitted_once` met one event.
    """

    passed: np.ndarray
    reflection: np.ndarray
    transmission: np.ndarray
    reflected_once: np.ndarray
    transmitted_once: np.ndarray


def slab(cos_theta: np.ndarray, weights: np.ndarray, tau: float, albedo: float, g: float, modes: int, terms: int) -> Slab:
    """That of a medium of optical depth `tau` for directions of cosines (N,).

    weights (N,): of a quadrature over the cosines from 0 to 1. Azimuth is that of travel. Operators_ij / (mu_j w_j) are symmetric.
    """
    tau, albedo = without_peak(tau, albedo, g, terms)
    even, odd = _phase(tuple(cos_theta.tolist()), tuple(weights.tolist()), g, modes, terms)
    both, opposite = _admittances(cos_theta, albedo, even, odd, 0.5 * tau)
    identity = np.eye(len(cos_theta))
    both, opposite = np.linalg.inv(identity + both), np.linalg.inv(identity + opposite)
    to_radiance = np.sqrt(cos_theta * weights)
    scale = to_radiance / to_radiance[:, None]
    passed = np.exp(-tau / cos_theta)
    once = 0.5 * albedo * (cos_theta[:, None] * cos_theta) * scale
    back, on = single_scattering(cos_theta[:, None], cos_theta, tau)
    return Slab(passed, (both + opposite - identity) * scale, (both - opposite) * scale, (even - odd) * (back * once), (even + odd) * (on * once))


def single_scattering(cos_o, cos_i, tau):
    """(back, on): f in 1/sr of one event, on the own side and on the other, over albedo times phase function (Chandrasekhar60)."""
    out, into = np.exp(-tau / cos_o), np.exp(-tau / cos_i)
    gap = cos_o - cos_i
    alike = np.abs(gap) < 1e-6 * cos_o
    on = np.where(alike, tau / (cos_o * cos_i) * into, (out - into) / np.where(alike, 1.0, gap))
    return -np.expm1(-tau / cos_o - tau / cos_i) / (cos_o + cos_i), on


def henyey_greenstein(cos, g: float):
    """The phase function (...) in 1/sr at cosines of the scattering angle (Henyey41)."""
    return (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * cos) ** 1.5)


def without_peak(tau, albedo, g: float, terms: int):
    """(tau, albedo) of the medium in which what a cut phase function cannot hold goes on as if nothing had happened."""
    cut = peak(g, terms)
    return tau * (1.0 - albedo * cut), albedo * (1.0 - cut) / (1.0 - albedo * cut)


def peak(g: float, terms: int) -> float:
    """Share of a forward phase function that its first moments do not hold."""
    return max(g, 0.0) ** terms


def _back_peak(g: float, terms: int) -> float:
    """The same of a backward one."""
    return max(-g, 0.0) ** terms


def half_space_albedo(albedo: np.ndarray, g: float, nodes: int = 24) -> np.ndarray:
    """Spherical albedo (...) of an infinitely deep medium of these single-scattering albedos, without interface, good to 1e-4.

    Its light is uniform. Isotropic: the H functions of Chandrasekhar60 give the same (tests/reference_py/test_slab.py).
    """
    u, gauss = gauss_legendre(nodes)
    psi = 0.25 * np.pi * (u + 1.0)
    cos_theta, weights = np.cos(psi), 0.25 * np.pi * np.sin(psi) * gauss
    terms = 2 * nodes
    even, odd = _phase(tuple(cos_theta.tolist()), tuple(weights.tolist()), g, 1, terms)
    flux = cos_theta * weights / np.sum(cos_theta * weights)
    root = np.sqrt(flux)
    result = []
    for own in np.ravel(albedo):
        admittance = _admittances(cos_theta, without_peak(np.inf, own, g, terms)[1], even, odd, np.inf)[0][0]
        result.append(2.0 * root @ np.linalg.solve(np.eye(nodes) + admittance, root) - 1.0)
    return np.reshape(result, np.shape(albedo))


def _admittances(cos_theta, albedo: float, even, odd, half_tau: float) -> tuple[np.ndarray, np.ndarray]:
    """(modes, N, N) each: D = G S at the top, where S and D are the sum and difference of what enters and what leaves (scaled by
    sqrt(mu w)), for light that enters both sides alike, and oppositely."""
    inverse = np.diag(1.0 / cos_theta)
    lower = np.linalg.cholesky(inverse - albedo * odd)
    squares, vectors = np.linalg.eigh(np.swapaxes(lower, -1, -2) @ (inverse - albedo * even) @ lower)
    # the smallest is rounding of the largest where little is absorbed; as a quotient it is not
    slowest = (lower @ vectors[..., :1]) / np.sqrt(cos_theta)[:, None]
    kept = albedo * even * np.sqrt(cos_theta[:, None] * cos_theta)
    squares[..., 0] = np.sum(slowest * (slowest - kept @ slowest), axis=(-2, -1))
    k = np.sqrt(np.maximum(squares, 0.0))
    shapes = np.linalg.solve(np.swapaxes(lower, -1, -2), vectors)
    if np.isinf(half_tau):
        tanh, coth = k, k
    else:
        tanh = k * np.tanh(k * half_tau)
        # k coth(k h) tends to 1 / h where k does to 0
        coth = np.where(k * half_tau > 1e-6, k / np.tanh(np.maximum(k * half_tau, 1e-6)), 1.0 / max(half_tau, 1e-300))
    across = np.swapaxes(shapes, -1, -2)
    return (shapes * tanh[:, None]) @ across, (shapes * coth[:, None]) @ across


# the channels of a medium share it
@lru_cache(maxsize=4)
def _phase(cosines: tuple[float, ...], weights_of: tuple[float, ...], g: float, modes: int, terms: int) -> tuple[np.ndarray, np.ndarray]:
    """(modes, N, N) each, not to be written to: what the phase function sends forward plus backward, and forward minus backward, times
    sqrt(w w' / (mu mu')), the first with sums of 1 over w."""
    cos_theta, weights, count = np.array(cosines), np.array(weights_of), len(cosines)
    even, odd = np.zeros((2, modes, count, count))
    degrees, cut, back = np.arange(terms), peak(g, terms), _back_peak(g, terms)
    moments = (g**degrees - cut - back * (-1.0) ** degrees) / (1.0 - cut - back)
    for m in range(min(modes, terms)):
        functions = _associated_legendre(cos_theta, m, terms)
        weighted = functions * moments[m:, None]
        even[m] = 2.0 * functions[::2].T @ weighted[::2]
        odd[m] = 2.0 * functions[1::2].T @ weighted[1::2]
    scale = np.ones(count)
    for _ in range(_ROUNDS):
        sums = scale * (even[0] @ (weights * scale))
        if np.max(np.abs(sums - 1.0)) < _SUMS_TO:
            break
        scale = scale / np.sqrt(sums)
    scale = scale * np.sqrt(weights / cos_theta)
    pair = (1.0 - back) * scale[:, None] * scale
    straight_back = back * np.diag(1.0 / cos_theta) * ((-1.0) ** np.arange(modes))[:, None, None]
    return even * pair + straight_back, odd * pair - straight_back


def _associated_legendre(x: np.ndarray, m: int, terms: int) -> np.ndarray:
    """(terms - m, N): the functions of degree m to terms - 1, of square integral 1 over -1 to 1."""
    functions = np.zeros((max(terms - m, 1), len(x)))
    functions[0] = np.sqrt(0.5 * np.prod(1.0 + 0.5 / np.arange(1, m + 1))) * np.sqrt(1.0 - x * x) ** m
    before = np.zeros_like(x)
    for row, degree in enumerate(range(m + 1, terms), 1):
        step = np.sqrt((4.0 * degree**2 - 1.0) / (degree**2 - m**2))
        back = np.sqrt(((degree - 1.0) ** 2 - m**2) / (4.0 * (degree - 1.0) ** 2 - 1.0))
        before, functions[row] = functions[row - 1], step * (x * functions[row - 1] - back * before)
    return functions
