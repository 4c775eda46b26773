# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets as tables over the view: what a baked shader holds, and what curves of stock nodes can say.

Knots are even in sqrt(cos_theta_o), which is dense at grazing where energies turn; between them all is linear.
A tilt is kept as its tangent over sin(theta_o), which is smooth at the normal.
Where weights depend on the azimuth of the view, a table has one sheet for each of AZIMUTHS; between them all is linear in the
cosine from the axis of symmetry, `axis` in radians from the tangent. That is good to .7 % of a weight up to 80 degrees.
`normal` is the own normal that a table is about (`own_normals`), None for the surface's.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..material.place import Place
from ..material.stack import Stack
from ..optics.diffuse import OREN_NAYAR_POWER, oren_nayar_albedo, oren_nayar_color
from .lobe import DielectricCurve, DiffuseLobe, GlossyLobe
from .own_normals import BELOW, DIFFUSE, TOP, normals_of_fits

KNOTS = 24
# Cosines of the view's azimuth from the axis, on places of a ramp's 256: dense where energies turn.
AZIMUTH_PLACES = (0, 22, 73, 113, 168, 250)
AZIMUTHS = np.array(AZIMUTH_PLACES) / AZIMUTH_PLACES[-1]
# The color of the base, where a table follows it.
BASE_COLOR = Place(None, "color")
# The slope deviation of an Oren-Nayar base, where nodes follow it.
BASE_SLOPES = Place(None, "sigma_deg")
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
    place -= cell
    columns = table.T
    # column by column, which is fastest
    values = np.empty((len(columns), *cell.shape))
    for i, (low, rise) in enumerate(zip(columns, columns[:, 1:] - columns[:, :-1])):
        value = values[i, ...]
        rise.take(cell, out=value, mode="clip")
        value *= place
        value += low.take(cell, mode="clip")
    return np.moveaxis(values, 0, -1)


def weight_at(table: np.ndarray, cos_theta_o: np.ndarray, phi: np.ndarray | float, axis: float | None) -> np.ndarray:
    """Weights (..., 3) of a table (KNOTS, 3), or, of one with an axis, (AZIMUTHS, KNOTS, 3), at views of azimuth phi (...)."""
    if axis is None:
        return interpolate(table, cos_theta_o)
    cos_phi = np.abs(np.cos(np.asarray(phi) - axis))
    shares = [np.interp(cos_phi, AZIMUTHS, row) for row in np.eye(len(AZIMUTHS))]
    return sum(share[..., None] * interpolate(sheet, cos_theta_o) for share, sheet in zip(shares, table))


@dataclass(frozen=True, eq=False, repr=False)
class GlossyTable:
    """A glossy lobe: `weight` (KNOTS, 3) or, with an `axis`, (AZIMUTHS, KNOTS, 3); `shape` (KNOTS, 3) of alpha_x, alpha_y and tan(tilt) / sin(theta_o).

    `frame` is that of `GlossyLobe`.
    """

    distribution: str
    weight: np.ndarray
    shape: np.ndarray
    fresnel: DielectricCurve | None = None
    frame: float | None = None
    axis: float | None = None
    normal: Place | None = None

    @property
    def is_mirror(self) -> bool:
        """Whether it is one at every view."""
        return not np.any(self.shape)

    def lobe(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> GlossyLobe:
        """The lobe at views of cosine cos_theta_o (...) and azimuth phi (...)."""
        alpha_x, alpha_y, slope = np.moveaxis(interpolate(self.shape, cos_theta_o), -1, 0)
        tilt = np.arctan(slope * np.sqrt(np.maximum(1.0 - np.square(cos_theta_o), 0.0)))
        weight = weight_at(self.weight, cos_theta_o, phi, self.axis)
        return GlossyLobe(self.distribution, weight, alpha_x, alpha_y, tilt, self.fresnel, self.frame, self.normal)


@dataclass(frozen=True, eq=False, repr=False)
class DiffuseTable:
    """A Lambert lobe of `weight` (KNOTS, 3) or, with an `axis`, (AZIMUTHS, KNOTS, 3); with a `ramp` (8, 3) one of `diffuse_ramp`."""

    weight: np.ndarray
    axis: float | None = None
    normal: Place | None = None
    ramp: np.ndarray | None = None

    def lobe(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> DiffuseLobe:
        """The lobe at views of cosine cos_theta_o (...) and azimuth phi (...)."""
        return DiffuseLobe(weight_at(self.weight, cos_theta_o, phi, self.axis), normal=self.normal, ramp=self.ramp)


@dataclass(frozen=True, eq=False, repr=False)
class OrenNayarTable:
    """An Oren-Nayar lobe whose colour `weight` (KNOTS, 3) depends on the view, as stock nodes have it; `power` as in `DiffuseLobe`."""

    weight: np.ndarray
    sigma_deg: float
    power: int = OREN_NAYAR_POWER
    axis: float | None = None
    normal: Place | None = None

    def lobe(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> DiffuseLobe:
        """The lobe at views of cosine cos_theta_o (...) and azimuth phi (...)."""
        return DiffuseLobe(np.ones(3), weight_at(self.weight, cos_theta_o, phi, self.axis), self.sigma_deg, self.power, self.normal)


@dataclass(frozen=True, eq=False, repr=False)
class RoughBase:
    """A bare Oren-Nayar base, which needs no table: stock nodes compute with its color and its slope deviation, of which `color` (3,) and `sigma_deg` are the present ones.

    `power` is that of `DiffuseLobe`; where nodes have no rough diffuse lobe it `is_lambert`. Its energy is the model's in any case.
    """

    color: np.ndarray
    sigma_deg: float
    power: int = OREN_NAYAR_POWER
    normal: Place | None = None
    is_lambert: bool = False

    @property
    def weight(self) -> np.ndarray:
        """(3,), that of no layers."""
        return np.clip(self.color, 0.0, 1.0)

    def lobe(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> DiffuseLobe:
        """The lobe at views of cosine cos_theta_o (...) and azimuth phi (...)."""
        energy = oren_nayar_albedo(cos_theta_o, self.weight, self.sigma_deg)
        if self.is_lambert:
            return DiffuseLobe(energy, normal=self.normal)
        return DiffuseLobe(np.ones(3), oren_nayar_color(cos_theta_o, energy, self.sigma_deg, self.power), self.sigma_deg, self.power, self.normal)


@dataclass(frozen=True, eq=False, repr=False)
class BaseColorTable:
    """A fitted lobe of a stack over a diffuse base, for all its colors c: of weight own + through c / (1 - back c), and Lambert where it has no distribution.

    `own` (KNOTS, 3) is that of the layers. `through` (KNOTS, 3) is this lobe's part of the light at a view that gets down to the base and, reflected there
    once by white, up again. Lobes together have no less than none; one may have less over white than over black. `back` (KNOTS, 3) is what of the base's light
    the layers send back to it, for all lobes of a stack, and over a Lambert base at all views the same. `color` (3,) is the present one, of which only 0 to 1 counts.
    `shape` is that of `GlossyTable`, `ramp` that of `DiffuseTable`.
    """

    own: np.ndarray
    through: np.ndarray
    back: np.ndarray
    color: np.ndarray
    normal: Place | None = None
    distribution: str | None = None
    shape: np.ndarray | None = None
    ramp: np.ndarray | None = None

    @property
    def weight(self) -> np.ndarray:
        """(KNOTS, 3)."""
        color = np.clip(self.color, 0.0, 1.0)
        return np.maximum(self.own + self.through * color / (1.0 - self.back * color), 0.0)

    @property
    def now(self) -> "GlossyTable | DiffuseTable":
        """The table for the present color alone."""
        if self.distribution is None:
            return DiffuseTable(self.weight, normal=self.normal, ramp=self.ramp)
        return GlossyTable(self.distribution, self.weight, self.shape, normal=self.normal)

    def lobe(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> GlossyLobe | DiffuseLobe:
        """The lobe at views of cosine cos_theta_o (...) and azimuth phi (...)."""
        return self.now.lobe(cos_theta_o, phi)


@dataclass(frozen=True, eq=False, repr=False)
class TableLobes:
    """A lobe set whose lobes are tables; `stock` is what stock nodes have in its place, which know no ramps, where they are not to have the same with Lambert's lobe."""

    tables: tuple[GlossyTable | DiffuseTable | OrenNayarTable | RoughBase | BaseColorTable, ...]
    stock: "TableLobes | None" = None

    name = "baked"
    is_live = False

    @property
    def has_ramps(self) -> bool:
        """Whether stock nodes have something else."""
        return any(getattr(table, "ramp", None) is not None for table in self.tables)

    @property
    def followed(self) -> tuple[Place, ...]:
        """The live values that the tables follow."""
        if any(isinstance(table, RoughBase) for table in self.tables):
            return (BASE_COLOR, BASE_SLOPES)
        return (BASE_COLOR,) if any(isinstance(table, BaseColorTable) for table in self.tables) else ()

    @property
    def is_brushed(self) -> bool:
        """Whether any of them turns with the surface's tangent."""
        return any(getattr(table, "axis", None) is not None or getattr(table, "frame", None) is not None for table in self.tables)

    def with_values_of(self, stack: Stack) -> "TableLobes":
        """The same for a stack's own live values and normals."""
        normals = normals_of_fits(stack, [_kind(table) for table in self.tables])
        tables = [replace(table, normal=normal) for table, normal in zip(self.tables, normals)]
        tables = [replace(t, color=np.array(stack.base["color"])) if isinstance(t, BaseColorTable) else t for t in tables]
        return TableLobes(tuple(tables), self.stock and self.stock.with_values_of(stack))

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.tables)

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        cos_o = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0)
        return [table.lobe(cos_o, phi) for table in self.tables]


def is_glossy(table) -> bool:
    """Whether a table is of a glossy lobe."""
    return isinstance(table, GlossyTable) or (isinstance(table, BaseColorTable) and table.distribution is not None)


def _kind(table) -> str:
    """What a fitted lobe is (`own_normals`)."""
    if not is_glossy(table):
        return DIFFUSE
    if isinstance(table, BaseColorTable):
        return BELOW
    return TOP if table.fresnel is not None or table.is_mirror else BELOW
