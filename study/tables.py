# SPDX-License-Identifier: GPL-3.0-or-later
"""The measured tables of figures/: CSV whose first line is a comment with the command, notes and a stamp (`stamp`)."""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from ..reference_py.atomic import write_text
from .stamp import ROOT, is_stamp, stamp

FIGURES = ROOT / "figures"
Report = Callable[[str], None]


def write_table(
    path: Path, heading: Sequence[str], columns: Sequence[str], rows: Iterable[Sequence[Any]], report: Report | None = None, stamps: Sequence[str] = ()
) -> str:
    """Write a table, whole or not at all; returns its text. `heading` begins with the command; `stamps` are of others that measured."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"# {heading[0]}", *heading[1:], *(stamps or (stamp(),))])
    writer.writerow(columns)
    writer.writerows(rows)
    write_text(path, text.getvalue())
    if report:
        report(f"wrote {path}")
    return text.getvalue()


def read_rows(path: Path) -> list[list[str]]:
    """The columns' names and the rows, without the heading."""
    lines = _lines(path)
    return lines[1:] if lines and lines[0][0].startswith("#") else lines


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows by column."""
    columns, *rows = read_rows(path)
    return [dict(zip(columns, row)) for row in rows]


def read_heading(path: Path) -> tuple[list[str], list[str]]:
    """The cells of the heading, the command without its comment sign first, and its stamps; nothing where there is no heading."""
    first = next(iter(_lines(path)), [""])
    if not first[0].startswith("#"):
        return [], []
    cells = [first[0].removeprefix("# "), *first[1:]]
    return [cell for cell in cells if not is_stamp(cell)], [cell for cell in cells if is_stamp(cell)]


def _lines(path: Path) -> list[list[str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return [row for row in csv.reader(file) if row]
