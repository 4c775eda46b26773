# SPDX-License-Identifier: GPL-3.0-or-later
"""What every chart writes: a table as CSV, and a picture where matplotlib is installed."""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from ...reference_py.atomic import replacing, write_text

Report = Callable[[str], None]


def write_table(path: Path, heading: Sequence[str], columns: Sequence[str], rows: Iterable[Sequence[str]], report: Report) -> str:
    """Write a CSV whose first line is a comment that starts with the command; returns its text."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"# {heading[0]}", *heading[1:]])
    writer.writerow(columns)
    writer.writerows(rows)
    write_text(path, text.getvalue())
    report(f"wrote {path}")
    return text.getvalue()


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
