# SPDX-License-Identifier: GPL-3.0-or-later
"""Are random stacks found as well as at another commit? `python -m lamina.study.compare_fits COMMIT`

Compares fit_recovery.csv fit by fit, without noise and with it. Prints for each error its median ratio, how many fits are worse and better by a
tenth, and how many of the worse ones leave less of the data than the stack does from which these were made. Of those the data cannot tell which
is right: another path of the solver ends at another place of one valley.
"""

import sys

import numpy as np

from .compare_figures import tables_of
from .tables import FIGURES, read_rows

ERRORS = ("shape_error", "rms_log")
# A change that counts, as a ratio, and an error that is the table's last digit, below which none does.
WORSE, LEAST = 1.1, 1e-5
_KEYS = ("layers", "noise", "number", "base", "distribution")
Fits = dict[tuple[str, ...], dict[str, str]]


def fits(table: list[list[str]]) -> Fits:
    """Rows by what was fitted; the columns' names come first."""
    columns, *rows = table
    found = [dict(zip(columns, row)) for row in rows]
    return {tuple(row[key] for key in _KEYS): row for row in found}


def compared(before: Fits, after: Fits) -> list[str]:
    """A line for each error without noise and with it."""
    told = []
    for is_noisy in (False, True):
        pairs = [(before[key], row) for key, row in after.items() if key in before and (float(row["noise"]) > 0.0) == is_noisy]
        kind = "with" if is_noisy else "without"
        if not pairs:
            told.append(f"{kind} noise: the two tables share no fits")
            continue
        for name in ERRORS:
            old, new = (np.maximum([float(row[name]) for row in side], LEAST) for side in zip(*pairs))
            worse = new > WORSE * old
            nearer = np.array([float(row["data_error"]) < float(row["true_data_error"]) for _, row in pairs])
            told.append(
                f"{name} {kind} noise: {len(pairs)} fits, median ratio {np.median(new / old):.3f}; "
                f"{np.sum(worse)} worse by a tenth (to {np.max(new[worse], initial=0.0):.2g}), {np.sum(old > WORSE * new)} better; "
                f"of the worse {np.sum(worse & nearer)} nearer to the data than the stack they were made from"
            )
    return told


def main() -> int:
    """Compare with the commit of the command line."""
    before = dict(tables_of(sys.argv[1]))["fit_recovery.csv"]
    print(*compared(fits(before), fits(read_rows(FIGURES / "fit_recovery.csv"))), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
