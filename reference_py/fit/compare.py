# SPDX-License-Identifier: GPL-3.0-or-later
"""Every model on the same data and metric: error against count of parameters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..registry import make_model
from .baseline_fits import BASELINE_MODELS, fit_baseline
from .fitting import Fit, Progress, fit_structure
from .forward import evaluate
from .metric import Metric, shape_error
from .readers.measurement import Measurement, subsample

JUDGED = 3000
Evaluator = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""f (n, c) of wi (n, 3) and wo (n, 3)."""


@dataclass(frozen=True)
class Row:
    """`error` is that of the metric, `shape` the cosine-weighted L1, both over pairs that were not all fitted."""

    name: str
    parameters: int
    error: float
    shape: float


def compare(measurement: Measurement, fit: Fit, seed: int = 0, progress: Progress | None = None) -> tuple[list[Row], dict[str, Evaluator]]:
    """Rows, and the fitted models by name. Ours have the structure of `fit`; `baked` is its stack as Cycles renders it."""
    judged = Metric(subsample(measurement, JUDGED, np.random.default_rng(seed + 1)), fit.metric.kind)
    done = progress or (lambda share: None)
    models: dict[str, tuple[int, Evaluator]] = {}
    for i, baseline in enumerate(BASELINE_MODELS):
        found = fit_baseline(baseline, fit.metric, seed)
        models[baseline.label] = found.count, found.f
        done((i + 1) / (len(BASELINE_MODELS) + 3))
    channels = measurement.channels
    for name in ("weidlich_wilkie", "adding"):
        ours = fit if fit.model == name else fit_structure(measurement, fit.structure, name, len(fit.metric.measurement.f), seed=seed)
        models[f"{name}, {ours.structure.name}"] = ours.count, _of_stack(name, {}, ours.stack, channels)
        if name == "adding":
            models["baked, as Cycles renders it"] = ours.count, _of_stack("closure_model", {"method": "baked"}, ours.stack, channels)
    done(1.0)
    m = judged.measurement
    rows = []
    for name, (count, evaluator) in models.items():
        f = evaluator(m.wi, m.wo)
        rows.append(Row(name, count, judged.error(f), shape_error(f, m.f, m.wi[:, 2])))
    return rows, {name: evaluator for name, (_, evaluator) in models.items()}


def _of_stack(model: str, options: dict, stack, channels: int) -> Evaluator:
    made = make_model(model, stack, **options)
    return lambda wi, wo: made.f(wo, wi)[:, :channels]


def of_fit(fit: Fit) -> Evaluator:
    """The fitted stack's model."""
    return lambda wi, wo: evaluate(fit.model, {}, fit.stack, wo, wi, fit.metric.measurement.channels)
