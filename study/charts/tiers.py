# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart tiers`: how far what Cycles is told lies from the truth, for the paper's presets and every stack of the suite."""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.lobes.baked import Baker, best_of
from ...reference_py.lobes.bare_base import is_bare_oren_nayar
from ...reference_py.lobes.error_estimate import ErrorEstimator, Errors
from ...reference_py.lobes.methods import METHODS, AnalyticLobes, holds_values, make_lobe_set
from ...reference_py.lobes.tabulate import stock_lobes
from ...reference_py.material.stack import Stack
from ...reference_py.models.adding.adding_model import Adding
from ..suite import charted
from ..tables import Report, write_table
from .output import print_table

# Views of the albedo; shapes are judged at the same.
THETA_DEG = np.array([0.0, 20.0, 40.0, 60.0, 75.0, 80.0])
GLOSSY = (1, 2, 3)
STOCK = "baked, 2 glossy, stock nodes"
COLUMNS = ("stack", "tier", "closures", "albedo_worst", "shape_worst", "shape_median")
_HEADING = (
    "lamina chart tiers",
    f"against adding at {', '.join(f'{t:g}' for t in THETA_DEG)} degrees",
    "albedo: relative, worst view and channel",
    "shape: cosine-weighted L1 over albedo, worst channel",
)


def chart(folder: Path, report: Report) -> None:
    """Write tier_errors.csv and print, for each tier, the medians and worst over all stacks."""
    table = folder / "tier_errors.csv"
    require_writable(table)
    stacks = charted()
    rows = []
    for i, (name, stack) in enumerate(stacks.items()):
        report(f"{100 * i // len(stacks):3} % {name}")
        rows += [[name, *row] for row in _rows(stack)]
    write_table(table, _HEADING, COLUMNS, rows, report)
    print_table(("tier", "stacks", "albedo median", "albedo worst", "above 3 %", "shape median", "shape worst", "above 8 %", "of all views"), _summary(rows))


def _rows(stack: Stack) -> list[list[str]]:
    truth = Adding(stack)
    estimator = ErrorEstimator(stack, truth, np.cos(np.radians(THETA_DEG)))
    lobe_sets = {method: make_lobe_set(stack, method) for method in METHODS if not holds_values(method)}
    baker = Baker(stack, truth)
    exact = AnalyticLobes(stack) if is_bare_oren_nayar(stack) else None
    lobe_sets |= {f"baked, {count} glossy": exact or best_of(baker, count) for count in GLOSSY}
    lobe_sets[STOCK] = exact or stock_lobes(lobe_sets["baked, 2 glossy"])
    return [[tier, str(lobe_set.lobe_count), *_cells(estimator.errors(lobe_set))] for tier, lobe_set in lobe_sets.items()]


def _cells(errors: Errors) -> list[str]:
    return [f"{v:.5f}" for v in (np.max(errors.albedo), np.max(errors.shape), np.median(errors.shape))]


def _summary(rows: list[list[str]]) -> list[list[str]]:
    """Per tier over all stacks. The shape's median and worst are those of the stacks' worst views; then the median of
    the stacks' median views."""
    result = []
    for tier in dict.fromkeys(row[1] for row in rows):
        albedo, shape, usual = np.array([[float(v) for v in row[3:6]] for row in rows if row[1] == tier]).T
        shares = [f"{100.0 * v:.2f} %" for v in (np.median(albedo), np.max(albedo), np.median(shape), np.max(shape), np.median(usual))]
        counts = [str(np.sum(albedo > 0.03)), str(np.sum(shape > 0.08))]
        result.append([tier, str(len(albedo)), *shares[:2], counts[0], *shares[2:4], counts[1], shares[4]])
    return result
