# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells, as plain data: for the command line, its JSON, and the window."""

from dataclasses import asdict, replace

import numpy as np

from .certainty import certainty
from .dense import evaluate_all
from .measurement import Measurement
from .metric import Metric, shape_error
from .selection import UNEXPLAINED, Selection

# Where so much of the data is off and hidden by a highlight, people are told.
_HIDDEN_SHARE = 0.05


def percent(error: float) -> str:
    """An error for people; what is below the model's accuracy is not spelled out."""
    return f"{100.0 * error:.2g} %" if error >= 1e-4 else "below .01 %"


def outcome(measurement: Measurement, selection: Selection) -> dict:
    """The stack, what was found in the data, errors on all of them, and what they determine."""
    fit = selection.best
    m = measurement
    f = evaluate_all(fit.model, fit.stack, m.wo, m.wi)[:, : m.channels]
    metric = Metric(m, fit.metric.kind)
    error = metric.error(f)
    explains = bool(error < UNEXPLAINED)
    # of data that the stack does not explain its values say nothing
    values = [v if explains else replace(v, determined=False) for v in certainty(fit)]
    share, factor = metric.hidden(f)
    return {
        "stack": fit.stack.to_dict(),
        "model": fit.model,
        "found": list(m.found),
        "pairs": len(m.f),
        "fitted_pairs": len(fit.metric.measurement.f),
        "error": error,
        "error_of_fitted_pairs": fit.error,
        "shape_error": shape_error(f, m.f, m.wi[:, 2]),
        "error_by_region": metric.bands(f),
        "explains": explains,
        "warnings": [f"{100.0 * share:.0f} % of the values, all below a tenth of the mean f cos, are off by more than a factor of two "
                     f"({factor:.2g} in the median) and hardly count beside the highlight"] if share > _HIDDEN_SHARE else [],
        "reason": selection.reason,
        "tried": [{"structure": t.structure.name, "parameters": t.count, "error": t.error} for t in selection.tried],
        "parameters": [asdict(v) for v in values],
        "not_determined": [v.name for v in values if not v.determined],
        "evaluations": int(np.sum([t.evaluations for t in selection.tried])),
    }
