# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes of bakes over live parameters: what is followed, its coordinate in a stack, and the stack of a knot.

A coordinate is a number, or, on an axis of colors, one per channel: every channel is a problem of its own, so that a table
of grey values holds all colors. What the channels of a closure share, its shape, is read at one coordinate for all.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..material.place import Place
from ..material.schema import CONDUCTOR
from ..material.stack import Stack
from ..optics.interface import optical_depth

# Added to a metal's reflectance before its logarithm is taken: about what a layer above reflects.
REFLECTANCE_OFFSET = 0.05
_MOST_REFLECTANCE = CONDUCTOR.parameter("reflectance").maximum


def knot_place(knots: tuple[float, ...], coordinate) -> tuple[np.ndarray, np.ndarray]:
    """The knot below a coordinate and the way to the next; less than 0 below the first knot, at most 1 above the last."""
    at = np.array(knots)
    i = np.clip(np.searchsorted(at, coordinate, side="right") - 1, 0, len(at) - 2)
    return i, np.minimum((coordinate - at[i]) / (at[i + 1] - at[i]), 1.0)


@dataclass(frozen=True)
class Axis(ABC):
    """One axis: the live values that it follows, all of one layer or of the base, and its knots, ascending.

    `knots` are those of shapes and shares, `fine` those of energies along this axis, `cross` those of how energies depend on two axes.
    """

    live: tuple[Place, ...]
    knots: tuple[float, ...]
    fine: tuple[float, ...]
    cross: tuple[float, ...]

    is_color: ClassVar[bool] = False

    @property
    def layer(self) -> int | None:
        """Where it is, as `Place` has it."""
        return self.live[0].layer

    @abstractmethod
    def coordinate(self, stack: Stack) -> np.ndarray:
        """() or, on an axis of colors, (3,)."""

    @abstractmethod
    def with_knot(self, stack: Stack, knot: float) -> Stack:
        """The stack at a knot, the same in all channels."""

    def shared(self, coordinate: np.ndarray) -> float:
        """The coordinate at which shapes are read."""
        return float(coordinate)


@dataclass(frozen=True)
class NumberAxis(Axis):
    """A roughness, a slope deviation or the index of the top layer."""

    def coordinate(self, stack: Stack) -> np.ndarray:
        return np.asarray(self.live[0].value(stack), float)

    def with_knot(self, stack: Stack, knot: float) -> Stack:
        return self.live[0].with_value(stack, knot)


@dataclass(frozen=True)
class DepthAxis(Axis):
    """The optical depth of a layer's medium, of which its tint, its thickness or both are live."""

    is_color = True

    def coordinate(self, stack: Stack) -> np.ndarray:
        layer = stack.layers[self.live[0].layer]
        return optical_depth(layer["tint"], layer["thickness"])

    def with_knot(self, stack: Stack, knot: float) -> Stack:
        layer = self.live[0].layer
        return Place(layer, "thickness").with_value(Place(layer, "tint").with_value(stack, (float(np.exp(-1.0)),) * 3), knot)

    def shared(self, coordinate: np.ndarray) -> float:
        """The depth of as much light, which crosses the medium twice."""
        return float(-0.5 * np.log(np.mean(np.exp(-2.0 * coordinate))))


@dataclass(frozen=True)
class MetalAxis(Axis):
    """A metal's reflectance, by its logarithm, as energies change with that, or its edge color."""

    is_color = True

    @property
    def is_reflectance(self) -> bool:
        """Whether it is the reflectance."""
        return self.live[0].name == "reflectance"

    def coordinate(self, stack: Stack) -> np.ndarray:
        value = np.asarray(self.live[0].value(stack), float)
        return np.log(value + REFLECTANCE_OFFSET) if self.is_reflectance else value

    def with_knot(self, stack: Stack, knot: float) -> Stack:
        value = float(np.exp(knot)) - REFLECTANCE_OFFSET if self.is_reflectance else knot
        return self.live[0].with_value(stack, (min(max(value, 0.0), _MOST_REFLECTANCE),) * 3)

    def shared(self, coordinate: np.ndarray) -> float:
        return float(np.log(np.mean(np.exp(coordinate)))) if self.is_reflectance else float(np.mean(coordinate))


AXES = {axis.__name__: axis for axis in (NumberAxis, DepthAxis, MetalAxis)}
