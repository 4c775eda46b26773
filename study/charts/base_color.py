# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart base_color`: a bake that follows the base's color, at nine colors, beside bakes of these colors alone."""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.lobes.baked import follows
from ...reference_py.lobes.error_estimate import ErrorEstimator, Errors
from ...reference_py.lobes.methods import make_lobe_set
from ...reference_py.lobes.truth import truth_of
from ...reference_py.lobes.view_table import BASE_COLOR, TableLobes
from ...reference_py.material.stack import Stack
from ..suite import charted
from ..tables import Report, write_table
from .tiers import THETA_DEG

COLORS, _SEED = 9, 17
COLUMNS = ("stack", "closures", "albedo_worst", "shape_worst", "shape_median", "own_albedo_worst", "own_shape_worst", "own_shape_median")
_HEADING = (
    "lamina chart base_color",
    f"against adding at {', '.join(f'{t:g}' for t in THETA_DEG)} degrees, {COLORS} colors of seed {_SEED}",
    "own: bakes of each color alone",
    "albedo: relative, worst view, channel and color",
    "shape: cosine-weighted L1 over albedo, worst channel",
)


def chart(folder: Path, report: Report) -> None:
    """Write base_color.csv for the stacks of the paper and the suite that have a Lambert base and layers."""
    table = folder / "base_color.csv"
    require_writable(table)
    stacks = {name: stack for name, stack in charted().items() if stack.layers and follows(stack, (BASE_COLOR,))}
    rows = []
    for i, (name, stack) in enumerate(stacks.items()):
        report(f"{100 * i // len(stacks):3} % {name}")
        rows.append([name, *_row(stack)])
    write_table(table, _HEADING, COLUMNS, rows, report)
    numbers = np.array([[float(cell) for cell in row[2:]] for row in rows])
    ratio = np.median(numbers[:, 2] / numbers[:, 5])
    report(
        f"albedo: worst {100 * np.max(numbers[:, 0]):.2g} %; shape over that of bakes of one color: median {ratio:.2f}, worst {np.max(numbers[:, 2] / numbers[:, 5]):.2f}"
    )


def _row(stack: Stack) -> list[str]:
    followed = make_lobe_set(stack, "baked", live=(BASE_COLOR,)).lobe_set
    assert isinstance(followed, TableLobes), "stacks are those that are followed"
    rng = np.random.default_rng(_SEED)
    found: list[tuple[Errors, Errors]] = []
    for _ in range(COLORS):
        here = BASE_COLOR.with_value(stack, tuple(rng.uniform(0.02, 0.98, 3)))
        estimator = ErrorEstimator(here, truth_of(here), np.cos(np.radians(THETA_DEG)))
        found.append((estimator.errors(followed.with_values_of(here)), estimator.errors(make_lobe_set(here, "baked").lobe_set)))
    cells = [np.array([(np.max(e.albedo), np.max(e.shape), np.median(e.shape)) for e in errors]) for errors in zip(*found)]
    return [str(followed.lobe_count), *(f"{value:.5f}" for part in cells for value in (*np.max(part[:, :2], axis=0), np.median(part[:, 2])))]
