# SPDX-License-Identifier: GPL-3.0-or-later
"""How well data determine parameters: standard errors from the Jacobian, and the names of those that are not determined."""

from dataclasses import dataclass

import numpy as np

from .fitting import Fit
from .measurement import half_angles

# Residuals are never believed to be smaller than this: the accuracy of `adding`'s f.
MODEL_ERROR = 0.005
# A value is not determined when its standard error exceeds this part of it.
_OF_VALUE = 0.05
_AT_BOUND, _MOST_ALIKE, _MOST_PAIRS = 1e-4, 0.95, 1500


@dataclass(frozen=True)
class Value:
    """One fitted number in the schema's units."""

    name: str
    value: float
    standard_error: float
    determined: bool
    at_bound: bool


def independent_pairs(fit: Fit) -> float:
    """How many independent pairs the residuals are worth: n (1 - r) / (1 + r), r being the correlation of neighbours.

    Noise differs from pair to pair; what a model cannot say is alike for pairs that are alike, and counts less often.
    """
    m = fit.metric.measurement
    theta_h, theta_d, phi_d = half_angles(m.wi, m.wo)
    around = 0.5 * theta_h * np.exp(2.0j * phi_d)
    place = np.stack([np.sqrt(theta_h), theta_d, around.real, around.imag], axis=-1)
    residual = fit.residual.reshape(len(place), -1)
    residual = residual - residual.mean(axis=0)
    if len(place) > _MOST_PAIRS:
        place, residual = place[:_MOST_PAIRS], residual[:_MOST_PAIRS]
    distance = np.sum(np.square(place[:, None] - place), axis=-1)
    np.fill_diagonal(distance, np.inf)
    neighbour = residual[np.argmin(distance, axis=1)]
    r = float(np.sum(residual * neighbour) / max(float(np.sum(np.square(residual))), 1e-30))
    r = min(max(r, 0.0), _MOST_ALIKE)
    return len(m.f) * (1.0 - r) / (1.0 + r)


def certainty(fit: Fit) -> list[Value]:
    """Every parameter's value and standard error, of as many independent residuals as those found are worth."""
    p = fit.parameters
    rows, pairs = len(fit.residual), len(fit.metric.measurement.f)
    alike = pairs / independent_pairs(fit)
    deviation = np.sqrt(alike * rows / max(rows - p.size, 1)) * fit.error
    # the model's own error is systematic: as alike as any
    deviation = max(deviation, MODEL_ERROR * np.sqrt((1.0 + _MOST_ALIKE) / (1.0 - _MOST_ALIKE)))
    _, singular, directions = np.linalg.svd(fit.jacobian, full_matrices=False)
    # what moves nothing by a rounding error is not determined at all
    singular = np.maximum(singular, 1e-9 * max(float(singular[0]), 1e-30))
    error = deviation * np.sqrt(np.sum(np.square(directions / singular[:, None]), axis=0))
    values, widths = p.values(fit.x), p.ranges()
    curved = np.repeat([g.is_color for g in p.groups], [len(g.index) for g in p.groups])
    spread = np.minimum(p.slopes(fit.x) * error + np.where(curved, widths * np.square(error), 0.0), widths)
    bound = (fit.x <= _AT_BOUND) | (fit.x >= 1.0 - _AT_BOUND)
    known = spread <= _OF_VALUE * np.abs(values)
    return [Value(*row) for row in zip(p.names, values.tolist(), spread.tolist(), known.tolist(), bound.tolist())]
