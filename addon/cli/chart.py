# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

from importlib import import_module

from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from .session import say


def chart(options) -> None:
    """Write the table, and the picture if the chart has one, into a folder and print the table."""
    given = {name: value for name in ("surface", "rounds") if (value := getattr(options, name)) is not None}
    if given and options.chart != "pareto":
        raise LaminaError(f"--{next(iter(given))} goes with the chart pareto, not with {options.chart}")
    folder = output_folder(options.output)
    import_module(f".charts.{options.chart}", __package__).chart(folder, say("chart"), **given)
