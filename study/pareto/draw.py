# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the chart: cost against error, one panel per surface type and kind of error, with the frontier."""

import numpy as np

# name: color, marker
_STYLE = {
    "glossy": ("0.55", "o"), "principled": ("tab:orange", "s"), "layer": ("tab:brown", "s"), "belcour": ("tab:purple", "D"),
    "weidlich_wilkie": ("tab:olive", "^"), "analytic": ("tab:green", "^"), "nodes": ("tab:cyan", "o"),
    "baked_1": ("#8ec1ea", "o"), "baked_2": ("#4a98d9", "o"), "baked_3": ("#1f6fb2", "o"), "baked_4": ("#0b4a80", "o"),
    "slab": ("tab:red", "X"),
}  # fmt: skip
# column, title, scale, smallest that is shown
_ERRORS = (
    ("albedo", "albedo, worst view (%)", 100.0, 0.01),
    ("shape", "shape (L1 of f), worst view (%)", 100.0, 0.1),
    ("delta_e", "ball picture, mean CIEDE2000", 1.0, 0.02),
)


def frontier(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points (cost, error) that none beats in both, by cost."""
    best: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((cost, error))
    return best


def draw(plot, rows: list[dict], label):
    """A figure of the table's rows. `plot` is pyplot; `label(surface)` the title of a surface."""
    surfaces = list(dict.fromkeys(row["surface"] for row in rows))
    size = 3.3 * len(surfaces) + 0.6, 10.5
    figure, axes = plot.subplots(3, len(surfaces), figsize=size, layout="constrained", squeeze=False, sharex=True, sharey="row")
    for column, name in enumerate(surfaces):
        own = [row for row in rows if row["surface"] == name]
        for axis, (key, title, scale, floor) in zip(axes[:, column], _ERRORS):
            _panel(axis, own, key, scale, floor)
            if column == 0:
                axis.set_ylabel(title)
        axes[0, column].set_title(label(name).replace(": ", ":\n"), fontsize=10)
        axes[-1, column].set_xlabel("CPU time / plain glossy node")
    handles: dict[str, object] = {}
    for axis in axes[0]:
        handles |= dict(zip(*reversed(axis.get_legend_handles_labels())))
    names = dict.fromkeys(row["label"] for row in rows)
    columns = 6 if len(surfaces) > 2 else 2
    figure.legend([handles[n] for n in names], names, loc="outside lower center", ncols=columns, fontsize=9)
    if len(surfaces) > 2:
        figure.suptitle("Error against cost of every way to render a layered material in Cycles: lower left is better; line: what none beats in both")
    return figure


def _panel(axis, rows: list[dict], key: str, scale: float, floor: float) -> None:
    points = {}
    for row in rows:
        points[row["method"]] = float(row["cost"]), max(scale * float(row[key]), floor)
    line = np.array(frontier(list(points.values())))
    axis.step([*line[:, 0], 100.0], [*line[:, 1], line[-1, 1]], where="post", color="0.75", linewidth=1.2, zorder=1)
    for row in rows:
        (x, y), (color, marker) = points[row["method"]], _STYLE[row["method"]]
        axis.plot([float(row["cost_low"]), float(row["cost_high"])], [y, y], color=color, linewidth=0.6, zorder=2)
        axis.plot(x, y, marker, color=color, markersize=7, markeredgecolor="white", markeredgewidth=0.6, label=row["label"], zorder=3)
    axis.set(xscale="log", yscale="log")
    axis.set_xlim(0.8, max(6.0, *(1.15 * p[0] for p in points.values())))
    ticks = (1, 1.5, 2, 3, 5, 10, 20)
    axis.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axis.minorticks_off()
    axis.grid(alpha=0.25)
