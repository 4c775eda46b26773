# SPDX-License-Identifier: GPL-3.0-or-later
"""What the nodes of all lobes share: the view, the given colors, and Color Ramps.

Cycles samples a ramp at 256 even steps and is linear between; every knot is put exactly on such a place, so a ramp is the
table itself, up to float32.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property, reduce
from types import MappingProxyType

import bpy
import numpy as np

from ....reference_py.lobes.view_table import AZIMUTH_PLACES, KNOTS
from ..inputs import ShaderInput, base_color_input
from ..working_space import REC709, into_working, primaries, working_space
from .node_builder import Builder
from .table_lookup import Lookup

RAMP_PLACES = 256
# Places of a ramp from one knot to the next, the most that fit.
STEP = RAMP_PLACES // (KNOTS - 1)
# Any direction, added to the tangent: without it the tangent would vanish at the very normal, and Cycles divide by 0.
_SOME_DIRECTION = (5.7e-7, 3.1e-7, 7.6e-7)


class View:
    """What lobes need of the view, made when the first of them asks. They are about the surface's normal, or about the `own` one.

    `lookup` are the nodes by which tables over live values are read.
    """

    def __init__(
        self,
        build: Builder,
        lookup: Lookup,
        given_tangent: bpy.types.NodeSocket | None = None,
        sockets: Mapping[str, bpy.types.NodeSocket] = MappingProxyType({}),
        own: bpy.types.NodeSocket | None = None,
    ):
        self._build, self.lookup, self.given_tangent, self._sockets, self._own = build, lookup, given_tangent, sockets, own
        self._about: dict[str, View] = {}
        self._base_colors: dict[str, bpy.types.NodeSocket] = {}
        self._base_lights: dict[tuple[str, bytes], bpy.types.NodeSocket] = {}
        self._azimuths: dict[float, list[bpy.types.NodeSocket]] = {}
        self._turned: dict[float | bpy.types.NodeSocket, bpy.types.NodeSocket] = {}

    def about(self, own: ShaderInput | None) -> "View":
        """The view from the own normal that the group gets for a layer or the base; this one for None."""
        if own is None:
            return self
        if own.osl_name not in self._about:
            self._about[own.osl_name] = View(self._build, self.lookup, self.given_tangent, self._sockets, self.given(own))
        return self._about[own.osl_name]

    @cached_property
    def own_normal(self) -> dict[str, bpy.types.NodeSocket]:
        """What a node that is about it has linked; nothing for the surface's normal. Of length 0 the own one is the surface's (osl/own_normal.h)."""
        if self._own is None:
            return {}
        unit = self._build.vector("NORMALIZE", self._own)
        missing = self._build.math("SUBTRACT", 1.0, self._build.vector("LENGTH", unit))
        return {"Normal": self._build.vector("ADD", unit, self._build.vector("SCALE", self._geometry.outputs["Normal"], scale=missing))}

    @cached_property
    def normal(self) -> bpy.types.NodeSocket:
        """The normal as Cycles bends it for a glossy lobe (osl/bent.h), with 0 for the least height, to save nodes.

        EEVEE bends nothing: its lobes keep their normal, and have the energy of this one.
        """
        build, true = self._build, self._geometry.outputs["True Normal"]
        shading = self.own_normal.get("Normal", self._geometry.outputs["Normal"])
        cosine, true_cosine = (build.vector("DOT_PRODUCT", n, self._incoming) for n in (shading, true))
        below = build.vector("DOT_PRODUCT", build.vector("REFLECT", self._incoming, shading), true)
        # Cycles bends nothing on strands; a height is at most 1
        missing = build.math("MAXIMUM", build.math("SUBTRACT", below, build.node("ShaderNodeHairInfo").outputs["Is Strand"]), 0.0)
        root = build.math("SQRT", build.math("MULTIPLY_ADD", true_cosine, missing, build.math("MULTIPLY", cosine, cosine)))
        k = build.math("DIVIDE", build.math("SUBTRACT", root, cosine), true_cosine)
        return build.vector("NORMALIZE", build.vector("MULTIPLY_ADD", true, k, shading))

    @cached_property
    def _geometry(self) -> bpy.types.Node:
        return self._build.node("ShaderNodeNewGeometry")

    @property
    def _incoming(self) -> bpy.types.NodeSocket:
        return self._geometry.outputs["Incoming"]

    @cached_property
    def _cosine(self) -> bpy.types.NodeSocket:
        return self._build.vector("DOT_PRODUCT", self.normal, self._incoming)

    @cached_property
    def root(self) -> bpy.types.NodeSocket:
        """The root of the cosine, in which knots are even."""
        return self._build.math("SQRT", self._cosine)

    @cached_property
    def place(self) -> bpy.types.NodeSocket:
        """Where in a ramp the view is."""
        return self._build.math("MULTIPLY", self.root, STEP * (KNOTS - 1) / RAMP_PLACES)

    @cached_property
    def side(self) -> bpy.types.NodeSocket:
        """Along the plane of incidence, as long as the sine of the view."""
        along_normal = self._build.vector("SCALE", self.normal, scale=self._cosine)
        return self._build.vector("SUBTRACT", self._incoming, along_normal)

    def base_color(self, owner: str) -> bpy.types.NodeSocket:
        """The color of the base, or of the opaque layer, of an owner in Rec.709, from 0 to 1."""
        if owner not in self._base_colors:
            self._base_colors[owner] = self.bounded(self.given(base_color_input(owner)))
        return self._base_colors[owner]

    def base_light(self, owner: str, back: np.ndarray) -> bpy.types.NodeSocket:
        """c / (1 - back c) for that color c and a table `back` (KNOTS, 3): what of light that got down to the base leaves it up again."""
        key = owner, back.tobytes()
        if key not in self._base_lights:
            color, returned = self.base_color(owner), self._build.combined(numbers(self._build, self.place, STEP * np.arange(KNOTS), -back))
            self._base_lights[key] = self._build.vector("DIVIDE", color, self._build.vector("MULTIPLY_ADD", color, returned, 1.0))
        return self._base_lights[key]

    def given(self, live: ShaderInput) -> bpy.types.NodeSocket:
        """What the group gets for a live value."""
        return self._sockets[live.osl_name]

    def bounded(self, given: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """A color of the working space in Rec.709, from 0 to 1."""
        color = in_space(self._build, given, np.linalg.inv(primaries()))
        return self._build.vector("MINIMUM", self._build.vector("MAXIMUM", color, 0.0), 1.0)

    def azimuth_shares(self, axis: float) -> list[bpy.types.NodeSocket]:
        """How much of each sheet of a table with this axis a view takes (`reference_py.lobes.view_table`)."""
        if axis not in self._azimuths:
            self._azimuths[axis] = self._shares(axis)
        return self._azimuths[axis]

    def turned(self, axis: float | bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The cosine of the view's azimuth from an axis, in radians from the given tangent, or a socket of full turns."""
        if axis not in self._turned:
            self._turned[axis] = self._cosine_from(axis)
        return self._turned[axis]

    def _shares(self, axis: float) -> list[bpy.types.NodeSocket]:
        place = self._build.math("MULTIPLY", self.turned(axis), AZIMUTH_PLACES[-1] / RAMP_PLACES)
        return numbers(self._build, place, AZIMUTH_PLACES, np.eye(len(AZIMUTH_PLACES)))

    def _cosine_from(self, axis: float | bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        build = self._build
        if isinstance(axis, bpy.types.NodeSocket):
            angle = build.math("MULTIPLY", axis, 2.0 * np.pi)
            cos, sin = build.math("COSINE", angle), build.math("SINE", angle)
        else:
            cos, sin = float(np.cos(axis)), float(np.sin(axis))
        across = build.vector("NORMALIZE", build.vector("CROSS_PRODUCT", self.normal, self.given_tangent))
        along = build.vector("CROSS_PRODUCT", across, self.normal)
        direction = build.vector("ADD", build.vector("SCALE", along, scale=cos), build.vector("SCALE", across, scale=sin))
        # along the normal all azimuths have the same weights
        length = build.math("MAXIMUM", build.vector("LENGTH", self.side), 1e-6)
        return build.math("ABSOLUTE", build.math("DIVIDE", build.vector("DOT_PRODUCT", self.side, direction), length))

    @cached_property
    def tangent(self) -> bpy.types.NodeSocket:
        return self._build.vector("ADD", self.side, _SOME_DIRECTION)


def in_space(build: Builder, color: bpy.types.NodeSocket, rows: np.ndarray) -> bpy.types.NodeSocket:
    """The color times a matrix (3, 3) between Rec.709 and the working space; itself where that is Rec.709."""
    if working_space() == REC709:
        return color
    return build.combined([build.vector("DOT_PRODUCT", color, tuple(map(float, column))) for column in rows.T])


def numbers(build: Builder, place: bpy.types.NodeSocket, places: Sequence[int], table: np.ndarray) -> list:
    """Columns of numbers (n, m) whose rows are at these places (n,) of a ramp's; constants stay constants, equal ones are one.

    A ramp has two, its grey and its alpha: Blender converts the colors of ramps into other working spaces, where greys are the same.
    """
    # colours of a ramp cannot be negative
    offset = np.minimum(table.min(axis=0), 0.0)
    keys = [tuple(column) for column in table.T]
    varying = [i for i, key in enumerate(keys) if len(set(key)) > 1 and keys.index(key) == i]
    sockets: dict[int, bpy.types.NodeSocket] = {}
    for first, *second in (varying[i : i + 2] for i in range(0, len(varying), 2)):
        alpha = table[:, second[0]] - offset[second[0]] if second else np.ones(len(table))
        node = ramp(build, place, places, np.column_stack([np.repeat((table[:, first] - offset[first])[:, None], 3, axis=1), alpha]))
        sockets[first] = node.outputs["Color"]  # a number's socket takes the luminance, which of a grey is itself
        if second:
            sockets[second[0]] = node.outputs["Alpha"]
    columns = []
    for key in keys:
        i = keys.index(key)
        if i not in sockets:
            columns.append(float(key[0]))
        else:
            columns.append(build.math("ADD", sockets[i], float(offset[i])) if offset[i] < 0.0 else sockets[i])
    return columns


def ramp(build: Builder, place: bpy.types.NodeSocket, places: Sequence[int], table: np.ndarray) -> bpy.types.Node:
    """A Color Ramp of colors and alpha (n, 4), none of them negative, at these places (n,) of the ramp's, of which the first is 0."""
    node = build.node("ShaderNodeValToRGB")
    elements = node.color_ramp.elements
    # an element that is there moves at the price of looking through the whole tree, and so does one that gets its color by assignment
    for old in tuple(elements)[1:]:
        elements.remove(old)
    for position in np.asarray(places[1:], np.float32) / RAMP_PLACES:
        elements.new(position)
    for element, color in zip(elements, np.asarray(table, np.float32)):
        element.color.foreach_set(color)
    build.link(place, node.inputs[0])
    return node


def weight_at(build: Builder, view: View, table: np.ndarray, axis: float | None):
    """A colour at the view: ramps, or a constant."""
    if axis is not None:
        sheets = [build.vector("SCALE", _view_ramp(build, view, sheet), scale=share) for share, sheet in zip(view.azimuth_shares(axis), table)]
        return reduce(lambda a, b: build.vector("ADD", a, b), sheets)
    if np.all(table == table[0]):
        return (*map(float, into_working(table[0])), 1.0)
    return _view_ramp(build, view, table)


def columns_at(build: Builder, view: View, table: np.ndarray) -> list:
    """The columns of numbers (KNOTS, 3) at the view."""
    return numbers(build, view.place, STEP * np.arange(KNOTS), table)


def _view_ramp(build: Builder, view: View, table: np.ndarray) -> bpy.types.NodeSocket:
    """The colors (KNOTS, 3) of the model, none of them negative, at the view."""
    return ramp(build, view.place, STEP * np.arange(KNOTS), np.column_stack([into_working(table), np.ones(KNOTS)])).outputs["Color"]
