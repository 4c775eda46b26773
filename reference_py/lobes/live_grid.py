# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked lobe sets over one or two live parameters: tables over the view at every knot of those.

Between knots all is linear but the energy of the fitted lobes together, whose logarithm is, as absorption is
exponential. Widths are kept as roughness (the root of alpha), so that a lobe whose width is a live roughness itself is
exact. Below the first knot widths go on as they began and the rest stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ..errors import LaminaError
from ..material.place import Place
from ..material.stack import Stack
from .closure import unit_energy
from .lobe import DielectricCurve, DiffuseLobe, GlossyLobe
from .view_table import BASE_COLOR, KNOTS, MIN_COS_O, BaseColorTable, DiffuseTable, GlossyTable, TableLobes, interpolate, knot_cosines

# Less is nothing to Cycles.
MIN_ENERGY = 1e-7
# A narrower alpha is a mirror to Cycles.
MIN_ALPHA = 1e-4


@dataclass(frozen=True)
class Axis:
    """A live parameter: where it is, and its knots, ascending."""

    parameter: Place
    knots: tuple[float, ...]

    def place(self, value: float) -> tuple[int, float]:
        """The knot below and the way to the next; less than 0 below the first knot, at most 1 above the last."""
        i = int(np.clip(np.searchsorted(self.knots, value, side="right") - 1, 0, len(self.knots) - 2))
        return i, min((value - self.knots[i]) / (self.knots[i + 1] - self.knots[i]), 1.0)

    def value_of(self, stack: Stack) -> float:
        """The parameter's value in a stack."""
        return self.parameter.value(stack)


@dataclass(frozen=True)
class LiveLobe:
    """One lobe on the grid, arrays with the axes first: `energy` (..., KNOTS, 3), `shape` (..., KNOTS, 3), `unit` (..., KNOTS, 1).

    Columns of the shape: roots of alpha along and across, and tan(tilt) / sin(theta_o). `unit` is the energy that the lobe
    has with weight 1; None where `energy` is the weight itself, which the sum of energies does not change then.
    """

    energy: np.ndarray
    distribution: str | None = None
    shape: np.ndarray | None = None
    fresnel: DielectricCurve | None = None
    unit: np.ndarray | None = None

    @property
    def is_specular(self) -> bool:
        """Whether it is a mirror at every knot."""
        return self.shape is not None and not np.any(self.shape)


@dataclass(frozen=True)
class LiveBase:
    """What a Lambert base of a live color adds (`BaseColorTable`) on the grid: the logarithms of `through` and, at every view, `back`, both
    (..., KNOTS, 3)."""

    log_through: np.ndarray
    log_back: np.ndarray


@dataclass(frozen=True)
class LiveLobes:
    """A stack's lobes for all values of its axes; `lobes` are those of the stack's own values.

    `log_sum` (..., KNOTS, 3) is the logarithm of what the lobes with a `unit` have in energy together. Where there is a `base`, that is
    over black, and the base's light is in the Lambert lobe.
    """

    stack: Stack
    axes: tuple[Axis, ...]
    grid: tuple[LiveLobe, ...]
    log_sum: np.ndarray
    base: LiveBase | None = None

    name = "baked"

    @property
    def followed(self) -> tuple[Place, ...]:
        """The live values that the tables follow."""
        return (*(axis.parameter for axis in self.axes), *([BASE_COLOR] if self.base is not None else []))

    def with_values_of(self, stack: Stack) -> "LiveLobes":
        """The same for a stack's own live values."""
        return replace(self, stack=stack)

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.grid)

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        places = [axis.place(axis.value_of(self.stack)) for axis in self.axes]
        cos_theta_o = np.clip(np.asarray(cos_theta_o, float), MIN_COS_O, 1.0)
        return [_lobe(lobe, *parts, cos_theta_o) for lobe, parts in zip(self.grid, self._parts(places, cos_theta_o))]

    def _parts(self, places, cos_theta_o):
        """(weight, shape) of every lobe at views."""
        bounded = [(i, max(t, 0.0)) for i, t in places]

        def seen(array, at):
            return interpolate(_blend(array, at), cos_theta_o)

        energies = [seen(lobe.energy, bounded) for lobe in self.grid]
        summed = sum((e for lobe, e in zip(self.grid, energies) if lobe.unit is not None), np.zeros_like(energies[0]))
        scale = np.exp(seen(self.log_sum, bounded)) / np.maximum(summed, MIN_ENERGY)
        result = []
        for lobe, energy in zip(self.grid, energies):
            weight = energy if lobe.unit is None else energy * scale / seen(lobe.unit, bounded)
            shape = None
            if lobe.shape is None and self.base is not None:
                color = np.clip(self.stack.base["color"], 0.0, 1.0)
                weight = weight + np.exp(seen(self.base.log_through, bounded)) * color / (1.0 - np.exp(seen(self.base.log_back, bounded)) * color)
            if lobe.shape is not None:
                shape = np.concatenate([seen(lobe.shape[..., :2], places), seen(lobe.shape[..., 2:], bounded)], axis=-1)
            result.append((weight, shape))
        return result


def _lobe(lobe: LiveLobe, weight, shape, cos_theta_o):
    if shape is None:
        return DiffuseLobe(weight)
    root_x, root_y, slope = np.moveaxis(shape, -1, 0)
    alpha_x, alpha_y = (np.clip(np.square(np.maximum(root, 0.0)), MIN_ALPHA, 1.0) for root in (root_x, root_y))
    if lobe.is_specular:
        alpha_x = alpha_y = np.zeros_like(alpha_x)
    tilt = np.arctan(slope * np.sqrt(np.maximum(1.0 - np.square(cos_theta_o), 0.0)))
    return GlossyLobe(lobe.distribution, weight, alpha_x, alpha_y, tilt, lobe.fresnel)


def grid_of(
    stack: Stack, axes: tuple[Axis, ...], nodes: dict[tuple[int, ...], TableLobes], bases: dict[tuple[int, ...], BaseColorTable] | None = None
) -> LiveLobes:
    """A grid of the lobe sets at its nodes, which must have the same lobes, and of what the base adds. Raises LaminaError when they have not."""
    size = tuple(len(axis.knots) for axis in axes)
    if len({len(lobe_set.tables) for lobe_set in nodes.values()}) != 1 or len(nodes) != np.prod(size):
        raise LaminaError("the lobe sets of a grid differ in their lobes")

    def gathered(number: int, part) -> np.ndarray:
        arrays = [part(nodes[index].tables[number]) for index in np.ndindex(size)]
        return np.stack(arrays).reshape(*size, KNOTS, -1)

    lobes = []
    for number, first in enumerate(nodes[(0,) * len(axes)].tables):
        weight = gathered(number, lambda table: table.weight)
        if isinstance(first, DiffuseTable):
            lobes.append(LiveLobe(weight, unit=np.ones((*size, KNOTS, 1))))
            continue
        shape = gathered(number, lambda table: np.concatenate([np.sqrt(table.shape[:, :2]), table.shape[:, 2:]], axis=1))
        fixed = first.fresnel is not None or not np.any(first.shape)
        unit = None if fixed else gathered(number, _unit)
        lobes.append(LiveLobe(weight if fixed else weight * unit, first.distribution, shape, first.fresnel, unit))
    summed = sum(lobe.energy for lobe in lobes if lobe.unit is not None)
    base = None
    if bases:
        through, back = (
            np.stack([np.broadcast_to(getattr(bases[i], name), (KNOTS, 3)) for i in np.ndindex(size)]).reshape(*size, KNOTS, 3) for name in ("through", "back")
        )
        base = LiveBase(*(np.log(np.maximum(values, MIN_ENERGY)) for values in (through, back)))
    return LiveLobes(stack, axes, tuple(lobes), np.log(np.maximum(summed, MIN_ENERGY)), base)


def _unit(table: GlossyTable) -> np.ndarray:
    return np.maximum(unit_energy(table.lobe(knot_cosines()), knot_cosines())[:, :1], 1e-3)


def _blend(array: np.ndarray, places: Sequence[tuple[int, float]]) -> np.ndarray:
    """The array without its leading axes, interpolated at their places."""
    return reduce(lambda part, place: part[place[0]] * (1.0 - place[1]) + part[place[0] + 1] * place[1], places, array)
