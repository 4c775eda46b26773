# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes of bakes over live parameters: what is followed, its coordinate in a stack, and the stack of a knot.

Knots are even in the coordinate, so that a shader needs no search. A coordinate is a number, or, on an axis of colors, one per
channel: every channel is a problem of its own, so that a table of grey values holds all colors. What the channels of a
closure share, its shape, is read at one coordinate for all.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..material.place import Place
from ..material.schema import CONDUCTOR, DIELECTRIC, SCATTERING
from ..material.stack import Stack
from ..optics.interface import optical_depth
from ..optics.scattering import color_of_similarity, similarity_of_color
from .brushing import directions

# In the coordinate of a metal's reflectance: added to it, about what a layer above reflects, and to what it is short of 1.
REFLECTANCE_OFFSET, BRIGHT_OFFSET = 0.03, 0.3
# The optical depth that is half-way of all.
HALF_DEPTH = 1.2
# What a channel counts at least where shapes are read at the bright ones: all may be black.
LEAST_COUNT = 1e-6
# Of a density or a thickness: less is none, and its other factor is not seen.
_LEAST_FACTOR = 1e-3
_MOST = {p.name: p.maximum for p in (*DIELECTRIC.parameters, *SCATTERING.parameters)}
_MOST_REFLECTANCE = CONDUCTOR.parameter("reflectance").maximum


@dataclass(frozen=True)
class Scale:
    """Knots, `count` from `low` to `high`, even in the way from one to the other to the power of `bend`: below 1 they are dense at the low end."""

    low: float
    high: float
    count: int
    bend: float = 1.0

    @property
    def knots(self) -> np.ndarray:
        """Coordinates (count,)."""
        return self.low + (self.high - self.low) * np.linspace(0.0, 1.0, self.count) ** (1.0 / self.bend)

    def way(self, coordinate) -> np.ndarray:
        """Where the knots are even: 0 at the first of them and before, 1 at the last and beyond."""
        return np.clip((np.asarray(coordinate, float) - self.low) / (self.high - self.low), 0.0, 1.0) ** self.bend

    def place(self, coordinate) -> tuple[np.ndarray, np.ndarray]:
        """The knot below a coordinate and the way to the next, 0 to 1; beyond the knots the last of them."""
        at = self.way(coordinate) * (self.count - 1.0)
        cell = np.minimum(at.astype(int), self.count - 2)
        return cell, at - cell


@dataclass(frozen=True)
class Axis(ABC):
    """One axis: the live values that it follows, all of one layer or of the base, and its scales. Subclasses add no fields, so they need no decorator.

    `knots` are those of shapes and shares, of which the first `before` continue the next two, `fine` those of energies along this
    axis, `cross` those of how energies depend on several axes.
    """

    live: tuple[Place, ...]
    knots: Scale
    fine: Scale
    cross: Scale
    before: int = 0

    is_color: ClassVar[bool] = False
    has_waves: ClassVar[bool] = False
    """Whether energies go up and down along it."""

    @property
    def scales(self) -> tuple[Scale, Scale, Scale]:
        """All three."""
        return self.knots, self.fine, self.cross

    @property
    def layer(self) -> int | None:
        """Where it is, as `Place` has it."""
        return self.live[0].layer

    @abstractmethod
    def coordinate(self, stack: Stack) -> np.ndarray:
        """() or, on an axis of colors, (3,)."""

    @abstractmethod
    def at(self, stack: Stack, coordinate: float) -> Stack:
        """The stack of a coordinate, the same in all channels."""

    def shared(self, coordinate: np.ndarray) -> float:
        """The coordinate at which shapes are read; shaders have the same formula."""
        return float(np.mean(coordinate))


class NumberAxis(Axis):
    """A roughness or a slope deviation."""

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        return np.asarray(self.live[0].value(stack), float)

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        return self.live[0].with_value(stack, float(coordinate))


class FilmAxis(NumberAxis):
    """The thickness of a thin film, or its index: energies go up and down with it as waves do."""

    has_waves = True


class IndexAxis(Axis):
    """The index of a layer, as the amplitude that it would reflect below vacuum."""

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        ior = np.asarray(self.live[0].value(stack), float)
        return (ior - 1.0) / (ior + 1.0)

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        return self.live[0].with_value(stack, float((1.0 + coordinate) / (1.0 - coordinate)))


class ThicknessAxis(Axis):
    """The thickness of a medium that scatters, or its density, as a share of all."""

    def half(self, stack: Stack) -> float:
        """The value of optical depth 1, which is half-way of all."""
        layer = self.live[0].element(stack)
        other = layer["thickness"] if self.live[0].name == "density" else layer["density"] if "density" in layer else max(layer["extinction"])
        return 1.0 / max(float(other), _LEAST_FACTOR)

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        value = np.maximum(np.asarray(self.live[0].value(stack), float), 0.0)
        return value / (value + self.half(stack))

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        value = self.half(stack) * coordinate / (1.0 - coordinate)
        return self.live[0].with_value(stack, float(min(value, _MOST[self.live[0].name])))


class DepthAxis(Axis):
    """The optical depth of a layer's medium, of which its tint, its thickness or both are live, as a share of all depths.

    Channels that little light passes have next to nothing in the lobes below the medium: shapes are read where the bright ones are.
    """

    is_color = True

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        layer = self.live[0].element(stack)
        depth = optical_depth(layer["tint"], layer["thickness"])
        return depth / (depth + HALF_DEPTH)

    def shared(self, coordinate: np.ndarray) -> float:
        """The mean over channels, each counted by the square of what it is short of all depths."""
        counts = np.square(1.0 - coordinate) + LEAST_COUNT
        return float(np.sum(counts * coordinate) / np.sum(counts))

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        thickness = float(HALF_DEPTH * coordinate / (1.0 - coordinate))
        return Place(self.layer, "thickness").with_value(Place(self.layer, "tint").with_value(stack, (float(np.exp(-1.0)),) * 3), thickness)


def of_reflectance(reflectance: np.ndarray) -> np.ndarray:
    """The coordinate (...) of `ReflectanceAxis`."""
    return np.log((reflectance + REFLECTANCE_OFFSET) / (1.0 + BRIGHT_OFFSET - reflectance))


class ReflectanceAxis(Axis):
    """A metal's reflectance, by the logarithm of what it is over what it is short of 1: the energies of dark metals and of bright ones change fast."""

    is_color = True

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        return of_reflectance(np.asarray(self.live[0].value(stack), float))

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        ratio = np.exp(coordinate)
        value = float(np.clip(((1.0 + BRIGHT_OFFSET) * ratio - REFLECTANCE_OFFSET) / (1.0 + ratio), 0.0, _MOST_REFLECTANCE))
        return self.live[0].with_value(stack, (value,) * 3)


class CoatedReflectanceAxis(ReflectanceAxis):
    """The same below layers, beside whose light dark channels have next to nothing of the metal's: shapes are read where the bright ones are."""

    def shared(self, coordinate: np.ndarray) -> float:
        """The mean over channels, each counted by the root of the ratio that its coordinate has the logarithm of."""
        counts = np.exp(0.5 * coordinate)
        return float(np.sum(counts * coordinate) / np.sum(counts))


class EdgeAxis(Axis):
    """A metal's edge color; near 1 its index is small, and reflections change fast."""

    is_color = True

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        return 1.0 - np.sqrt(1.0 - np.asarray(self.live[0].value(stack), float))

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        return self.live[0].with_value(stack, (float(1.0 - (1.0 - coordinate) ** 2),) * 3)


class ScatterColorAxis(Axis):
    """The color of a medium that scatters, by what two media of equal reflectance have in common: 0 is black, 1 white (van de Hulst)."""

    is_color = True

    def coordinate(self, stack: Stack) -> np.ndarray:
        """As in `Axis`."""
        return 1.0 - similarity_of_color(np.asarray(self.live[0].value(stack), float))

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """As in `Axis`."""
        return self.live[0].with_value(stack, (float(np.clip(color_of_similarity(1.0 - coordinate), 0.0, 1.0)),) * 3)


class AzimuthAxis(Axis):
    """How far a view is turned out of the brushing, as the cosine of its azimuth from there; no value of the stack's, but of the view."""

    @property
    def layer(self) -> None:
        """It is of the whole stack."""
        return None

    def coordinate(self, stack: Stack) -> np.ndarray:
        """That of a view along the brushing."""
        return np.asarray(1.0)

    def at(self, stack: Stack, coordinate: float) -> Stack:
        """The same stack."""
        return stack


def top_index(axes: tuple[Axis, ...]) -> IndexAxis | None:
    """The axis of the top layer's index, which its Fresnel curve follows, if there is one."""
    return next((axis for axis in axes if isinstance(axis, IndexAxis) and axis.layer == 0), None)


def has_waves(axes: tuple[Axis, ...]) -> bool:
    """Whether energies go up and down along one of the axes."""
    return any(axis.has_waves for axis in axes)


def brushing_of(axes: tuple[Axis, ...], stack: Stack) -> float | None:
    """The direction of the stack's brushing in radians from the tangent, where there is an axis about it."""
    return directions(stack).pop() if any(isinstance(axis, AzimuthAxis) for axis in axes) else None


_KINDS = (NumberAxis, FilmAxis, IndexAxis, ThicknessAxis, DepthAxis, ReflectanceAxis, CoatedReflectanceAxis, EdgeAxis, ScatterColorAxis, AzimuthAxis)
AXES = {axis.__name__: axis for axis in _KINDS}
