# SPDX-License-Identifier: GPL-3.0-or-later
"""What pictures share. Imports matplotlib when called, never on import."""


def new_figure(width: float, height: float, title: str):
    """An empty matplotlib figure, sizes in inches; it needs no display."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained", dpi=80)
    figure.suptitle(title, fontsize=10)
    return figure


def style(axes, title: str, x_label: str, y_label: str, legend: bool = True) -> None:
    """Small type, a light grid and, if asked for, the legend."""
    axes.set_title(title, fontsize=9)
    axes.set_xlabel(x_label, fontsize=8)
    axes.set_ylabel(y_label, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3)
    if legend:
        axes.legend(fontsize=7)
