# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of one patch as nodes, by number: of tables over the view alone, and of those over live values too."""

from collections.abc import Sequence
from dataclasses import fields

import bpy
import numpy as np

from ....reference_py.lobes.live_tables import LiveTables
from ....reference_py.lobes.lobe import ConductorCurve
from ....reference_py.lobes.view_table import BaseColorTable, DiffuseTable, GlossyTable, OrenNayarTable, RoughBase, TableLobes, is_glossy, knot_cosines
from ....reference_py.optics.diffuse import fujii_roughness, oren_nayar_albedo, oren_nayar_color
from ..inputs import normal_input
from ..working_space import REC709, into_working, out_of_working, primaries, working_space
from .glossy_nodes import anisotropy_of, glossy, glossy_node, metallic_node
from .live_nodes import LiveNodes
from .node_builder import Builder
from .rough_base_nodes import rough_base
from .view_nodes import View, columns_at, in_space, weight_at


def _views(view: View, lobe_set: TableLobes | LiveTables, owners: Sequence[str]) -> list[View]:
    """The view of each table from the normal that it is about."""
    return [view.about(None if table.normal is None else normal_input(table.normal, owners)) for table in lobe_set.tables]


class FixedPart:
    """The lobes of one patch, of tables over the view alone: by number a weight, the columns of a shape, a closure."""

    def __init__(self, build: Builder, view: View, lobe_set: TableLobes, owners: Sequence[str]):
        self._build, self._views, self.tables, self._owner = build, _views(view, lobe_set, owners), lobe_set.tables, owners[-1]

    def is_lambert(self, number: int) -> bool:
        """Whether it is Lambert about the surface's normal."""
        table = self.tables[number]
        return isinstance(table, BaseColorTable | DiffuseTable) and not is_glossy(table) and table.normal is None

    def weight(self, number: int):
        table, view = self.tables[number], self._views[number]
        return (
            _base_weight(self._build, view, table, self._owner) if isinstance(table, BaseColorTable) else weight_at(self._build, view, table.weight, table.axis)
        )

    def columns(self, number: int) -> list:
        return columns_at(self._build, self._views[number], self.tables[number].shape)

    def closure(self, number: int) -> bpy.types.NodeSocket:
        return _LOBES[type(self.tables[number])](self._build, self._views[number], self.tables[number], self._owner)

    def is_same(self, number: int, other, other_number: int) -> bool:
        """Whether two lobes are one closure."""
        first, second = self.tables[number], other.tables[other_number]
        return (
            self._views[number] is other._views[other_number]
            and type(first) is type(second)
            and (self._owner == other._owner or not isinstance(first, BaseColorTable | RoughBase))
            and all(np.array_equal(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
        )


class LivePart:
    """The same of tables over live values too."""

    def __init__(self, build: Builder, view: View, lobe_set: LiveTables, owners: Sequence[str]):
        self._build, self.tables = build, lobe_set.tables
        self._views = _views(view, lobe_set, owners)
        first = LiveNodes(build, view, lobe_set, owners)
        known = {view: first} | {other: first.about(other) for other in dict.fromkeys(self._views) if other is not view}
        self._nodes = [known[view] for view in self._views]

    def is_lambert(self, number: int) -> bool:
        return self.tables[number].distribution is None and self.tables[number].normal is None

    def weight(self, number: int):
        return self._nodes[number].weight(number)

    def columns(self, number: int) -> list:
        root_x, root_y, slope = self._nodes[number].shape(number)
        return [self._build.math("MULTIPLY", root_x, root_x), self._build.math("MULTIPLY", root_y, root_y), slope]

    def closure(self, number: int) -> bpy.types.NodeSocket:
        build, view, table = self._build, self._views[number], self.tables[number]
        if table.distribution is None:
            return build.shader("ShaderNodeBsdfDiffuse", Color=self.weight(number), Roughness=0.0, **view.own_normal)
        root_x, root_y, slope = self._nodes[number].shape(number)
        shape = np.concatenate([np.square(table.shape[..., :2]), table.shape[..., 2:]], axis=-1).reshape(-1, 3)
        if isinstance(table.fresnel, ConductorCurve):
            return metallic_node(build, view, table.distribution, *self._nodes[number].metal(table.fresnel), root_x, shape)
        if table.fresnel is not None:
            index = self._nodes[number].index or table.fresnel.eta
            return metallic_node(build, view, table.distribution, build.combined([index] * 3), (0.0,) * 3, root_x, shape)
        roughness = root_x if root_x is root_y else build.math("SQRT", build.math("MULTIPLY", root_x, root_y))

        def anisotropy():
            return anisotropy_of(build, lambda a, b: build.math("DIVIDE", a, b), root_x, root_y, shape)

        frame = self._nodes[number].brushing if table.is_brushed else None
        return glossy_node(build, view, table.distribution, self.weight(number), roughness, anisotropy, slope, shape, frame)

    def is_same(self, number: int, other, other_number: int) -> bool:
        return False


def part_of(build: Builder, view: View, lobe_set: TableLobes | LiveTables, owners: Sequence[str]) -> FixedPart | LivePart:
    """The lobes of a patch whose layers and base have these owners."""
    return LivePart(build, view, lobe_set, owners) if isinstance(lobe_set, LiveTables) else FixedPart(build, view, lobe_set, owners)


def _lambert(build: Builder, view: View, table: DiffuseTable, owner: str) -> bpy.types.NodeSocket:
    return build.shader("ShaderNodeBsdfDiffuse", Color=weight_at(build, view, table.weight, table.axis), Roughness=0.0, **view.own_normal)


def _base(build: Builder, view: View, table: BaseColorTable, owner: str) -> bpy.types.NodeSocket:
    color = _base_weight(build, view, table, owner)
    if table.distribution is not None:
        return glossy(build, view, table.now, color)
    return build.shader("ShaderNodeBsdfDiffuse", Color=color, Roughness=0.0, **view.own_normal)


def _base_weight(build: Builder, view: View, table: BaseColorTable, owner: str) -> bpy.types.NodeSocket:
    """own + through c / (1 - back c), channel by channel of Rec.709: numbers, which Blender would convert if they were colors."""
    columns = columns_at(build, view, np.column_stack([table.through, table.own]))
    weight = build.vector("MULTIPLY_ADD", view.base_light(owner, table.back), build.combined(columns[:3]), build.combined(columns[3:]))
    if np.any(table.through < 0.0):
        weight = build.vector("MAXIMUM", weight, 0.0)
    return in_space(build, weight, primaries())


def _oren_nayar(build: Builder, view: View, table: OrenNayarTable, owner: str) -> bpy.types.NodeSocket:
    sigma = float(fujii_roughness(table.sigma_deg))
    colors = table.weight
    if working_space() != REC709:  # of its color such a node is not linear, so the energies are what is converted
        energy = into_working(oren_nayar_albedo(knot_cosines(), colors, table.sigma_deg, table.power))
        colors = out_of_working(oren_nayar_color(knot_cosines(), energy, table.sigma_deg, table.power))
    return build.shader("ShaderNodeBsdfDiffuse", Color=weight_at(build, view, colors, table.axis), Roughness=sigma, **view.own_normal)


_LOBES = {
    BaseColorTable: _base,
    RoughBase: rough_base,
    DiffuseTable: _lambert,
    OrenNayarTable: _oren_nayar,
    GlossyTable: lambda build, view, table, owner: glossy(build, view, table),
}
