# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

from importlib import import_module

from ...addon.session import say
from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from . import CHARTS

_TAKING = {"surface": ("pareto", "viewport", "eevee"), "rounds": ("pareto",), "files": ("exchange",)}


def chart(options) -> None:
    """Write the table, and the picture if the chart has one, into a folder and print the table."""
    given = {name: value for name in _TAKING if (value := getattr(options, name)) is not None}
    for name in given:
        if options.chart not in _TAKING[name]:
            raise LaminaError(f"--{name} goes with the chart {' or '.join(_TAKING[name])}, not with {options.chart}")
    if given.get("rounds", 1) < 1:
        raise LaminaError(f"--rounds {options.rounds}: choose 1 or more")
    folder = output_folder(options.output)
    import_module(f"...charts.{CHARTS[options.chart]}", __name__).chart(folder, say("chart"), **given)
