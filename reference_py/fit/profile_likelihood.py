# SPDX-License-Identifier: GPL-3.0-or-later
"""Profile likelihood, fits far from the one that was found: how far values may move, and what the others do if one is pinned.

Metals have them: one and the same color towards grazing comes from two edge colors, beside different tints above.
"""

from collections.abc import Sequence

import numpy as np

from .forward import MODEL_ERROR, Forward
from .solve import Solution, search, side_by_side

# What is as alike as this counts as (1 + r) / (1 - r) times fewer residuals; the model's own error is as alike as any.
MOST_ALIKE = 0.95
COHERENT_ERROR = MODEL_ERROR * np.sqrt((1.0 + MOST_ALIKE) / (1.0 - MOST_ALIKE))
# A coordinate that may move so far is weakly determined.
_WEAK, _STEPS, _TOLERANCE = 0.15, 8, 1e-4


def straight(jacobian: np.ndarray, deviation: float = COHERENT_ERROR) -> np.ndarray:
    """(p,) standard errors of coordinates by a Jacobian (m, p) and the deviation of residuals."""
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    # what moves nothing by a rounding error is not determined at all
    singular = np.maximum(singular, 1e-9 * max(float(singular[0]), 1e-30))
    return deviation * np.sqrt(np.sum(np.square(directions / singular[:, None]), axis=0))


def weakly_determined(errors: np.ndarray) -> np.ndarray:
    """(k,) the coordinates that may move far, of standard errors (p,)."""
    return np.flatnonzero(errors > _WEAK)


def pinned(coarse: Forward, x: np.ndarray, pins: Sequence[tuple[np.ndarray, float]]) -> list[Solution]:
    """For each pin the other values fitted again, from x (p,), while its coordinates (k,) are pinned at its place.

    `coarse` is the stand-in plus its discrepancy at x: its own curves reach farther than the model's derivatives at one point.
    """
    bounds = [(np.zeros(len(x)), np.ones(len(x))) for _ in pins]
    for (low, high), (which, place) in zip(bounds, pins):
        low[which] = high[which] = place
    return side_by_side(coarse.answers, [search(x, low, high, _STEPS, _TOLERANCE) for low, high in bounds])
