# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

from importlib import import_module

from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from .session import say

_TAKING = {"surface": ("pareto", "viewport"), "rounds": ("pareto",)}


def chart(options) -> None:
    """Write the table, and the picture if the chart has one, into a folder and print the table."""
    given = {name: value for name in ("surface", "rounds") if (value := getattr(options, name)) is not None}
    for name in given:
        if options.chart not in _TAKING[name]:
            raise LaminaError(f"--{name} goes with the chart {' or '.join(_TAKING[name])}, not with {options.chart}")
    folder = output_folder(options.output)
    import_module(f".charts.{options.chart}", __package__).chart(folder, say("chart"), **given)
