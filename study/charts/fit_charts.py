# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart fit`: how well stacks are found from measurements: random ones, and a blue paint against other models."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.fit.baseline_fits import BASELINE_MODELS, fit_baseline
from ...reference_py.fit.compare import compare
from ...reference_py.fit.fit_picture import picture
from ...reference_py.fit.fitting import corrected, fit_structure, nearest, rough_fits, subsampled
from ...reference_py.fit.forward import evaluate
from ...reference_py.fit.layer_count import select
from ...reference_py.fit.metric import METRICS, Metric, shape_error
from ...reference_py.fit.parameters import Structure
from ...reference_py.fit.readers.sampled import sample_model
from ...reference_py.material import presets
from ...reference_py.models.baselines.lafortune import lobes as lafortune_lobes
from ...reference_py.models.weidlich_wilkie import WeidlichWilkie
from ..fit_bound import least_error
from ..fit_recovery import data_of, judged, random_stack, random_structure, recovery
from ..paper.figure9 import PRINTED, blue_paint
from ..stamp import stamp
from ..tables import Report, read_heading, read_rows, write_table
from .output import print_table, pyplot, save_picture

# Layers, noise and number of random stacks.
CASES = ((1, 0.0, 30), (2, 0.0, 30), (1, 0.05, 30), (2, 0.05, 30))
_RECOVERY_COLUMNS = (
    "layers",
    "noise",
    "number",
    "base",
    "distribution",
    "shape_error",
    "rms_log",
    "data_error",
    "true_data_error",
    "worst_parameter_error",
    "worst_parameter",
    "determined",
    "parameters",
    "evaluations",
    "cpu_s",
)
_METRIC_STACKS = 10
# Of fits with a medium that scatters.
_CLOUDY_STARTS = 2
_WAVELENGTH_NM, _STEEP_DEG = 550.0, 65.0


def chart(folder: Path, report: Report) -> None:
    """Write fit_recovery.csv, fit_metric.csv, fit_blue_paint.csv and .png and print them."""
    for name in ("fit_recovery.csv", "fit_metric.csv", "fit_blue_paint.csv"):
        require_writable(folder / name)
    _metrics(folder, report)
    _blue_paint(folder, report)
    _recoveries(folder, report, CASES)


def _recoveries(folder: Path, report: Report, cases) -> None:
    """Cases take turns, so that a study that is stopped has as many of each; one that has not ended goes on where it stopped."""
    heading = (
        "lamina chart fit",
        "random stacks fitted to 500 pairs of adding's own f, structure given; nodes 16 and modes 24 for both; errors at 1500 other pairs",
    )
    path = folder / "fit_recovery.csv"
    order = sorted((i, case) for case, (_, _, stacks) in enumerate(cases) for i in range(stacks))
    rows = _begun(path, heading, len(order))
    before = read_heading(path)[1] if rows else []
    if rows:
        report(f"going on after {len(rows)} of {len(order)} stacks of {path}; delete it to begin anew")
    for i, case in order[len(rows) :]:
        layers, noise, stacks = cases[case]
        structure = random_structure(layers, i)
        stack = random_stack(structure, np.random.default_rng(100 * layers + i))
        start = time.process_time()
        r, _ = recovery(stack, structure, "adding", noise, i)
        rows.append(
            (
                str(layers),
                f"{noise:g}",
                str(i),
                structure.base,
                structure.distributions[0],
                f"{r.shape:.5f}",
                f"{r.error:.5f}",
                f"{r.data_error:.5f}",
                f"{r.true_data_error:.5f}",
                f"{r.worst:.5f}",
                r.worst_name,
                str(r.determined),
                str(r.count),
                str(r.evaluations),
                f"{time.process_time() - start:.1f}",
            )
        )
        report(f"{layers} layers, noise {noise:g}, {i + 1} of {stacks}: {100 * r.shape:.3f} %")
        write_table(path, heading, _RECOVERY_COLUMNS, rows, stamps=list(dict.fromkeys([*before, stamp()])))
    report(f"wrote {path}")
    print_table(
        ("random stacks", "count", "f within 1 %", "f within 3 %", "all determined values within 3 %", "of them determined", "median f", "worst f", "CPU s"),
        [_summary(f"{layers} layers, noise {100 * noise:g} %", [row for row in rows if row[:2] == (str(layers), f"{noise:g}")])
         for layers, noise, _ in cases],
    )  # fmt: skip


def _begun(path: Path, heading: tuple[str, str], whole: int) -> list[tuple[str, ...]]:
    """The rows of a table that has not ended, if it is of this study."""
    if not path.exists():
        return []
    rows = [tuple(row) for row in read_rows(path)]
    if read_heading(path)[0] != [*heading] or rows[:1] != [_RECOVERY_COLUMNS] or len(rows) > whole:
        return []
    return rows[1:]


def _summary(name: str, rows: list[tuple[str, ...]]) -> tuple[str, ...]:
    if not rows:
        return (name, "0", *["-"] * 7)
    shape, worst, determined, count, seconds = (
        np.array([float(row[_RECOVERY_COLUMNS.index(c)]) for row in rows])
        for c in ("shape_error", "worst_parameter_error", "determined", "parameters", "cpu_s")
    )
    shares = [np.mean(shape <= 0.01), np.mean(shape <= 0.03), np.mean(worst <= 0.03), determined.sum() / count.sum()]
    return (
        name,
        str(len(rows)),
        *(f"{100 * share:.0f} %" for share in shares),
        f"{100 * np.median(shape):.3f} %",
        f"{100 * shape.max():.3f} %",
        f"{np.median(seconds):.0f}",
    )


def _metrics(folder: Path, report: Report) -> None:
    """Which compression finds parameters best, by noise: with the paper's model, which is cheap."""
    rows = []
    for kind, noise, floor in (("5 % of f", 0.05, 0.0), ("2 % of the mean f", 0.0, 0.02), ("both", 0.05, 0.02)):
        for metric_kind in METRICS:
            shapes, worst = [], []
            for i in range(_METRIC_STACKS):
                structure = random_structure(1, i)
                stack = random_stack(structure, np.random.default_rng(i))
                data, clean = data_of(stack, "weidlich_wilkie", noise, np.random.default_rng(i), floor)
                metric = Metric(data, metric_kind)
                rough = rough_fits(metric, [structure], "weidlich_wilkie", 4, np.random.default_rng(i))
                fit = corrected(metric, nearest(metric, rough, "weidlich_wilkie"), "weidlich_wilkie")
                r = judged(fit, stack, clean, "weidlich_wilkie", noise)
                truth = fit.parameters.coordinates(stack)
                shapes.append(r.shape)
                worst.append(float(np.median(np.abs(fit.x - truth))))
            rows.append((kind, metric_kind, f"{np.median(shapes):.5f}", f"{np.max(shapes):.5f}", f"{np.median(worst):.5f}"))
        report(f"metrics, noise {kind}")
    columns = ("noise", "metric", "median_shape_error", "worst_shape_error", "median_parameter_error")
    heading = ("lamina chart fit", f"{_METRIC_STACKS} random stacks of one layer, samples of weidlich_wilkie; parameters as parts of their range")
    write_table(folder / "fit_metric.csv", heading, columns, rows, report)
    print_table(columns, rows)


def _blue_paint(folder: Path, report: Report) -> None:
    """Lafortune's blue paint at 550 nm: the paper's model with fitted against its given parameters, and other models.

    The structure is chosen with the paper's model, and taken over for the others of ours.
    """
    preset = presets.load("blue_wall_paint")
    measurement = sample_model("lafortune", preset, _WAVELENGTH_NM)
    metric = subsampled(measurement, len(measurement.f))
    m = metric.measurement
    hand = {
        "paper's parameters, n 1.3 and 1.3 absolute": WeidlichWilkie(blue_paint()),
        "paper's parameters, n 1.3 and 1.69": WeidlichWilkie(blue_paint(1.69)),
        "paper's parameters; Blinn, V cavities, Oren-Nayar 1994": WeidlichWilkie(blue_paint(), **PRINTED),
    }
    rows = []
    for name, model in hand.items():
        f = model.f(m.wo, m.wi)
        rows.append((name, "-", f"{metric.error(f):.4f}", f"{shape_error(f, m.f, m.wi[:, 2]):.4f}"))
    chosen = select(measurement, model="weidlich_wilkie", report=report)
    compared, models = compare(measurement, chosen.best)
    rows += [(r.name, str(r.parameters), f"{r.error:.4f}", f"{r.shape:.4f}") for r in compared]
    for layers in (2, 3):
        rows.append(_paint_row(metric, fit_structure(measurement, Structure.of(layers, "oren_nayar"), "weidlich_wilkie")))
    for layers in (1, 2):
        rows.append(_paint_row(metric, fit_structure(measurement, Structure.of(layers, "lambert", cloudy=True), starts=_CLOUDY_STARTS)))
    rows.append(("any sum of lobes of stacks", "-", f"{least_error(metric):.4f}", "-"))
    rows += _where_it_is_hard(metric)
    columns = ("model", "parameters", "rms_log", "shape_error")
    heading = (
        "lamina chart fit",
        "Lafortune's blue paint at 550 nm (green channel), 3000 pairs of directions to 85 degrees; fitted to 500 of them, sums of lobes to all",
    )
    write_table(folder / "fit_blue_paint.csv", heading, columns, rows, report)
    print_table(columns, rows)
    if pyplot(report) is None:
        return
    paint = _evaluator("lafortune", preset, 1)
    curves = {"paper's parameters, n 1.69": _model(hand["paper's parameters, n 1.3 and 1.69"]), "GGX and Lambert": models["GGX and Lambert"]}
    fit = chosen.best
    ours = _evaluator(fit.model, fit.stack)
    title = f"Lafortune's blue paint at 550 nm (stands in for the measurement of figure 9) and our fit, {fit.structure.name}"
    save_picture(picture(measurement, fit, ours, paint, title, curves), folder / "fit_blue_paint.png", report)


def _paint_row(metric: Metric, fit, of: str = "") -> tuple[str, ...]:
    m = metric.measurement
    f = evaluate(fit.model, {}, fit.stack, m.wo, m.wi, 1)
    return (f"{fit.model}, {fit.structure.name}{of}", str(fit.count), f"{metric.error(f):.4f}", f"{shape_error(f, m.f, m.wi[:, 2]):.4f}")


def _where_it_is_hard(whole: Metric) -> list[tuple[str, ...]]:
    """The same duel on two parts of the paint: without its lobe towards the light, and without what is steeper than 65 degrees."""
    m = whole.measurement
    retro = lafortune_lobes(m.wo, m.wi)[0][:, 1:2]
    inner = np.minimum(m.wi[:, 2], m.wo[:, 2]) >= np.cos(np.radians(_STEEP_DEG))
    rows = []
    for name, data in ((", without its lobe towards the light", replace(m, f=m.f - retro)), (f", to {_STEEP_DEG:g} degrees", m.subset(inner))):
        metric, few = Metric(data), subsampled(data)
        baseline = fit_baseline(BASELINE_MODELS[0], few)
        f = baseline.f(data.wi, data.wo)
        rows.append((BASELINE_MODELS[0].label + name, str(baseline.count), f"{metric.error(f):.4f}", f"{shape_error(f, data.f, data.wi[:, 2]):.4f}"))
        for structure in (Structure.of(1, "oren_nayar"), Structure.of(2, "oren_nayar")):
            rows.append(_paint_row(metric, fit_structure(data, structure, "weidlich_wilkie"), name))
        rows.append((f"any sum of lobes of stacks{name}", "-", f"{least_error(metric):.4f}", "-"))
    return rows


def _evaluator(model: str, stack, channel: int = 0):
    return lambda wi, wo: evaluate(model, {}, stack, wo, wi, 3)[:, channel : channel + 1]


def _model(model):
    return lambda wi, wo: model.f(wo, wi)[:, :1]
