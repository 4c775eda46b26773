# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets over axes of live parameters as stock nodes have them: tables over the view and rows of the axes.

An image holds them, so rows are many and cost nothing. All is linear between rows and views, energies too: where two lobes change places their
sum stays, of which roots would lose most. On an axis of colors energies are read at each channel's own coordinate, and what channels share at one.
"""

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ..material.place import Place
from ..material.stack import Stack
from .axes import Axis, AzimuthAxis, IndexAxis, NumberAxis, Scale, brushing_of, has_waves, top_index
from .closure import fresnel_share
from .live_grid import MIN_ALPHA, LiveLobe, LiveLobes, LogEnergy, at_azimuths, curve_now
from .lobe import ConductorCurve, DielectricCurve, DiffuseLobe, GlossyLobe
from .view_table import BASE_COLOR, KNOTS, MIN_COS_O, interpolate, knot_cosines

# Up to this alpha a folded Fresnel curve moves less than 5 % of a lobe's light, by less than its width.
NARROWEST_CURVE = 0.01
# Roots that differ by less are one, but for how they were interpolated.
_SAME = 1e-9
# Rows of one axis, of two and of three.
_ROWS = {1: (64,), 2: (41, 17), 3: (33, 13, 13)}
# The same with a roughness, a color and the azimuth: what a brushed top reflects across its brushing changes fastest.
_ROWS_OF_BRUSHED = _ROWS | {3: (33, 17, 13)}
# The same, of an axis of numbers and of one of colors, beside one of waves, which has as many as energies have knots.
_ROWS_BESIDE_WAVES = {False: 25, True: 33}
# What a Fresnel curve makes of a lobe is smooth in its width and index, and takes long: knots of an axis that changes these, by how many do.
_FOLDED = {0: 2, 1: 25, 2: 13, 3: 9}
# Of the azimuth from a brushing.
_FOLDED_TURNS = 9


@dataclass(frozen=True, eq=False, repr=False)
class LiveTable:
    """One lobe over rows of the axes, arrays with these first: `energy` (..., KNOTS, 3), or None where the weight is 1.

    A glossy lobe's weight is its energy over `unit` (..., KNOTS, 1), or the energy where that is None; `shape` (..., KNOTS, 3) has the columns of
    `LiveLobe.shape`. All diffuse light over a base of a live color c is energy + through c / (1 - back c), each (..., KNOTS, 3).
    """

    energy: np.ndarray | None
    distribution: str | None = None
    shape: np.ndarray | None = None
    unit: np.ndarray | None = None
    fresnel: DielectricCurve | ConductorCurve | None = None
    through: np.ndarray | None = None
    back: np.ndarray | None = None
    normal: Place | None = None
    is_brushed: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class LiveTables:
    """A stack's lobes for all values of its axes, whose rows are at the knots of `scales`; `lobes` are those of the stack's own values."""

    stack: Stack
    axes: tuple[Axis, ...]
    scales: tuple[Scale, ...]
    tables: tuple[LiveTable, ...]
    rotation: Place | None = None
    """The rotation of the brushing, where it is live."""

    name = "baked"
    is_live = False

    @property
    def followed(self) -> tuple[Place, ...]:
        """The live values that the tables follow."""
        over_color = any(table.through is not None for table in self.tables)
        rotation = () if self.rotation is None else (self.rotation,)
        return (*(place for axis in self.axes for place in axis.live), *rotation, *([BASE_COLOR] if over_color else []))

    @property
    def is_color(self) -> bool:
        """Whether channels have coordinates of their own."""
        return any(axis.is_color for axis in self.axes)

    @property
    def brushing(self) -> float | None:
        """As `brushing_of`."""
        return brushing_of(self.axes, self.stack)

    @property
    def is_brushed(self) -> bool:
        """Whether any of the lobes turns with the surface's tangent."""
        return self.brushing is not None

    @property
    def index(self) -> IndexAxis | None:
        """The axis of the top layer's index, which its Fresnel curve follows, if there is one."""
        return top_index(self.axes)

    def with_values_of(self, stack: Stack) -> "LiveTables":
        """The same for a stack's own live values."""
        return replace(self, stack=stack)

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.tables)

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        cos_o, brushing = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0), self.brushing
        if brushing is None:
            return [self._lobe(table, *parts, cos_o, None) for table, parts in zip(self.tables, self._parts(cos_o))]
        cos_o, turned = np.broadcast_arrays(cos_o, np.abs(np.cos(np.asarray(phi, float) - brushing)))
        return [self._lobe(table, *parts, cos_o, brushing) for table, parts in zip(self.tables, at_azimuths(self._parts, cos_o, turned))]

    def _lobe(self, table: LiveTable, weight: np.ndarray, shape: np.ndarray | None, cos_o: np.ndarray, brushing: float | None) -> GlossyLobe | DiffuseLobe:
        if shape is None:
            return DiffuseLobe(weight, normal=table.normal)
        root_x, root_y, slope = np.moveaxis(shape, -1, 0)
        tilt = np.arctan(slope * np.sqrt(np.maximum(1.0 - np.square(cos_o), 0.0)))
        fresnel = curve_now(table.fresnel, self.stack, self.index)
        frame = brushing if table.is_brushed else None
        return GlossyLobe(table.distribution, weight, root_x**2, root_y**2, tilt, fresnel, frame, table.normal)

    def _parts(self, cos_o: np.ndarray, turned: float = 1.0) -> list[tuple[np.ndarray, np.ndarray | None]]:
        """(weight, shape) of every lobe at views whose azimuth from the brushing has this cosine."""
        at = [turned if isinstance(axis, AzimuthAxis) else axis.coordinate(self.stack) for axis in self.axes]
        one = [axis.shared(coordinate) for axis, coordinate in zip(self.axes, at)]
        own = [[float(np.broadcast_to(coordinate, 3)[c]) for coordinate in at] for c in range(3)]

        def energy(table):
            return np.stack([interpolate(self._at(table, place)[:, c : c + 1], cos_o)[..., 0] for c, place in enumerate(own)], axis=-1)

        def shared(table):
            return interpolate(self._at(table, one), cos_o)

        result: list[tuple[np.ndarray, np.ndarray | None]] = []
        for table in (kept(table, self.is_color) for table in self.tables):
            weight = np.ones((*cos_o.shape, 3)) if table.energy is None else energy(table.energy)
            if table.through is not None:
                color = np.clip(self.stack.base["color"], 0.0, 1.0)
                weight = weight + energy(table.through) * color / (1.0 - energy(table.back) * color)
            if table.distribution is None:
                result.append((weight, None))
                continue
            if table.unit is not None:
                weight = weight / shared(table.unit)
            result.append((weight, np.stack([self._column(column, one, cos_o) for column in np.moveaxis(table.shape, -1, 0)], axis=-1)))
        return result

    def axis_of(self, values: np.ndarray) -> int | None:
        """The axis of numbers of which values (..., KNOTS) are the coordinate: it is the root of alpha itself, whatever the rows."""
        for number, (axis, scale) in enumerate(zip(self.axes, self.scales)):
            shape = [-1 if n == number else 1 for n in range(values.ndim)]
            if isinstance(axis, NumberAxis) and np.allclose(values, np.maximum(scale.knots, MIN_ALPHA**0.5).reshape(shape), rtol=0.0, atol=1e-6):
                return number
        return None

    def _column(self, values: np.ndarray, coordinates: list[float], cos_o: np.ndarray) -> np.ndarray:
        """Of a shape, at the coordinates and at views."""
        number = self.axis_of(values)
        if number is not None:
            return np.full(cos_o.shape, max(coordinates[number], MIN_ALPHA**0.5))
        return interpolate(self._at(values[..., None], coordinates), cos_o)[..., 0]

    def _at(self, table: np.ndarray, coordinates: list[float]) -> np.ndarray:
        return reduce(lambda part, place: np.tensordot(_hats(*place)[0], part, 1), zip(self.scales, coordinates), table)


def kept(table: LiveTable, is_color: bool) -> LiveTable:
    """The table as it is kept: where channels have no coordinates of their own, with the weight in the place of the energy."""
    return replace(table, energy=table.energy / table.unit, unit=None) if table.unit is not None and not is_color else table


def live_tables(lobe_set: LiveLobes, keep_dielectrics: bool = False) -> LiveTables:
    """A grid of lobes in tables; `keep_dielectrics` leaves the top lobe its Fresnel curve, which else is folded into its energy. A metal keeps its own."""
    axes = tuple(sorted(lobe_set.axes, key=lambda axis: not axis.is_color))  # the same row for all channels, where there are two
    rows = _ROWS if lobe_set.brushing is None else _ROWS_OF_BRUSHED
    counts = [_ROWS_BESIDE_WAVES[axis.is_color] for axis in axes] if has_waves(axes) else rows[len(axes)]
    scales = tuple(_rows(axis, count) for axis, count in zip(axes, counts))
    grid = _Grid(lobe_set, axes, scales)
    total = grid.exponential(lobe_set.log_sum)
    return LiveTables(lobe_set.stack, axes, scales, tuple(_table(grid, lobe_set, lobe, total, keep_dielectrics) for lobe in lobe_set.grid), lobe_set.rotation)


def _table(grid: "_Grid", lobe_set: LiveLobes, lobe: LiveLobe, total: np.ndarray, keep_dielectrics: bool) -> LiveTable:
    return replace(_upright(grid, lobe_set, lobe, total, keep_dielectrics), normal=lobe.normal, is_brushed=lobe.is_brushed)


def _upright(grid: "_Grid", lobe_set: LiveLobes, lobe: LiveLobe, total: np.ndarray, keep_dielectrics: bool) -> LiveTable:
    if isinstance(lobe.energy, LogEnergy):
        energy = grid.exponential(lobe.energy)
        return LiveTable(energy, lobe.distribution, np.zeros_like(energy))
    energy = None if lobe.energy is None else total * grid.values(lobe.energy)
    if lobe.is_diffuse:
        if lobe_set.base is None:
            return LiveTable(energy)
        return LiveTable(energy, through=grid.exponential(lobe_set.base.log_through), back=grid.exponential(lobe_set.base.log_back))
    shape = grid.values(lobe.shape)
    shape[..., :2] = np.clip(shape[..., :2], MIN_ALPHA**0.5, 1.0)
    if lobe.fresnel is None:
        return LiveTable(energy, lobe.distribution, shape, grid.values(lobe.unit, "fine" if has_waves(grid.axes) else "knots"))
    if isinstance(lobe.fresnel, ConductorCurve) or (keep_dielectrics and not lobe.is_brushed and np.max(shape[..., 0]) ** 2 > NARROWEST_CURVE):
        return LiveTable(None, lobe.distribution, shape, fresnel=lobe.fresnel)
    return LiveTable(_folded(lobe_set.stack, grid.axes, grid.scales, lobe, shape[..., 0, :2]), lobe.distribution, shape)


def _folded(stack: Stack, axes: tuple[Axis, ...], scales: tuple[Scale, ...], lobe: LiveLobe, roots: np.ndarray) -> np.ndarray:
    """The share (..., KNOTS, 3) that a Fresnel curve leaves of a lobe of these roots of alpha (..., 2), which are the same at all views."""
    turns = [isinstance(axis, AzimuthAxis) and lobe.is_brushed for axis in axes]
    changes = [axis is top_index(axes) or bool(np.any(np.ptp(roots, axis=number) > _SAME)) for number, axis in enumerate(axes)]
    counts = [_FOLDED_TURNS if turned else _FOLDED[sum(changes)] if changed else 2 for turned, changed in zip(turns, changes)]
    knots = [replace(scale, count=count) for scale, count in zip(scales, counts)]
    at_knots = reduce(lambda part, n: _resampled(part, n, scales[n], knots[n].knots), range(len(axes)), roots)
    known: dict[tuple, np.ndarray] = {}

    def share(place: tuple[int, ...]) -> np.ndarray:
        (alpha_x, alpha_y), eta, frame = np.square(at_knots[place]).tolist(), lobe.fresnel.eta, None
        for axis, scale, i, is_turned in zip(axes, knots, place, turns):
            if axis is top_index(axes):
                eta = float(axis.live[0].value(axis.at(stack, scale.knots[i])))
            if is_turned:
                frame = -float(np.arccos(scale.knots[i]))
        key = alpha_x, alpha_y, eta, frame
        if key not in known:
            ones = np.ones(KNOTS)
            curved = GlossyLobe(lobe.distribution, np.ones(3), alpha_x * ones, alpha_y * ones, fresnel=DielectricCurve(eta), frame=frame)
            known[key] = fresnel_share(curved, knot_cosines())
        return known[key]

    # amplitudes, which change evenly with an index
    size = at_knots.shape[:-1]
    table = np.sqrt(np.stack([share(place) for place in np.ndindex(size)])).reshape(*size, KNOTS, 3)
    return np.square(reduce(lambda part, n: _resampled(part, n, knots[n], scales[n].knots), range(len(axes)), table))


def _rows(axis: Axis, count: int) -> Scale:
    """So many rows, from the least coordinate of a value: knots before the first that is fitted may lie below."""
    low = max(axis.knots.low, 0.0) if axis.before else axis.knots.low
    return Scale(low, axis.knots.high, axis.fine.count if axis.has_waves else count, axis.fine.bend)


class _Grid:
    """What a grid of lobes holds at the rows of tables, with equal coordinates in all channels; axes are turned to the tables' order."""

    def __init__(self, lobe_set: LiveLobes, axes: tuple[Axis, ...], scales: tuple[Scale, ...]):
        self.axes, self.scales = axes, scales
        self._order = [lobe_set.axes.index(axis) for axis in axes]
        self._coefficients = None if lobe_set.coefficients is None else self.values(lobe_set.coefficients, "cross")

    def values(self, table: np.ndarray, which: str = "knots") -> np.ndarray:
        """Rows of a table (..., c) over these knots of the axes."""
        table = np.moveaxis(table, self._order, range(len(self._order)))
        for number, (axis, scale) in enumerate(zip(self.axes, self.scales)):
            is_same = table.shape[number] == 1
            table = np.repeat(table, scale.count, number) if is_same else _resampled(table, number, getattr(axis, which), scale.knots)
        return table

    def exponential(self, log: LogEnergy) -> np.ndarray:
        """Rows of an energy."""
        total = 0.0
        for number, (i, axis, scale) in enumerate(zip(self._order, self.axes, self.scales)):
            table = _resampled(log.along[i], 0, axis.fine, scale.knots)
            total = total + table.reshape([-1 if n == number else 1 for n in range(len(self.axes))] + [KNOTS, 3])
        if log.modes is not None:
            total = total + np.tensordot(self._coefficients, log.modes, 1)
        return log.of(total)


def _resampled(table: np.ndarray, number: int, scale: Scale, coordinates: np.ndarray) -> np.ndarray:
    """A table at other coordinates of one of its axes."""
    return np.moveaxis(np.tensordot(_hats(scale, coordinates), table, (1, number)), 0, number)


def _hats(scale: Scale, coordinates) -> np.ndarray:
    """What of each knot is in coordinates (n,): (n, knots)."""
    cell, along = scale.place(np.atleast_1d(coordinates))
    knots = np.arange(scale.count)
    return np.where(knots == cell[:, None], 1.0 - along[:, None], 0.0) + np.where(knots == cell[:, None] + 1, along[:, None], 0.0)
