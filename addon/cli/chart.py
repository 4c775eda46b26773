# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

from importlib import import_module

from ...reference_py.atomic import output_folder
from .session import say


def chart(options) -> None:
    """Write the table, and the picture if the chart has one, into a folder and print the table."""
    folder = output_folder(options.output)
    import_module(f".charts.{options.chart}", __package__).chart(folder, say("chart"))
