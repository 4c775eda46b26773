# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart suite`: do the two truths, `adding` and `position_free`, agree on every stack of the suite?"""

from collections.abc import Mapping
from pathlib import Path

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ..agreement import COLUMNS, Agreement, agreement
from ..suite import suite
from ..tables import Report, write_table
from .output import print_table

_HEADING = ("lamina chart suite", "adding against position_free: seed 1; relative errors; columns as in study/agreement.py")


def chart(folder: Path, report: Report) -> None:
    """Write suite_agreement.csv and print it."""
    write_agreement(folder / "suite_agreement.csv", _HEADING, suite(), report)


def write_agreement(table: Path, heading: tuple[str, ...], stacks: Mapping[str, Stack], report: Report, **walks: int) -> None:
    """Write and print how well the truths agree on stacks; `walks` are options of `agreement`."""
    require_writable(table)
    rows = []
    for i, (name, stack) in enumerate(stacks.items()):
        report(f"{100 * i // len(stacks):3} % {name}")
        rows.append(_row(name, agreement(stack, **walks)))
    columns = ("stack", *COLUMNS, "albedo_agrees", "f_agrees")
    print_table(columns, rows)
    print(f"albedo agrees for {sum(r[-2] == 'yes' for r in rows)} of {len(rows)} stacks, f for {sum(r[-1] == 'yes' for r in rows)}")
    write_table(table, heading, columns, rows, report)


def _row(name: str, result: Agreement) -> list[str]:
    numbers = [f"{getattr(result, column):.4g}" if column != "walks" else str(result.walks) for column in COLUMNS]
    return [name, *numbers, *("yes" if agrees else "no" for agrees in (result.albedo_agrees, result.f_agrees))]
