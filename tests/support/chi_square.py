# SPDX-License-Identifier: GPL-3.0-or-later
"""Pearson's chi-square test of sampled directions against the density they claim."""

from collections.abc import Callable

import numpy as np
from scipy.stats import chi2

_MIN_EXPECTED = 5.0


def chi_square_p_value(
    samples: np.ndarray,
    density: Callable[[np.ndarray], np.ndarray],
    hemisphere: int = 1,
    bins: tuple[int, int] = (16, 24),
    drawn: int | None = None,
) -> float:
    """Probability that `samples` (n, 3) with z of the sign `hemisphere` deviate as much if `density` (1/sr) is right.

    All other samples are one more bin, so the density's integral is tested too; `drawn` is the number of samples
    with those that the sampler lost. The bins follow the quantiles in z of every tenth sample,
    which is left out of the count, so that narrow lobes need no more bins than wide ones.
    """
    drawn = len(samples) if drawn is None else drawn
    inside = samples[samples[:, 2] * hemisphere > 0.0]
    pilot = np.zeros(len(inside), bool)
    pilot[::10] = True
    drawn -= int(pilot.sum() / max(len(inside), 1) * drawn)
    inside, pilot = inside[~pilot], inside[pilot]
    z_edges = np.quantile(pilot[:, 2] * hemisphere, np.linspace(0.0, 1.0, bins[0] + 1))
    z_edges[-1] = 1.0
    phi_edges = np.linspace(-np.pi, np.pi, bins[1] + 1)
    phi = np.arctan2(inside[:, 1], inside[:, 0])
    observed = np.histogram2d(inside[:, 2] * hemisphere, phi, (z_edges, phi_edges))[0].ravel()
    expected = drawn * _integrals(density, z_edges, phi_edges, hemisphere).ravel()
    observed = np.append(observed, drawn - observed.sum())
    expected = np.append(expected, max(drawn - expected.sum(), 0.0))
    rare = expected < _MIN_EXPECTED
    observed = np.append(observed[~rare], observed[rare].sum())
    expected = np.append(expected[~rare], expected[rare].sum())
    if expected[-1] < _MIN_EXPECTED:
        largest = int(np.argmax(expected))
        observed[largest] += observed[-1]
        expected[largest] += expected[-1]
        observed, expected = observed[:-1], expected[:-1]
    statistic = float(np.sum(np.square(observed - expected) / expected))
    p_value = float(chi2.sf(statistic, len(expected) - 1))
    print(f"chi-square {statistic:.1f} with {len(expected) - 1} degrees of freedom: p = {p_value:.3g}")
    return p_value


def _integrals(density, z_edges, phi_edges, hemisphere, points: int = 6) -> np.ndarray:
    """Gauss-Legendre integral of the density over every bin, in z and phi; the wide first row in eight parts."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    result = np.zeros((len(z_edges) - 1, len(phi_edges) - 1))
    for row, (low, high) in enumerate(zip(z_edges[:-1], z_edges[1:])):
        cuts = np.linspace(low, high, 9 if row == 0 else 2)
        for a, b in zip(cuts[:-1], cuts[1:]):
            z = 0.5 * (a + b) + 0.5 * (b - a) * nodes
            half_phi = 0.5 * np.diff(phi_edges)[:, None]
            phi = phi_edges[:-1, None] + half_phi * (1.0 + nodes)
            zz, pp = np.broadcast_arrays(z[:, None, None], phi[None])
            sin = np.sqrt(1.0 - zz * zz)
            w = np.stack([sin * np.cos(pp), sin * np.sin(pp), hemisphere * zz], axis=-1)
            values = density(w.reshape(-1, 3)).reshape(zz.shape)
            result[row] += 0.5 * (b - a) * np.einsum("i,ijk,k,j->j", weights, values, weights, half_phi[:, 0])
    return result
