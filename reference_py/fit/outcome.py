# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells, as plain data: for the command line, its JSON, and the window."""

from dataclasses import asdict, replace

import numpy as np

from ..errors import Sentence, joined
from ..material.stack import Stack
from .certainty import OF_VALUE, certainty, noise_and_misfit
from .dense import evaluate_all
from .layer_count import UNEXPLAINED, Selection
from .metric import Metric, rms, shape_error
from .readers.measurement import Measurement

# Where so much of the data is off and hidden by a highlight, people are warned.
_HIDDEN_SHARE = 0.05


def outcome(measurement: Measurement, selection: Selection) -> dict:
    """The stack, what was found in the data, errors on all of them, and what they determine."""
    fit = selection.best
    m = measurement
    f = evaluate_all(fit.model, fit.stack, m.wo, m.wi)[:, : m.channels]
    metric = Metric(m, fit.metric.kind)
    residual = metric.residual(f)
    error = rms(residual)
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
        "error_by_region": metric.bands(residual),
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


def lines(result: dict) -> list[Sentence]:
    """All of an outcome for people."""
    stack = Stack.from_dict(result["stack"])
    surfaces = ", ".join(e["distribution"] for e in (*stack.layers, stack.base) if "distribution" in e)
    text = [
        Sentence(
            "{name}{surfaces}, {count} parameters, model {model}",
            name=stack.name,
            surfaces=Sentence(" ({surfaces} from the top)", surfaces=surfaces) if surfaces else "",
            count=len(result["parameters"]),
            model=result["model"],
        ),
        Sentence(
            "error {error:.2f} % over {pairs} pairs of directions (RMS of log f cos), {shape:.2f} % of the reflected light (L1)",
            error=100.0 * result["error"],
            pairs=result["pairs"],
            shape=100.0 * result["shape_error"],
        ),
        Sentence(
            "of the fitted pairs' error {noise:.2f} % differ from pair to pair, as noise does, and {misfit:.2f} % are alike "
            "among neighbours: what such a stack cannot say (their squares add up)",
            noise=100.0 * result["noise"],
            misfit=100.0 * result["misfit"],
        ),
        Sentence("by region: {regions}", regions=joined(_of_region(*item) for item in result["error_by_region"].items())),
        *(_of_structure(row, result["fitted_pairs"]) for row in result["tried"]),
        result["reason"],
        *(_of_value(value) for value in result["parameters"]),
    ]
    if result["not_determined"]:
        text.append(
            Sentence(
                "not determined: may be off by more than {percent:g} %, as its standard error or fits from other starts say",
                percent=100.0 * OF_VALUE,
            )
        )
    return text


def _of_region(region: Sentence, error: float) -> Sentence:
    return Sentence("{region} {error:.1f} %", region=region, error=100.0 * error)


def _of_structure(row: dict, pairs: int) -> Sentence:
    return Sentence(
        "  tried {structure:24} {parameters:3d} parameters   error {error:.2f} % of the {pairs} fitted pairs",
        structure=row["structure"],
        parameters=row["parameters"],
        error=100.0 * row["error"],
        pairs=pairs,
    )


def _of_value(value: dict) -> Sentence:
    return Sentence(
        "  {name:28} {value:9.4f} +- {spread:.4f}{certainty}{bound}",
        name=value["name"],
        value=value["value"],
        spread=value["standard_error"],
        certainty="" if value["determined"] else Sentence("   not determined by the data"),
        bound=Sentence("   at its bound") if value["at_bound"] else "",
    )
