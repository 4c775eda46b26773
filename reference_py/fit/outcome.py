# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells, as plain data: for the command line, its JSON, and the window."""

from dataclasses import asdict

import numpy as np

from .certainty import certainty
from .dense import evaluate_all
from .measurement import Measurement
from .metric import Metric, shape_error
from .selection import UNEXPLAINED, Selection


def outcome(measurement: Measurement, selection: Selection) -> dict:
    """The stack, what was found in the data, errors on all of them, and what they determine."""
    fit = selection.best
    m = measurement
    f = evaluate_all(fit.model, fit.stack, m.wo, m.wi)[:, : m.channels]
    metric = Metric(m, fit.metric.kind)
    values = certainty(fit)
    return {
        "stack": fit.stack.to_dict(),
        "model": fit.model,
        "found": list(m.found),
        "pairs": len(m.f),
        "fitted_pairs": len(fit.metric.measurement.f),
        "error": metric.error(f),
        "error_of_fitted_pairs": fit.error,
        "shape_error": shape_error(f, m.f, m.wi[:, 2]),
        "error_by_region": metric.bands(f),
        "explains": bool(metric.error(f) < UNEXPLAINED),
        "reason": selection.reason,
        "tried": [{"structure": t.structure.name, "parameters": t.count, "error": t.error} for t in selection.tried],
        "parameters": [asdict(v) for v in values],
        "not_determined": [v.name for v in values if not v.determined],
        "evaluations": int(np.sum([t.evaluations for t in selection.tried])),
    }
