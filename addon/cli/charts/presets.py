# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart presets`: how far what Cycles renders of each preset lies from the truth, in the tier that is the default."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....reference_py import presets
from ....reference_py.atomic import require_writable
from ....reference_py.coverage import patches
from ....reference_py.frame import spherical
from ....reference_py.models import make_model
from ....reference_py.network import DEFAULT_TIER, make_network
from ....reference_py.network.choice import AutoNetwork
from ....reference_py.network.judge import Judge
from ....reference_py.network.memory import truth_of
from ....reference_py.network.unbaked import unbaked
from ....reference_py.stack import Stack
from .output import Report, print_table, write_table

THETA_DEG = np.array([0.0, 30.0, 60.0, 75.0])
# Views of brushed surfaces: along the tangent and across.
_PHI_DEG = np.array([0.0, 90.0])
COLUMNS = ("preset", "chosen", "closures", "truth", "albedo_worst", "albedo_stderr", "shape_worst")
_HEADING = (
    "lamina chart presets",
    f"tier {DEFAULT_TIER} at {', '.join(f'{t:g}' for t in THETA_DEG)} degrees",
    "albedo: relative, worst view and channel",
    "shape: cosine-weighted L1 over albedo, worst view and channel",
    "with coverage: the worst patch",
    "position_free: walks, with the largest standard error of the albedo's ratio",
)


class PresetErrors(NamedTuple):
    """What the tier is for a stack, and its worst errors as shares; `shape` is None where the truth is walks.

    `stderr` is the albedo's standard error, 0 where the truth has no noise.
    """

    chosen: str
    closures: int
    truth: str
    albedo: float
    stderr: float
    shape: float | None


def errors_of(stack: Stack) -> PresetErrors:
    """Errors of the default tier against the truth that knows the stack's features."""
    network = make_network(stack, DEFAULT_TIER)
    return _against_walks(stack, network) if unbaked(stack) else _against_adding(stack, network)


def _against_adding(stack: Stack, network) -> PresetErrors:
    found, labels = [], []
    for patch in patches(stack):
        part = AutoNetwork(patch.stack)
        labels.append(part.choice.chosen.label)
        found.append(Judge(patch.stack, truth_of(patch.stack), np.cos(np.radians(THETA_DEG))).errors(part))
    albedo, shape = (max(float(np.max(getattr(e, name))) for e in found) for name in ("albedo", "shape"))
    return PresetErrors(" and ".join(dict.fromkeys(labels)), network.lobe_count, "adding", albedo, 0.0, shape)


def _against_walks(stack: Stack, network) -> PresetErrors:
    wo = spherical(np.radians(THETA_DEG)[:, None], np.radians(_PHI_DEG)).reshape(-1, 3)
    truth, stderr = make_model("position_free", stack).albedo_stderr(wo)
    told = make_model("mirror", stack, tier=DEFAULT_TIER).albedo(wo)
    error, noise = np.abs(told / truth - 1.0), stderr / truth
    return PresetErrors(network.resolved.tier, network.lobe_count, "position_free", float(error.max()), float(noise.max()), None)


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


def _cells(errors: PresetErrors) -> list[str]:
    shape = "" if errors.shape is None else f"{errors.shape:.5f}"
    return [errors.chosen, str(errors.closures), errors.truth, f"{errors.albedo:.5f}", f"{errors.stderr:.5f}", shape]
