# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

import csv
import io
from pathlib import Path

import numpy as np

from ...reference_py import presets
from ...reference_py.atomic import replacing, require_writable, write_text
from ...reference_py.compare import distance
from ...reference_py.models import make_model
from ...reference_py.network import DEFAULT_TIER
from .session import say

NETWORK_THETA_DEG = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])


def chart(options) -> None:
    """Write chart.csv and chart.png into a folder and print the table."""
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    {"network": _network}[options.chart](folder, say("chart"))


def _network(folder: Path, report) -> None:
    """Error of each preset's network against the exact model of the paper, by view angle."""
    table, picture = folder / "network_error.csv", folder / "network_error.png"
    require_writable(table)
    names = presets.names()
    rows = []
    for i, name in enumerate(names):
        report(f"{100 * i // len(names):3} % {name}")
        stack = presets.load(name)
        result = distance(stack, make_model("mirror", stack), make_model("weidlich_wilkie", stack), np.radians(NETWORK_THETA_DEG))
        rows.append((name, result))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["# lamina chart network", f"tier {DEFAULT_TIER} against model weidlich_wilkie"])
    writer.writerow(["preset", "error", *(f"{t:g}deg" for t in NETWORK_THETA_DEG)])
    for name, result in rows:
        writer.writerow([name, "albedo", *(f"{v:.4f}" for v in result.albedo)])
        writer.writerow([name, "shape_L1", *(f"{v:.4f}" for v in result.shape)])
    write_text(table, text.getvalue())
    print(text.getvalue(), end="")
    report(f"wrote {table}")
    try:
        import matplotlib
    except ImportError:
        report("no picture: matplotlib is not installed (pip install lamina[figures])")
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(11, 4.5), layout="constrained", sharex=True)
    for axis, key, title in ((axes[0], "albedo", "albedo, relative error"), (axes[1], "shape", "shape, cosine-weighted L1 over albedo")):
        for name, result in rows:
            axis.semilogy(NETWORK_THETA_DEG, np.maximum(getattr(result, key), 1e-5), marker="o", markersize=3, label=presets.label(name))
        axis.set(title=title, xlabel="view angle (degrees)", ylim=(1e-5, 2.0))
        axis.grid(alpha=0.3)
    axes[1].legend(fontsize=7, ncols=2)
    figure.suptitle(f"Network of tier {DEFAULT_TIER} against the exact model of Weidlich and Wilkie 2007")
    with replacing(picture) as temporary:
        figure.savefig(temporary, dpi=110)
    report(f"wrote {picture}")
