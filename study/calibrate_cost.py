# SPDX-License-Identifier: GPL-3.0-or-later
"""Find again what the parts of a lobe set cost (`reference_py/lobes/methods/cost.py`), from Cycles' CPU time.

    python -m lamina.study.calibrate_cost [--measure] [--rounds N] [--seed N] [--write]

Least squares of relative errors, no coefficient below 0, over the rows of figures/cost_fit.csv; `--measure` renders them anew first (needs
bpy, `cost_renders.py`). Every row is fitted from the others as well, in `FOLDS` parts by the seed: the error of what was held out.
Prints committed and fitted coefficients, and the errors of both, also on the live methods of figures/pareto.csv: other stacks, measured at
another time. Layers cost by what they hold, so `--write` is for who measured layers of many kinds.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..reference_py.errors import LaminaError
from ..reference_py.fit.solve import least_squares
from ..reference_py.lobes.methods import cost, make_lobe_set
from .charts.output import print_table
from .constants_file import rounded, write_constants
from .pareto.surface_types import load_surface
from .tables import FIGURES, read_table, write_table

FILE = Path(cost.__file__)
TABLE, PARETO = FIGURES / "cost_fit.csv", FIGURES / "pareto.csv"
SEED, ROUNDS, FOLDS = 7, 5, 5
MEASURED = ("cost", "cost_low", "cost_high", "start_ms")
# What the estimate promises.
GOOD_TO = 0.25


@dataclass(frozen=True)
class Row:
    """A material that was timed: its parts, and its CPU time over a plain glossy node's."""

    name: str
    parts: Mapping[str, int]  # those that it has
    cost: float


def read_rows(path: Path = TABLE) -> list[Row]:
    """The measurements of a table. Raises LaminaError where it has none, or not of these parts."""
    if not path.exists():
        raise LaminaError(f"{path} is missing: measure it with --measure")
    table = read_table(path)
    if not table or set(cost.PARTS) - set(table[0]):
        raise LaminaError(f"{path} has not the parts {', '.join(cost.PARTS)}: measure it anew with --measure")
    return [Row(row["material"], {part: int(row[part]) for part in cost.PARTS}, float(row["cost"])) for row in table]


def pareto_rows() -> list[Row]:
    """What `lamina chart pareto` measured of the live methods."""
    table = [row for row in read_table(PARETO) if row["method"] in ("analytic", "weidlich_wilkie")]
    lobe_sets = [make_lobe_set(load_surface(row["surface"]), row["method"]).lobe_set for row in table]
    return [Row(f"{row['surface']}, {row['method']}", cost.parts(lobe_set), float(row["cost"])) for row, lobe_set in zip(table, lobe_sets)]


def fit(rows: Sequence[Row]) -> dict[str, float]:
    """Cost of each part, 0 or more."""
    counts = np.array([[row.parts.get(part, 0) for part in cost.PARTS] for row in rows], float)
    relative = counts / np.array([row.cost for row in rows])[:, None]
    start, high = np.full(len(cost.PARTS), 0.5), np.full(len(cost.PARTS), np.inf)
    found = least_squares(lambda x: relative @ x - 1.0, lambda x, r: relative, start, 0.0 * start, high)
    return dict(zip(cost.PARTS, map(float, found.x)))


def errors(rows: Sequence[Row], coefficients: Mapping[str, float]) -> np.ndarray:
    """Relative and signed errors (n,) of the estimate."""
    return np.array([sum(coefficients[part] * count for part, count in row.parts.items()) / row.cost - 1.0 for row in rows])


def held_out_errors(rows: Sequence[Row], rng: np.random.Generator) -> np.ndarray:
    """Errors (n,) of each row by a fit to the other parts of the table."""
    fold = rng.permutation(len(rows)) % FOLDS
    result = np.zeros(len(rows))
    for k in range(FOLDS):
        found = fit([row for row, f in zip(rows, fold) if f != k])
        result[fold == k] = errors([row for row, f in zip(rows, fold) if f == k], found)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="lamina.study.calibrate_cost", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measure", action="store_true", help=f"render {TABLE.name} anew (five minutes on a quiet machine)")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="of renders (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=SEED, help="of what is held out (default: %(default)s)")
    parser.add_argument("--write", action="store_true", help=f"write the fitted coefficients into {FILE.name}")
    options = parser.parse_args(arguments)
    if options.measure:
        _measure(options.rounds)
    rows = read_rows()
    fitted = {part: rounded(value) for part, value in fit(rows).items()}
    print_table(("part", "committed", "fitted"), [(part, f"{cost.PARTS[part]:g}", f"{fitted[part]:g}") for part in fitted])
    print()
    kinds = {
        "committed": errors(rows, cost.PARTS),
        "fitted": errors(rows, fitted),
        "fitted, held out": held_out_errors(rows, np.random.default_rng(options.seed)),
    }
    kinds |= {f"{name}, {PARETO.stem}": errors(pareto_rows(), found) for name, found in (("committed", cost.PARTS), ("fitted", fitted))}
    print_table(("coefficients", "materials", "error RMS", "median", "worst", f"above {GOOD_TO:.0%}"), [_statistics(name, e) for name, e in kinds.items()])
    if options.write:
        write_constants(FILE, {f"PARTS.{part}": value for part, value in fitted.items()})
        print(f"wrote {FILE}")
    return 0


def _statistics(name: str, e: np.ndarray) -> tuple[str, ...]:
    size = np.abs(e)
    return name, str(len(e)), *(f"{100.0 * v:.1f} %" for v in (np.sqrt(np.mean(e * e)), np.median(size), np.max(size))), str(np.sum(size > GOOD_TO))


def _measure(rounds: int) -> None:
    from ..addon.session import blender

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    with blender(lambda text: None):
        from .cost_renders import measured

        rows = measured(rounds, report)
        meaning = "cost: least CPU time of the rounds over a plain glossy node's least"
        heading = (f"make calibration: lamina.study.calibrate_cost --measure --rounds {rounds}", meaning)
        write_table(TABLE, heading, ("material", *cost.PARTS, *MEASURED), rows, report)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except LaminaError as error:
        sys.exit(f"calibrate_cost: {error}")
