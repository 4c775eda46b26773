# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart lobes`: error of each lobe set of the tier weidlich_wilkie against the model of that name, for the presets of the paper, by view angle."""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.lobes.methods import PaperLobes
from ...reference_py.material import presets
from ...reference_py.models.distance import Distance, distance
from ...reference_py.registry import make_model
from ..tables import Report, write_table
from .output import pyplot, save_picture

THETA_DEG = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])

_METHOD = PaperLobes.name
_HEADING = ("lamina chart lobes", f"tier {_METHOD} against model weidlich_wilkie")


def chart(folder: Path, report: Report) -> None:
    """Write lobe_errors.csv and .png and print the table."""
    table = folder / "lobe_errors.csv"
    require_writable(table)
    names = presets.PAPER
    results = {}
    for i, name in enumerate(names):
        report(f"{100 * i // len(names):3} % {name}")
        stack = presets.load(name)
        results[name] = distance(stack, make_model("closure_model", stack, method=_METHOD), make_model("weidlich_wilkie", stack), np.radians(THETA_DEG))
    rows = []
    for name, result in results.items():
        rows.append([name, "albedo", *(f"{v:.4f}" for v in result.albedo)])
        rows.append([name, "shape_L1", *(f"{v:.4f}" for v in result.shape)])
    print(write_table(table, _HEADING, ("preset", "error", *(f"{t:g}deg" for t in THETA_DEG)), rows, report), end="")
    _draw(folder / "lobe_errors.png", results, report)


def _draw(path: Path, results: dict[str, Distance], report: Report) -> None:
    plot = pyplot(report)
    if plot is None:
        return
    figure, axes = plot.subplots(1, 2, figsize=(11, 4.5), layout="constrained", sharex=True)
    for axis, key, title in ((axes[0], "albedo", "albedo, relative error"), (axes[1], "shape", "shape, cosine-weighted L1 over albedo")):
        for name, result in results.items():
            axis.semilogy(THETA_DEG, np.maximum(getattr(result, key), 1e-5), marker="o", markersize=3, label=presets.label(name))
        axis.set(title=title, xlabel="view angle (degrees)", ylim=(1e-5, 2.0))
        axis.grid(alpha=0.3)
    axes[1].legend(fontsize=7, ncols=2)
    figure.suptitle(f"Lobe set of tier {_METHOD} against the exact model of Weidlich and Wilkie 2007")
    save_picture(figure, path, report)
