# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart error`: albedo error of every model against the truth, for every surface type of the paper, by view angle.

Truth is `adding` with lossless surfaces; `lamina chart suite` checks it against the walks of `position_free`.
"""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material import presets
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model
from ..stress import MODELS_AND_METHODS, make_model_or_method
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

THETA_DEG = np.array([0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 85.0])
TRUTHS = ("adding", "position_free")
# A fit to one measured paint knows no stack, so that it has no error against one.
FITS = ("lafortune",)
COMPARED = tuple(name for name in MODELS_AND_METHODS if name not in TRUTHS + FITS)
_BASELINES_FROM = COMPARED.index("torrance_sparrow")

_OURS = ("black", "orangered", "gold", "deepskyblue", "limegreen")
_MARKERS = ("o", "s", "^", "v", "D", "P", "X", "<")

_HEADING = ("lamina chart error", "albedo / truth - 1 of the worst channel; truth: adding, surface multiple")


def chart(folder: Path, report: Report) -> None:
    """Write error_by_angle.csv and .png and print every model's worst."""
    table = folder / "error_by_angle.csv"
    require_writable(table)
    wo, errors = spherical(np.radians(THETA_DEG), 0.0), {}
    for i, preset in enumerate(presets.PAPER):
        report(f"{100 * i // len(presets.PAPER):3} % {preset}")
        stack = presets.load(preset)
        exact = make_model("adding", stack).albedo(wo)
        for name in COMPARED:
            errors[preset, name] = worst_channel(make_model_or_method(name, stack).albedo(wo), exact)
    rows = [[*key, *(f"{v:.4f}" for v in error)] for key, error in errors.items()]
    write_table(table, _HEADING, ("preset", "model", *(f"{t:g}deg" for t in THETA_DEG)), rows, report)
    print_table(("model", "worst", "where", "at", "worst to 60", "mean |error|"), [_summary(name, errors) for name in COMPARED])
    _draw(folder / "error_by_angle.png", errors, report)


def worst_channel(albedo: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Signed relative error (n,) of the channel that is furthest off; arguments (n, 3)."""
    error = albedo / np.maximum(exact, 1e-6) - 1.0
    return np.take_along_axis(error, np.argmax(np.abs(error), axis=-1)[:, None], axis=-1)[:, 0]


def _summary(name: str, errors: dict) -> list[str]:
    names = presets.PAPER
    table = np.array([errors[preset, name] for preset in names])
    row, column = np.unravel_index(np.argmax(np.abs(table)), table.shape)
    steep = table[:, THETA_DEG <= 60.0]
    steepest = steep.flat[np.argmax(np.abs(steep))]
    mean = np.mean(np.abs(table))
    return [name, f"{table[row, column]:+.1%}", names[row], f"{THETA_DEG[column]:g} deg", f"{steepest:+.1%}", f"{mean:.1%}"]


def _draw(path: Path, errors: dict, report: Report) -> None:
    plot = pyplot(report)
    if plot is None:
        return
    figure, axes = plot.subplots(2, 5, figsize=(17, 8), layout="constrained", sharex=True, sharey=True)
    for axis, preset in zip(axes.flat, presets.PAPER):
        axis.axhspan(-1.0, 1.0, color="0.92", zorder=0)
        axis.axhline(0.0, color="0.5", linewidth=0.8)
        for i, name in enumerate(COMPARED):
            baseline = i - _BASELINES_FROM
            color = f"C{baseline + 1}" if baseline >= 0 else _OURS[i % len(_OURS)]
            if baseline >= 0:
                style = {"linewidth": 1.2, "marker": _MARKERS[baseline % len(_MARKERS)], "markersize": 4}
            else:  # dashes, as the mirror should hide the model that it follows
                style = {"linewidth": 3.0, "zorder": 3 + i, "linestyle": (0, (1.5, 1.5)) if name == "closure_model:weidlich_wilkie" else "-"}
            axis.plot(THETA_DEG, 100.0 * errors[preset, name], color=color, label=name, **style)
        axis.set_yscale("symlog", linthresh=10.0, linscale=1.5)
        axis.set(title=presets.label(preset), xlim=(0.0, 85.0), ylim=(-100.0, 150.0), xticks=range(0, 91, 15))
        ticks = (-100, -50, -20, -10, -5, 0, 5, 10, 20, 50, 100)
        axis.set_yticks(ticks, [f"{tick:+} %" if tick else "0" for tick in ticks])
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("view angle (degrees)")
    for axis in axes[:, 0]:
        axis.set_ylabel("albedo error, worst channel")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6, fontsize=10)
    figure.suptitle(
        "Albedo against the truth (adding, lossless surfaces): too bright above, too dark below; band: 1 %. A jump: another "
        "channel is the worst.\nThick: models of this project; marked: baselines"
    )
    save_picture(figure, path, report)
