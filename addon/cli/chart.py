# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts: measured tables, and their pictures where matplotlib is installed."""

from importlib import import_module
from pathlib import Path

from .session import say


def chart(options) -> None:
    """Write the table, and the picture if the chart has one, into a folder and print the table."""
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    import_module(f".charts.{options.chart}", __package__).chart(folder, say("chart"))
