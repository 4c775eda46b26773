# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of Weidlich07, computed with the model and held against what the paper says of them.

Each module has `compute(size)`, which gives a `FigureData` (numpy; figures of colour differences also need
colour-science), and `draw(data)`, which gives a matplotlib figure. Sizes are pixels across a sphere.
"""

from importlib import import_module

from ...reference_py.errors import LaminaError
from .data import FigureData, Statement

FIGURES = ("figure3", "figure5", "figure6", "figure7", "figure8", "figure9", "spectral")


def module(name: str):
    """The module of a figure. Raises LaminaError for an unknown name."""
    if name not in FIGURES:
        raise LaminaError(f"unknown figure {name!r}; choose {', '.join(FIGURES)}")
    return import_module(f".{name}", __name__)


__all__ = ["FIGURES", "FigureData", "Statement", "module"]
