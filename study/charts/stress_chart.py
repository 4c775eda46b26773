# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart stress`: every model of the registry, and every tier, in every hard case."""

from pathlib import Path

from ...reference_py.atomic import require_writable
from ..stress import CASES, COLUMNS, MODELS_AND_METHODS, REFUSED, is_refused, measure
from ..tables import Report, write_table
from .output import print_table

_HEADING = ("lamina chart stress", "worst of each case, beyond 4 standard errors; columns as in study/stress.py")


def chart(folder: Path, report: Report) -> None:
    """Write stress.csv and print it. What the stack refuses is refused for every model."""
    table = folder / "stress.csv"
    require_writable(table)
    rows = []
    for i, name in enumerate(MODELS_AND_METHODS):
        report(f"{100 * i // len(MODELS_AND_METHODS):3} % {name}")
        for case in CASES:
            result = measure(name, CASES[case])
            rows.append([name, case, *(_cell(getattr(result, column)) for column in COLUMNS)])
    for case, data in REFUSED.items():
        rows.append(["(all)", case, *(["refused" if is_refused(data) else "ACCEPTED"] + [""] * (len(COLUMNS) - 1))])
    columns = ("model", "case", *COLUMNS)
    print_table(columns, rows)
    write_table(table, _HEADING, columns, rows, report)


def _cell(value: bool | float | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "0" if value < 1e-9 else f"{value:.3g}"
