# SPDX-License-Identifier: GPL-3.0-or-later
"""What a figure consists of besides its picture."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Statement:
    """A sentence of the paper, how it was tested, and what came of it."""

    sentence: str
    where: str
    criterion: str
    """What counts as true, as a formula in words."""
    holds: bool
    numbers: dict[str, float]

    def text(self) -> str:
        numbers = ", ".join(f"{name} {value:.3g}" for name, value in self.numbers.items())
        return f'{"holds" if self.holds else "FAILS"}: "{self.sentence}" ({self.where}); {self.criterion}: {numbers}'


@dataclass(frozen=True)
class FigureData:
    """The numbers of one figure."""

    name: str
    title: str
    statements: tuple[Statement, ...]
    columns: tuple[str, ...]
    rows: list[tuple]
    """One tuple of texts and numbers per row of the table."""
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    """What the picture shows."""


def is_increasing(values) -> bool:
    return bool(np.all(np.diff(np.asarray(values, float)) > 0.0))
