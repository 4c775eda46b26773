# SPDX-License-Identifier: GPL-3.0-or-later
"""What every chart shows: its table (`study.tables` writes it), and a picture where matplotlib is installed."""

from collections.abc import Sequence
from pathlib import Path

from ...reference_py.atomic import replacing
from ..tables import Report


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """The same for people: columns aligned, the first one to the left."""
    widths = [max(len(row[i]) for row in (columns, *rows)) for i in range(len(columns))]
    for row in (columns, *rows):
        first, *others = (cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths)))
        print("  ".join([first, *others]).rstrip())


def pyplot(report: Report):
    """matplotlib's pyplot that draws into files, or None, said why."""
    try:
        import matplotlib
    except ImportError:
        report("no picture: matplotlib is not installed (pip install lamina[figures])")
        return None
    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def save_picture(figure, path: Path, report: Report) -> None:
    """Write a picture whole or not at all."""
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=110)
    report(f"wrote {path}")
