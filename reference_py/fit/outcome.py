# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells, as plain data: for the command line, its JSON, and the window."""

from dataclasses import asdict, replace

import numpy as np

from ..errors import Sentence
from ..material.stack import Stack
from .certainty import OF_VALUE, certainty, noise_and_misfit
from .dense import evaluate_all
from .layer_count import UNEXPLAINED, Selection
from .metric import Metric, shape_error
from .readers.measurement import Measurement

# Where so much of the data is off and hidden by a highlight, people are warned.
_HIDDEN_SHARE = 0.05


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
    noise, misfit = noise_and_misfit(fit)
    return {
        "stack": fit.stack.to_dict(),
        "model": fit.model,
        "found": list(m.found),
        "pairs": len(m.f),
        "fitted_pairs": len(fit.metric.measurement.f),
        "error": error,
        "error_of_fitted_pairs": fit.error,
        "noise": noise,
        "misfit": misfit,
        "shape_error": shape_error(f, m.f, m.wi[:, 2]),
        "error_by_region": metric.bands(f),
        "explains": explains,
        "warnings": _warnings(metric, f),
        "reason": selection.reason,
        "tried": [{"structure": t.structure.name, "parameters": t.count, "error": t.error} for t in selection.tried],
        "parameters": [asdict(v) for v in values],
        "not_determined": [v.name for v in values if not v.determined],
        "evaluations": int(np.sum([t.evaluations for t in selection.tried])),
    }


def _warnings(metric: Metric, f: np.ndarray) -> list[Sentence]:
    share, factor = metric.hidden(f)
    if share <= _HIDDEN_SHARE:
        return []
    return [
        Sentence(
            "{share:.0f} % of the values are off by more than a factor of two ({factor:.2g} in the median) "
            "but hardly count, as they are dim beside the highlight",
            share=100.0 * share,
            factor=factor,
        )
    ]


def lines(result: dict) -> list[str]:
    """All of an outcome for people."""
    stack = Stack.from_dict(result["stack"])
    surfaces = [e["distribution"] for e in (*stack.layers, stack.base) if "distribution" in e]
    named = f" ({', '.join(surfaces)} from the top)" if surfaces else ""
    text = [
        f"{stack.name}{named}, {len(result['parameters'])} parameters, model {result['model']}",
        f"error {100.0 * result['error']:.2f} % over {result['pairs']} pairs of directions (RMS of log f cos), "
        f"{100.0 * result['shape_error']:.2f} % of the reflected light (L1)",
        f"of the fitted pairs' error {100.0 * result['noise']:.2f} % differ from pair to pair, as noise does, and {100.0 * result['misfit']:.2f} % are alike "
        "among neighbours: what such a stack cannot say (their squares add up)",
        "by region: " + ", ".join(f"{name} {100.0 * error:.1f} %" for name, error in result["error_by_region"].items()),
    ]
    for row in result["tried"]:
        text.append(
            f"  tried {row['structure']:24} {row['parameters']:3d} parameters   error {100.0 * row['error']:.2f} % of the {result['fitted_pairs']} fitted pairs"
        )
    text.append(result["reason"])
    for value in result["parameters"]:
        note = "" if value["determined"] else "   not determined by the data"
        note += "   at its bound" if value["at_bound"] else ""
        text.append(f"  {value['name']:28} {value['value']:9.4f} +- {value['standard_error']:.4f}{note}")
    if result["not_determined"]:
        text.append(f"not determined: may be off by more than {100.0 * OF_VALUE:g} %, as its standard error or fits from other starts say")
    return text
