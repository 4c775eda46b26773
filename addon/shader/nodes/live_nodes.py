# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of lobes over live values as stock nodes: looked up in an image by the view and by the values that come in through sockets."""

import math
from collections.abc import Sequence
from functools import cached_property, reduce

import bpy
import numpy as np

from ....reference_py.errors import LaminaError
from ....reference_py.lobes.axes import (
    BRIGHT_OFFSET,
    HALF_DEPTH,
    LEAST_COUNT,
    REFLECTANCE_OFFSET,
    Axis,
    AzimuthAxis,
    CoatedReflectanceAxis,
    DepthAxis,
    EdgeAxis,
    IndexAxis,
    NumberAxis,
    ReflectanceAxis,
    ScatterColorAxis,
    ThicknessAxis,
)
from ....reference_py.lobes.live_grid import MIN_ALPHA
from ....reference_py.lobes.live_tables import LiveTable, LiveTables, kept
from ....reference_py.lobes.lobe import ConductorCurve
from ....reference_py.lobes.view_table import KNOTS
from ....reference_py.material.place import Place
from ....reference_py.material.schema import CONDUCTOR
from ....reference_py.optics.interface import TINT_FLOOR, optical_depth
from ....reference_py.optics.scattering import FIT
from ..inputs import place_input
from ..working_space import into_working, primaries
from .node_builder import Builder
from .table_image import TableImage
from .view_nodes import View, in_space

# Where numbers that all channels share are looked up.
_SHARED = 3
# Numbers that differ by less are one.
_SAME = 1e-12
_MOST_REFLECTANCE = CONDUCTOR.parameter("reflectance").maximum


class LiveNodes:
    """Sockets of the weights and shapes of one part's tables, at the live values of `owners` and the view. The image is made with the first.

    Raises LaminaError for an axis that it does not know.
    """

    def __init__(self, build: Builder, view: View, tables: LiveTables, owners: Sequence[str], plan: "_Plan | None" = None):
        self._build, self._view, self._tables, self._owners, self._lookup = build, view, tables, owners, view.lookup
        self._plan = plan or _Plan(tables, view.lookup.numbers)
        self._read: dict[tuple[int, int], list[bpy.types.Node]] = {}
        self._sockets: dict[tuple, bpy.types.NodeSocket] = {}

    def about(self, view: View) -> "LiveNodes":
        """The same seen from another normal; they share the image."""
        return LiveNodes(self._build, view, self._tables, self._owners, self._plan)

    def weight(self, number: int):
        """A color of the working space: a socket, or four numbers."""
        table, plan = self._tables.tables[number], self._plan.lobes[number]
        if table.energy is None:
            return (*map(float, into_working(np.ones(3))), 1.0)
        weight = self._energy(plan["energy"])
        if "through" in plan:
            color = self._view.base_color(self._owners[-1])
            left = self._build.vector("MULTIPLY_ADD", self._build.vector("MULTIPLY", color, self._energy(plan["back"])), (-1.0,) * 3, 1.0)
            weight = self._build.vector("MULTIPLY_ADD", self._build.vector("DIVIDE", color, left), self._energy(plan["through"]), weight)
        if "unit" in plan:
            weight = self._build.vector("DIVIDE", weight, self._build.combined([self._number(plan["unit"][0])] * 3))
        if not isinstance(weight, bpy.types.NodeSocket):
            return (*map(float, into_working(weight)), 1.0)
        return in_space(self._build, weight, primaries())

    def shape(self, number: int) -> list:
        """Roots of alpha along and across, and the slope: sockets or numbers."""
        return [self._number(part) for part in self._plan.lobes[number]["shape"]]

    @cached_property
    def index(self) -> bpy.types.NodeSocket | None:
        """The index of the top layer, where that is live."""
        axis = self._tables.index
        return self._input(axis.live[0]) if axis is not None else None

    def metal(self, curve: ConductorCurve) -> tuple:
        """Index and extinction of a metal: sockets, or numbers where neither of its colors is live (`artist_index`)."""
        live = {place for axis in self._tables.axes for place in axis.live}
        colors = Place(None, "reflectance"), Place(None, "edge_color")
        if live.isdisjoint(colors):
            return curve.eta, curve.k
        build = self._build
        r, g = (self._view.bounded(self._input(place)) if place in live else place.value(self._tables.stack) for place in colors)
        if Place(None, "reflectance") in live:
            r = build.vector("MINIMUM", r, _MOST_REFLECTANCE)
        root, left = build.vector("POWER", r, 0.5), build.vector("SUBTRACT", (1.0,) * 3, r)
        least = build.vector("DIVIDE", left, build.vector("ADD", r, 1.0))
        most = build.vector("DIVIDE", build.vector("ADD", root, 1.0), build.vector("SUBTRACT", (1.0,) * 3, root))
        eta = build.vector("MULTIPLY_ADD", build.vector("SUBTRACT", least, most), g, most)
        above, below = build.vector("ADD", eta, 1.0), build.vector("SUBTRACT", eta, (1.0,) * 3)
        squared = build.vector("SUBTRACT", build.vector("MULTIPLY", build.vector("MULTIPLY", above, above), r), build.vector("MULTIPLY", below, below))
        return eta, build.vector("POWER", build.vector("MAXIMUM", build.vector("DIVIDE", squared, left), 0.0), 0.5)

    @property
    def brushing(self) -> float | bpy.types.NodeSocket | None:
        """The direction of the brushing, as `View.turned` takes it."""
        rotation = self._tables.rotation
        return self._tables.brushing if rotation is None else self._input(rotation)

    def _input(self, place: Place) -> bpy.types.NodeSocket:
        return self._view.given(place_input(self._tables.stack, place, self._owners))

    def _number(self, part: "_Part"):
        if part.block is None:
            return part.constant if part.axis is None else self._build.math("MAXIMUM", self._coordinates[part.axis][_SHARED], MIN_ALPHA**0.5)
        key = part.where, part.block, part.channel
        if key not in self._sockets:
            self._sockets |= {(part.where, part.block, channel): socket for channel, socket in enumerate(self._numbers(part.where, part.block))}
        return self._sockets[key]

    def _energy(self, parts: list["_Part"]):
        """Three energies: a socket, or numbers."""
        return self._build.combined([self._number(part) for part in parts])

    def _numbers(self, where: int, block: int) -> list[bpy.types.NodeSocket]:
        """The numbers of a block."""
        first = self._separate(self._mixed(where, block, "Color", "VECTOR"))
        return first if self._plan.image.count(block) <= len(first) else [*first, self._mixed(where, block, "Alpha", "FLOAT")]

    def _mixed(self, where: int, block: int, output: str, kind: str) -> bpy.types.NodeSocket:
        """What an output of a block's nodes has between the tiles."""
        found = [node.outputs[output] for node in self._read_at(where, block)]
        for number in range(len(self._tables.axes) - 1, 0, -1):  # tiles of the last axis are side by side
            found = [self._mix(self._tile(number, where)[1], *found[i : i + 2], kind) for i in range(0, len(found), 2)]
        return found[0]

    def _mix(self, share, first, second, kind: str) -> bpy.types.NodeSocket:
        node = self._build.node("ShaderNodeMix")
        node.data_type, node.clamp_factor = kind, False
        sockets = {socket.identifier: socket for socket in (*node.inputs, *node.outputs)}
        for source, name in ((share, "Factor_Float"), (first, f"A_{kind.title()}"), (second, f"B_{kind.title()}")):
            self._build.link(source, sockets[name])
        return sockets[f"Result_{kind.title()}"]

    def _read_at(self, where: int, block: int) -> list[bpy.types.Node]:
        """The nodes that read a block, one for each tile that the axes after the first are between."""
        if (where, block) not in self._read:
            up, places = self._up(where, block), self._across(where)
            self._read[where, block] = [self._lookup.node(self._build, self._plan.made) for _ in places]
            for node, across in zip(self._read[where, block], places):
                self._build.link(self._build.combined([*across, up]), node.inputs["Vector"])
        return self._read[where, block]

    def _up(self, where: int, block: int) -> bpy.types.NodeSocket:
        """The last part of the place of the row of a block."""
        image, (scale, offset) = self._plan.image, self._lookup.up
        scale /= image.height
        share = self._build.math("MULTIPLY_ADD", self._place(0, where), (image.rows - 1) * scale, (block * image.rows + 0.5) * scale + offset)
        return self._lookup.place_up(self._build, share)

    def _across(self, where: int) -> list[tuple]:
        """The first parts of the place of the view, once for each of the tiles that the axes after the first are between."""
        key = "across", self._tile_key(where)
        if key not in self._sockets:
            scale, offset = self._lookup.across
            scale /= self._plan.image.width
            shares = [self._build.math("MULTIPLY_ADD", self._view.root, (KNOTS - 1) * scale, 0.5 * scale + offset)]
            step = self._plan.image.width * scale
            for number in range(1, len(self._tables.axes)):
                step /= self._tables.scales[number].count
                cells = [self._build.math("MULTIPLY_ADD", self._tile(number, where)[0], step, share) for share in shares]
                shares = [share for cell in cells for share in (cell, self._build.math("ADD", cell, step))]
            self._sockets[key] = [self._lookup.place_across(self._build, share) for share in shares]
        return self._sockets[key]

    def _tile(self, number: int, where: int) -> tuple:
        """The row below the coordinate of an axis after the first, and the way to the next."""
        key = "tile", number, where if self._tables.axes[number].is_color else _SHARED
        if key not in self._sockets:
            last = self._tables.scales[number].count - 1
            at = self._build.math("MULTIPLY", self._place(number, where), float(last))
            cell = self._build.math("MINIMUM", self._build.math("FLOOR", at), last - 1.0)
            self._sockets[key] = cell, self._build.math("SUBTRACT", at, cell)
        return self._sockets[key]

    def _tile_key(self, where: int) -> int:
        """The channels of a number have the same tiles where no axis but the first is one of colors."""
        return where if any(axis.is_color for axis in self._tables.axes[1:]) else _SHARED

    def _place(self, number: int, where: int):
        """Where in its rows an axis is, 0 to 1."""
        where = where if self._tables.axes[number].is_color else _SHARED
        key = "place", number, where
        if key not in self._sockets:
            scale = self._tables.scales[number]
            size = scale.high - scale.low
            way = self._build.math("MULTIPLY_ADD", self._coordinates[number][where], 1.0 / size, -scale.low / size)
            way.node.use_clamp = True
            self._sockets[key] = way if scale.bend == 1.0 else self._build.math("POWER", way, scale.bend)
        return self._sockets[key]

    @cached_property
    def _coordinates(self) -> list[list]:
        """Of each axis that of the channels and the shared one."""
        return [self._coordinate(axis) for axis in self._tables.axes]

    def _coordinate(self, axis: Axis) -> list:
        if isinstance(axis, AzimuthAxis):
            return [self._view.turned(self.brushing)] * 4
        build, first = self._build, self._input(axis.live[0])
        if isinstance(axis, NumberAxis):
            return [first] * 4
        if isinstance(axis, IndexAxis):
            return [build.math("DIVIDE", build.math("SUBTRACT", first, 1.0), build.math("ADD", first, 1.0))] * 4
        if isinstance(axis, ThicknessAxis):
            value = build.math("MAXIMUM", first, 0.0)
            return [build.math("DIVIDE", value, build.math("ADD", value, axis.half(self._tables.stack)))] * 4
        if isinstance(axis, DepthAxis):
            depths = self._depths(axis)
            coordinates = build.vector("DIVIDE", depths, build.vector("ADD", depths, (HALF_DEPTH,) * 3))
            short = build.vector("SUBTRACT", (1.0,) * 3, coordinates)
            counts = build.vector("MULTIPLY_ADD", short, short, (LEAST_COUNT,) * 3)
            total, seen = (build.vector("DOT_PRODUCT", counts, of) for of in ((1.0,) * 3, coordinates))
            return [*self._separate(coordinates), build.math("DIVIDE", seen, total)]
        color = self._view.bounded(first)
        if isinstance(axis, ReflectanceAxis):
            over = build.vector("ADD", color, REFLECTANCE_OFFSET), build.vector("SUBTRACT", (1.0 + BRIGHT_OFFSET,) * 3, color)
            ratios = self._separate(build.vector("DIVIDE", *over))
            channels = [build.math("LOGARITHM", ratio, math.e) for ratio in ratios]
            if isinstance(axis, CoatedReflectanceAxis):
                counts = build.combined([build.math("SQRT", ratio) for ratio in ratios])
                total, seen = (build.vector("DOT_PRODUCT", counts, of) for of in ((1.0,) * 3, build.combined(channels)))
                return [*channels, build.math("DIVIDE", seen, total)]
        elif isinstance(axis, EdgeAxis):
            short = self._separate(build.vector("SUBTRACT", (1.0,) * 3, color))
            channels = [build.math("SUBTRACT", 1.0, build.math("SQRT", c)) for c in short]
        elif isinstance(axis, ScatterColorAxis):
            channels = self._whiteness(color)
        else:
            raise LaminaError(f"no stock nodes follow the axis {type(axis).__name__}")
        return [*channels, build.math("MULTIPLY", reduce(lambda a, b: build.math("ADD", a, b), channels), 1.0 / 3.0)]

    def _whiteness(self, color: bpy.types.NodeSocket) -> list:
        """`ScatterColorAxis` of the channels."""
        build, (a, b) = self._build, FIT
        middle = build.vector("MULTIPLY_ADD", color, b, 1.0 + a)
        under_root = build.vector("MULTIPLY_ADD", middle, middle, build.vector("MULTIPLY_ADD", color, 4.0 * a, -4.0 * a))
        root = build.combined([build.math("SQRT", c) for c in self._separate(under_root)])
        return self._separate(build.vector("MULTIPLY_ADD", build.vector("SUBTRACT", middle, root), -0.5 / a, 1.0))

    def _depths(self, axis: DepthAxis) -> bpy.types.NodeSocket:
        """Optical depths of the channels."""
        build, (tint, thickness) = self._build, (Place(axis.layer, name) for name in ("tint", "thickness"))
        layer = tint.element(self._tables.stack)
        depth = tuple(map(float, optical_depth(layer["tint"], 1.0)))
        if tint in axis.live:
            left = build.vector("MAXIMUM", self._view.bounded(self._input(tint)), TINT_FLOOR)
            logarithms = build.combined([build.math("LOGARITHM", c, math.e) for c in self._separate(left)])
            depth = build.vector("MULTIPLY", logarithms, -1.0)
        return build.vector("SCALE", depth, scale=self._input(thickness) if thickness in axis.live else float(layer["thickness"]))

    def _separate(self, vector: bpy.types.NodeSocket) -> list:
        separate = self._build.node("ShaderNodeSeparateXYZ")
        self._build.link(vector, separate.inputs[0])
        return list(separate.outputs)


class _Part:
    """Where a number is: a constant, the coordinate of an axis, or in a block of the image."""

    def __init__(self, constant: float = 0.0, axis: int | None = None, where: int = _SHARED, block: int | None = None, channel: int = 0):
        self.constant, self.axis, self.where, self.block, self.channel = constant, axis, where, block, channel


class _Plan:
    """Which numbers of tables are where in an image: those of channels with coordinates of their own apart, else all together.

    Channels of equal numbers share blocks, and differ in where they read them.
    """

    def __init__(self, tables: LiveTables, numbers: int):
        rows, *tiles = (scale.count for scale in tables.scales)
        self.image = TableImage(numbers, rows, math.prod(tiles))
        self._tables, self._numbers = tables, {where: [] for where in range(_SHARED + 1)}
        self._parts: dict[int, list[_Part]] = {where: [] for where in range(_SHARED + 1)}
        self.lobes = [self._lobe(table) for table in tables.tables]
        known: list[tuple[list[np.ndarray], tuple[int, ...]]] = []
        for where, numbers in self._numbers.items():
            blocks = next((of for others, of in known if _are_equal(numbers, others)), None) or self.image.add(numbers)
            known.append((numbers, blocks))
            for i, part in enumerate(self._parts[where]):
                part.block, part.channel = blocks[i // self.image.numbers], i % self.image.numbers

    @cached_property
    def made(self) -> bpy.types.Image:
        """The image in this file."""
        return self.image.make()

    def _lobe(self, table: LiveTable) -> dict[str, list[_Part]]:
        table, lobe = kept(table, self._tables.is_color), {}
        for name in ("energy", "through", "back"):
            values = getattr(table, name)
            if values is not None:
                lobe[name] = [self._part(self._where(values[..., c], c), values[..., c]) for c in range(3)]
        if table.unit is not None:
            lobe["unit"] = [self._part(_SHARED, table.unit[..., 0])]
        if table.shape is not None:
            lobe["shape"] = [self._part(_SHARED, table.shape[..., column]) for column in range(3)]
        return lobe

    def _where(self, values: np.ndarray, channel: int) -> int:
        """At whose coordinates numbers of a channel are looked up: at those of all where none of its own changes them."""
        own = [number for number, axis in enumerate(self._tables.axes) if axis.is_color]
        return channel if any(np.any(np.ptp(values, axis=number) > _SAME) for number in own) else _SHARED

    def _part(self, where: int, values: np.ndarray) -> _Part:
        if np.ptp(values) == 0.0:
            return _Part(float(values.flat[0]))
        if (axis := self._tables.axis_of(values)) is not None:
            return _Part(axis=axis)
        for known, part in zip(self._numbers[where], self._parts[where]):
            if np.array_equal(known, values):
                return part
        part = _Part(where=where)
        self._numbers[where].append(values)
        self._parts[where].append(part)
        return part


def _are_equal(numbers: list[np.ndarray], others: list[np.ndarray]) -> bool:
    return len(numbers) == len(others) and all(np.abs(a - b).max() <= _SAME for a, b in zip(numbers, others))
