# SPDX-License-Identifier: GPL-3.0-or-later
"""How alike the residuals of neighbours are: what tells noise from misfit."""

import numpy as np

from .profile_likelihood import MOST_ALIKE
from .readers.measurement import Measurement, half_angles

_MOST_PAIRS = 1500


def likeness(m: Measurement, residual: np.ndarray) -> float:
    """Correlation of the residuals of neighbours: noise differs from pair to pair, and what no stack says is alike for pairs that are alike."""
    theta_h, theta_d, phi_d = half_angles(m.wi, m.wo)
    around = 0.5 * theta_h * np.exp(2.0j * phi_d)
    place = np.stack([np.sqrt(theta_h), theta_d, around.real, around.imag], axis=-1)
    residual = residual.reshape(len(place), -1)
    residual = residual - residual.mean(axis=0)
    if len(place) > _MOST_PAIRS:
        place, residual = place[:_MOST_PAIRS], residual[:_MOST_PAIRS]
    distance = np.sum(np.square(place[:, None] - place), axis=-1)
    np.fill_diagonal(distance, np.inf)
    neighbour = residual[np.argmin(distance, axis=1)]
    r = float(np.sum(residual * neighbour) / max(float(np.sum(np.square(residual))), 1e-30))
    return min(max(r, 0.0), MOST_ALIKE)
