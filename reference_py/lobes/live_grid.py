# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked lobe sets over axes of live parameters: tables over the view at every knot of those.

Between knots all is linear but energies, of which a logarithm is, as absorption is exponential. Widths are kept as roughness (the root of
alpha), so that a lobe whose width is a live roughness itself is exact. Below the first knot that is fitted widths go on as they began and
the rest stays. On an axis of colors energies are read at each channel's own coordinate. Energies know more knots than shapes, as eyes see them first.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ..material.place import Place
from ..material.stack import Stack
from .axes import Axis, AzimuthAxis, Scale, brushing_of, has_waves, top_index
from .diffuse_ramp import RAMP_COSINES
from .lobe import ConductorCurve, DielectricCurve, DiffuseLobe, GlossyLobe
from .own_normals import BELOW, DIFFUSE, TOP, normals_of_fits
from .view_table import BASE_COLOR, MIN_COS_O, interpolate

# Less is nothing to Cycles.
MIN_ENERGY = 1e-7
# Beside what a top reflects less is not seen: an energy with so much more has a logarithm that is nearly even.
FLOOR = 0.005
# Places of the tables' numbers, and of the coefficients: a shader's text has thousands.
DIGITS, COEFFICIENT_DIGITS = 4, 3
# A narrower alpha is a mirror to Cycles.
MIN_ALPHA = 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class LogEnergy:
    """The logarithm of an energy + FLOOR on the grid: a sum of one table along each axis, at its fine knots, and of what these leave.

    `along` has a (fine, KNOTS, 3) for each axis. What they leave is a sum of `modes` (n, KNOTS, 3), each times its coefficient, which all energies of a
    lobe set share (`LiveLobes.coefficients`); one axis leaves nothing, and has no modes. Where not `is_log` the sum is the energy itself:
    interference takes nearly all of it at some values, beside which a logarithm is far from even.
    """

    along: tuple[np.ndarray, ...]
    modes: np.ndarray | None = None
    is_log: bool = True

    def of(self, total: np.ndarray) -> np.ndarray:
        """The energy of which this is the sum."""
        return np.maximum(np.exp(total) - FLOOR if self.is_log else total, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class LiveLobe:
    """One lobe on the grid, arrays with the axes first: `energy` and `shape` (..., KNOTS, 3), `unit` (..., KNOTS, 1).

    A fitted lobe's `energy` is its share of what these have together, and `unit` the energy that it has with weight 1. A mirror has no
    shape, and its energy as a logarithm; the lobe that is exact for a rough top has none: its weight is 1. Beside an axis of waves, along which
    shapes are the same, `unit` is (1, fine, KNOTS, 1), as there are fewer knots of shapes than energies need.
    Columns of the shape: roots of alpha along and across, and tan(tilt) / sin(theta_o).
    """

    energy: np.ndarray | LogEnergy | None
    distribution: str | None = None
    shape: np.ndarray | None = None
    fresnel: DielectricCurve | ConductorCurve | None = None
    unit: np.ndarray | None = None
    normal: Place | None = None
    """The own normal that it is about (`own_normals`), None for the surface's."""
    is_brushed: bool = False
    """Whether its alphas are along and across the brushing, and not the plane of incidence."""

    @property
    def is_specular(self) -> bool:
        """Whether it is a mirror at every knot."""
        return isinstance(self.energy, LogEnergy)

    @property
    def kind(self) -> str:
        """What it is (`own_normals`)."""
        if self.is_diffuse:
            return DIFFUSE
        return TOP if self.fresnel is not None or self.is_specular else BELOW

    @property
    def is_diffuse(self) -> bool:
        """Whether it is a Lambert lobe."""
        return self.distribution is None


@dataclass(frozen=True, eq=False, repr=False)
class LiveRamp:
    """Ramps of `diffuse_ramp`: Lambert's, and of each of `modes` (n, 8) so much as `amounts` (..., n, 3) has at the knots of the axes, which come first."""

    modes: np.ndarray
    amounts: np.ndarray

    def at(self, amounts: np.ndarray) -> np.ndarray:
        """The ramp (8, 3) of amounts (n, 3)."""
        return np.maximum(RAMP_COSINES[:, None] + self.modes.T @ amounts, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class LiveBase:
    """What a diffuse base of any color adds (`BaseColorTable`) on the grid: the logarithms of `through` and of `back`.

    `is_live` tells whether the color is a live value.
    """

    log_through: LogEnergy
    log_back: LogEnergy
    is_live: bool = True


@dataclass(frozen=True, eq=False, repr=False)
class LiveLobes:
    """A stack's lobes for all values of its axes; `lobes` are those of the stack's own values.

    `log_sum` is what the fitted lobes have in energy together. Where there is a `base`, that is over black, and the base's light is in the
    Lambert lobe. `coefficients` (..., n) of the modes of energies are at the `cross` knots of all axes; None with one axis.
    """

    stack: Stack
    axes: tuple[Axis, ...]
    grid: tuple[LiveLobe, ...]
    log_sum: LogEnergy
    coefficients: np.ndarray | None = None
    base: LiveBase | None = None
    rotation: Place | None = None
    """The rotation of the brushing, where it is live."""
    ramp: LiveRamp | None = None
    """Where the light of the Lambert lobe goes. What turns with a brushing has none."""
    stock: "LiveLobes | None" = None
    """What stock nodes have in its place, which know no ramps, where they are not to have the same with Lambert's lobe; of a bare metal what Blenders have that do not know its curve."""

    name = "baked"
    is_live = False

    @property
    def followed(self) -> tuple[Place, ...]:
        """The live values that the tables follow."""
        rotation = () if self.rotation is None else (self.rotation,)
        return (*(place for axis in self.axes for place in axis.live), *rotation, *([BASE_COLOR] if self.base is not None and self.base.is_live else []))

    @property
    def brushing(self) -> float | None:
        """As `brushing_of`."""
        return brushing_of(self.axes, self.stack)

    @property
    def is_brushed(self) -> bool:
        """Whether any of the lobes turns with the surface's tangent."""
        return self.brushing is not None

    @property
    def index(self) -> Axis | None:
        """The axis of the top layer's index, which its Fresnel curve follows, if there is one."""
        return top_index(self.axes)

    def with_values_of(self, stack: Stack) -> "LiveLobes":
        """The same for a stack's own live values and normals."""
        normals = normals_of_fits(stack, [lobe.kind for lobe in self.grid])
        grid = tuple(replace(lobe, normal=normal) for lobe, normal in zip(self.grid, normals))
        return replace(self, stack=stack, grid=grid, stock=self.stock and self.stock.with_values_of(stack))

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.grid)

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        cos_theta_o = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0)
        grid = [replace(lobe, fresnel=curve_now(lobe.fresnel, self.stack, self.index)) for lobe in self.grid]
        brushing = self.brushing
        if brushing is None:
            ramp = self._ramp()
            return [_lobe(lobe, *parts, cos_theta_o, None, ramp) for lobe, parts in zip(grid, self._parts(cos_theta_o))]
        cos_theta_o, turned = np.broadcast_arrays(cos_theta_o, np.abs(np.cos(np.asarray(phi, float) - brushing)))
        parts = at_azimuths(self._parts, cos_theta_o, turned)
        return [_lobe(lobe, *part, cos_theta_o, brushing) for lobe, part in zip(grid, parts)]

    def lambert_light(self, cos_theta: np.ndarray) -> np.ndarray:
        """What the Lambert lobe's light is in proportion to, (n, 3), for cosines (n,), where nothing is brushed: what gets to a base of a live color and out again, or all that is fitted."""
        return self._energies()(self.log_sum if self.base is None else self.base.log_through, cos_theta)

    @property
    def knows_metal(self) -> bool:
        """Whether a lobe has a metal's curve."""
        return any(isinstance(lobe.fresnel, ConductorCurve) for lobe in self.grid)

    def _ramp(self) -> np.ndarray | None:
        if self.ramp is None:
            return None
        places = [_by_channel(axis.knots, axis.coordinate(self.stack)) for axis in self.axes]
        amounts = [blended(self.ramp.amounts[..., c], [(i[c], t[c]) for i, t in places]) for c in range(3)]
        return self.ramp.at(np.stack(amounts, axis=-1))

    def _coordinates(self, turned: float) -> list:
        """Where the axes are read, of views whose azimuth from the brushing has this cosine."""
        return [turned if isinstance(axis, AzimuthAxis) else axis.coordinate(self.stack) for axis in self.axes]

    def _energies(self, turned: float = 1.0) -> Callable[[LogEnergy, np.ndarray], np.ndarray]:
        """Energies (..., 3) at the live values, for views of cosines (...)."""
        fine, cross = ([_by_channel(getattr(axis, scale), at) for axis, at in zip(self.axes, self._coordinates(turned))] for scale in ("fine", "cross"))
        left = None if self.coefficients is None else [blended(self.coefficients, [(i[c], t[c]) for i, t in cross]) for c in range(3)]

        def energy(log: LogEnergy, cos_theta_o: np.ndarray) -> np.ndarray:
            total = sum(_color(table, [place], cos_theta_o) for table, place in zip(log.along, fine))
            if left is not None:
                total = total + interpolate(np.stack([left[c] @ log.modes[..., c].reshape(len(left[c]), -1) for c in range(3)], axis=-1), cos_theta_o)
            return log.of(total)

        return energy

    def _parts(self, cos_theta_o, turned: float = 1.0):
        """(weight, shape) of every lobe at views whose azimuth from the brushing has this cosine."""
        coordinates = self._coordinates(turned)
        # the channels' places, and the one that shapes are read at
        each, one = (
            [_by_channel(axis.knots, at) for axis, at in zip(self.axes, coordinates)],
            [axis.knots.place(axis.shared(at)) for axis, at in zip(self.axes, coordinates)],
        )

        def shared(array, places=one):
            return interpolate(blended(array, places), cos_theta_o)

        where_units = one
        if has_waves(self.axes):
            where_units = [axis.fine.place(axis.shared(at)) for axis, at in zip(self.axes, coordinates)]
        energy = self._energies(turned)
        total = energy(self.log_sum, cos_theta_o)
        result = []
        for lobe in self.grid:
            if lobe.energy is None:
                weight = np.ones_like(total)
            elif isinstance(lobe.energy, LogEnergy):
                weight = energy(lobe.energy, cos_theta_o)
            else:
                weight = total * _color(lobe.energy, each, cos_theta_o) / shared(lobe.unit, where_units)
            shape = None
            if lobe.is_diffuse and self.base is not None:
                base = np.clip(self.stack.base["color"], 0.0, 1.0)
                weight = weight + energy(self.base.log_through, cos_theta_o) * base / (1.0 - energy(self.base.log_back, cos_theta_o) * base)
            if lobe.shape is not None:
                shape = shared(lobe.shape)
            result.append((weight, shape))
        return result


def at_azimuths(parts: Callable, cos_theta_o: np.ndarray, turned: np.ndarray) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """`parts` (weight and shape of lobes at views of one azimuth) at views of cosines (...) from the normal and, of their azimuth, from the brushing (...)."""
    found: list[tuple[np.ndarray, np.ndarray | None]] = []
    for one in np.unique(turned):
        here = turned == one
        for number, values in enumerate(parts(cos_theta_o[here], float(one))):
            if number == len(found):
                found.append(tuple(None if value is None else np.empty((*turned.shape, 3)) for value in values))
            for whole, value in zip(found[number], values):
                if whole is not None:
                    whole[here] = value
    return found


def _color(array: np.ndarray, places: list, cos_theta_o: np.ndarray) -> np.ndarray:
    """The array at views, each channel at its own places of the axes."""
    by_channel = [blended(array[..., c : c + 1], [(i[c], t[c]) for i, t in places]) for c in range(3)]
    return interpolate(np.concatenate(by_channel, axis=-1), cos_theta_o)


def _by_channel(scale: Scale, coordinate) -> tuple[np.ndarray, ...]:
    return tuple(np.broadcast_to(part, 3) for part in scale.place(coordinate))


def curve_now(curve: DielectricCurve | ConductorCurve | None, stack: Stack, index: Axis | None) -> DielectricCurve | ConductorCurve | None:
    """A lobe's curve at the live values of a stack; `index` is the axis of the top layer's, if there is one."""
    if isinstance(curve, ConductorCurve):
        return ConductorCurve.of(stack.base)
    return curve if curve is None or index is None else DielectricCurve(index.live[0].value(stack))


def _lobe(lobe: LiveLobe, weight, shape, cos_theta_o, brushing: float | None, ramp: np.ndarray | None = None):
    if lobe.is_specular:
        return GlossyLobe(lobe.distribution, weight, *(np.zeros_like(cos_theta_o) for _ in range(3)), normal=lobe.normal)
    if lobe.is_diffuse:
        return DiffuseLobe(weight, normal=lobe.normal, ramp=ramp)
    root_x, root_y, slope = np.moveaxis(shape, -1, 0)
    alpha_x, alpha_y = alpha_of(root_x), alpha_of(root_y)
    tilt = np.arctan(slope * np.sqrt(np.maximum(1.0 - np.square(cos_theta_o), 0.0)))
    return GlossyLobe(lobe.distribution, weight, alpha_x, alpha_y, tilt, lobe.fresnel, brushing if lobe.is_brushed else None, lobe.normal)


def alpha_of(root: np.ndarray) -> np.ndarray:
    """Of its root, which may go on below 0."""
    return np.clip(np.square(np.maximum(root, 0.0)), MIN_ALPHA, 1.0)


def unit_sizes(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """How many rows of each axis `LiveLobe.unit` has."""
    return tuple((1 if axis.has_waves else axis.fine.count) if has_waves(axes) else axis.knots.count for axis in axes)


def blended(array: np.ndarray, places: list) -> np.ndarray:
    """The array without its leading axes, interpolated at their places; along one of a single row all is the same."""
    return reduce(lambda part, place: part[0] if len(part) == 1 else part[place[0]] * (1.0 - place[1]) + part[place[0] + 1] * place[1], places, array)
