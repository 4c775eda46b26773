# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart grazing`: f of `adding` against walks where view and light both graze the surface, direction by direction."""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ..double_grazing import SIGMAS, STACKS, STATED, measured
from ..tables import Report, read_table, write_table
from .output import print_table

_COLUMNS = ("stack", "theta_o_deg", "theta_i_deg", "azimuth_deg", "walked", "stderr", "before", "adding", "before_error", "error", "noise", "seen")
_HEADING = (
    "lamina chart grazing",
    "f of the green channel by walks, seed 1, and by adding; walks are position_free's, of one surface alone those of study.two_ended; errors of the worst channel, relative to f; noise: its relative standard error",
    "before: adding of commit 9a85594, kept from the table; seen: f cos is above a thousandth of the mean",
)


def chart(folder: Path, report: Report) -> None:
    """Write double_grazing.csv and print it."""
    table = folder / "double_grazing.csv"
    require_writable(table)
    kept = {tuple(row[c] for c in _COLUMNS[:4]): (row["before"], row["before_error"]) for row in (read_table(table) if table.exists() else ())}
    rows = []
    for i, name in enumerate(STACKS):
        report(f"{100 * i // len(STACKS):3} % {name}")
        found = list(measured(name))
        for one in found:
            key = (name, *(f"{angle:g}" for angle in one.degrees))
            before, before_error = kept.get(key, ("", ""))
            green = (f"{value[1]:.5g}" for value in (one.walked, one.stderr))
            rows.append(
                [*key, *green, before, f"{one.adding[1]:.5g}", before_error, f"{one.error(one.adding):.4f}", f"{one.noise:.4f}", "yes" if one.is_seen else "no"]
            )
        seen = [one for one in found if one.is_seen]
        beyond = [abs(one.error(one.adding)) - SIGMAS * one.noise for one in seen]
        median = np.median([abs(one.error(one.adding)) for one in seen])
        report(f"{name}: {sum(e <= STATED for e in beyond)} of {len(seen)} within {STATED:g} of f and {SIGMAS:g} standard errors, median {median:.4f}")
    print_table(_COLUMNS, rows)
    write_table(table, _HEADING, _COLUMNS, rows, report)
