# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed in the tables of figures/ since another commit? `python -m lamina.study.compare_figures COMMIT`

Rows are the same where their words are; columns by their names. Prints for each table how many rows both have, the median change of all numbers, and
the largest one with its place, as a share of the value and 1 % of the column's largest. Judging is left to the reader: times are noise, and a better
method changes its errors.
"""

import csv
import io
import subprocess
import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .stamp import ROOT
from .tables import FIGURES, read_rows

Row = tuple[str, ...]
RENAMED = {"levers.csv": "cost_factors.csv", "network_error.csv": "lobe_errors.csv"}


class Change(NamedTuple):
    """rows: (both have, in one alone). median and largest: shares; nan where both have no number. place: of the largest."""

    rows: tuple[int, int]
    median: float
    largest: float
    place: str


def number(cell: str) -> float | None:
    """A cell's number, "3.4 %" included."""
    try:
        return float(cell.removesuffix("%").strip())
    except ValueError:
        return None


def keyed(rows: list[list[str]]) -> dict[Row, dict[str, float]]:
    """Numbers by column, of rows by their words and, where several have the same, their turn."""
    columns, *cells = rows
    found: dict[Row, dict[str, float]] = {}
    for row in cells:
        key = tuple(cell for cell in row if number(cell) is None)
        turn = sum(other[: len(key)] == key for other in found)
        found[(*key, str(turn))] = {name: value for name, cell in zip(columns, row) if (value := number(cell)) is not None}
    return found


def compare(before: list[list[str]], after: list[list[str]]) -> Change:
    """Two tables, their columns' names first."""
    old, new = keyed(before), keyed(after)
    largest = {name: max((abs(row[name]) for row in old.values() if name in row), default=0.0) for name in before[0]}
    changes = [
        (abs(new[key][name] - value) / (abs(value) + 0.01 * largest[name] + 1e-12), f"{name} of {', '.join(key[:-1]) or key[-1]}")
        for key in old.keys() & new.keys()
        for name, value in old[key].items()
        if name in new[key]
    ]
    worst, place = max(changes, default=(np.nan, ""))
    return Change((len(old.keys() & new.keys()), len(old.keys() ^ new.keys())), float(np.median([c for c, _ in changes] or [np.nan])), worst, place)


def tables_of(commit: str) -> Iterator[tuple[str, list[list[str]]]]:
    """Names of a commit's tables, and their rows."""
    names = subprocess.run(["git", "-C", ROOT, "ls-tree", "-r", "--name-only", "-z", commit, "figures/"], check=True, capture_output=True, text=True).stdout
    for name in names.split("\0"):
        if name.endswith(".csv"):
            text = subprocess.run(["git", "-C", ROOT, "show", f"{commit}:{name}"], check=True, capture_output=True, text=True).stdout
            rows = [row for row in csv.reader(io.StringIO(text)) if row]
            yield name.removeprefix("figures/"), rows[1:] if rows[0][0].startswith("#") else rows


def main() -> int:
    """Compare with the commit of the command line."""
    for name, before in tables_of(sys.argv[1]):
        (both, alone), median, largest, place = compare(before, read_rows(FIGURES / RENAMED.get(name, name)))
        told = f"median {100.0 * median:.2g} %, at most {100.0 * largest:.2g} % ({place[:90]})" if both else "nothing to compare"
        print(f"{name}: {both} rows in both, {alone} in one alone; {told}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
