# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart presets`: how far what Cycles renders of each preset lies from the truth, in the tier that is the default."""

from pathlib import Path

from ...addon.cli.stack_errors import THETA_DEG, StackErrors, errors_of
from ...reference_py.atomic import require_writable
from ...reference_py.lobes.methods import DEFAULT_METHOD
from ...reference_py.material import presets
from ..tables import Report, write_table
from .output import print_table

COLUMNS = ("preset", "chosen", "closures", "truth", "albedo_worst", "albedo_stderr", "shape_worst")
_HEADING = (
    "lamina chart presets",
    f"tier {DEFAULT_METHOD} at {', '.join(f'{t:g}' for t in THETA_DEG)} degrees",
    "albedo: relative, worst view and channel",
    "shape: cosine-weighted L1 over albedo, worst view and channel",
    "with coverage: the worst patch",
    "position_free: walks, with the largest standard error of the albedo's ratio",
)


def chart(folder: Path, report: Report) -> None:
    """Write preset_errors.csv and print it."""
    table = folder / "preset_errors.csv"
    require_writable(table)
    rows = []
    for i, name in enumerate(presets.names()):
        report(f"{100 * i // len(presets.names()):3} % {name}")
        rows.append([name, *_cells(errors_of(presets.load(name)))])
    write_table(table, _HEADING, COLUMNS, rows, report)
    print_table(COLUMNS, rows)


def _cells(errors: StackErrors) -> list[str]:
    shape = "" if errors.shape is None else f"{errors.shape:.5f}"
    return [errors.chosen, str(errors.closures), errors.truth, f"{errors.albedo:.5f}", f"{errors.stderr:.5f}", shape]
