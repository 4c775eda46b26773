# SPDX-License-Identifier: GPL-3.0-or-later
"""How alike the residuals of neighbours are: what tells noise from misfit."""

import numpy as np

from .metric import Metric
from .profile_likelihood import MOST_ALIKE


def likeness(metric: Metric, residual: np.ndarray) -> float:
    """Correlation of the residuals of neighbours: noise differs from pair to pair, and what no stack says is alike for pairs that are alike."""
    residual = residual.reshape(metric.target.shape)
    residual = (residual - residual.mean(axis=0))[: len(metric.neighbours)]
    neighbour = residual[metric.neighbours]
    r = float(np.sum(residual * neighbour) / max(float(np.sum(np.square(residual))), 1e-30))
    return min(max(r, 0.0), MOST_ALIKE)
