# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks as tables over the view: what a baked shader holds, and what curves of stock nodes can say.

Knots are even in sqrt(cos_theta_o), which is dense at grazing where energies turn; between them all is linear.
A tilt is kept as its tangent over sin(theta_o), which is smooth at the normal.
"""

from dataclasses import dataclass

import numpy as np

from .lobe import DielectricCurve, DiffuseLobe, GlossyLobe

KNOTS = 24
# The least cosine of a view; towards the horizon tables are read at this one.
MIN_COS_O = 1e-4


def knot_cosines() -> np.ndarray:
    """View cosines (KNOTS,), from grazing to the normal."""
    return np.maximum(np.square(np.arange(KNOTS) / (KNOTS - 1.0)), MIN_COS_O)


def middle_cosines() -> np.ndarray:
    """View cosines (KNOTS - 1,) where a table is the mean of two knots."""
    return np.square((np.arange(KNOTS - 1) + 0.5) / (KNOTS - 1.0))


def interpolate(table: np.ndarray, cos_theta_o: np.ndarray) -> np.ndarray:
    """Values (..., c) of a table (KNOTS, c) at view cosines (...)."""
    place = np.sqrt(np.clip(cos_theta_o, 0.0, 1.0)) * (KNOTS - 1.0)
    cell = np.minimum(place.astype(int), KNOTS - 2)
    t = (place - cell)[..., None]
    return table[cell] * (1.0 - t) + table[cell + 1] * t


@dataclass(frozen=True)
class GlossyTable:
    """A glossy lobe: `weight` (KNOTS, 3), `shape` (KNOTS, 3) of alpha_x, alpha_y and tan(tilt) / sin(theta_o).

    `frame` is that of `GlossyLobe`; stock nodes alone know it.
    """

    distribution: str
    weight: np.ndarray
    shape: np.ndarray
    fresnel: DielectricCurve | None = None
    frame: float | None = None

    def lobe(self, cos_theta_o: np.ndarray) -> GlossyLobe:
        alpha_x, alpha_y, slope = np.moveaxis(interpolate(self.shape, cos_theta_o), -1, 0)
        tilt = np.arctan(slope * np.sqrt(np.maximum(1.0 - np.square(cos_theta_o), 0.0)))
        return GlossyLobe(self.distribution, interpolate(self.weight, cos_theta_o), alpha_x, alpha_y, tilt, self.fresnel, self.frame)


@dataclass(frozen=True)
class DiffuseTable:
    """A Lambert lobe of `weight` (KNOTS, 3)."""

    weight: np.ndarray

    def lobe(self, cos_theta_o: np.ndarray) -> DiffuseLobe:
        return DiffuseLobe(interpolate(self.weight, cos_theta_o))


@dataclass(frozen=True)
class OrenNayarTable:
    """An Oren-Nayar lobe whose colour `weight` (KNOTS, 3) depends on the view, as stock nodes have it."""

    weight: np.ndarray
    sigma_deg: float

    def lobe(self, cos_theta_o: np.ndarray) -> DiffuseLobe:
        return DiffuseLobe(np.ones(3), interpolate(self.weight, cos_theta_o), self.sigma_deg)


@dataclass(frozen=True)
class TableNetwork:
    """A network whose lobes are tables."""

    tables: tuple[GlossyTable | DiffuseTable | OrenNayarTable, ...]

    @property
    def lobe_count(self) -> int:
        return len(self.tables)

    def lobes(self, cos_theta_o: np.ndarray) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...); weights are (..., 3)."""
        cos_o = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0)
        return [table.lobe(cos_o) for table in self.tables]
