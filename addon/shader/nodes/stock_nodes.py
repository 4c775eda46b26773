# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set in tables as Blender's own nodes: for Blenders and devices without OSL, and for EEVEE.

Tables over the view are Color Ramps (`view_nodes`), which hold a weight, a color, or two numbers of a lobe's shape; tables over live
values too are an image (`live_nodes`).
"""

from collections.abc import Sequence

import bpy

from ....reference_py.lobes.eevee import eevee_tables
from ....reference_py.lobes.live_tables import LiveTables
from ....reference_py.lobes.patch_lobes import PatchLobes
from ....reference_py.lobes.pools import MAX_NODE_CLOSURES
from ....reference_py.lobes.tabulate import tabulate, without_metals
from ....reference_py.lobes.view_table import BASE_COLOR, BASE_SLOPES, TableLobes
from ....reference_py.material.schema import COLOR, COVERAGE, FLOAT, VECTOR
from ...blender.versions import DIFFUSE_POWER, HAS_DIELECTRIC
from ..inputs import (
    BASE,
    TANGENT,
    TANGENT_INPUT,
    ShaderInput,
    base_color_input,
    base_slopes_input,
    layer_owner,
    normal_input,
    owners_of,
    place_input,
    shader_inputs,
)
from ..working_space import REC709, into_working, working_space
from .lobe_nodes import part_of
from .node_builder import Builder
from .pooled_nodes import pooled
from .table_lookup import EnvironmentLookup, ImageLookup
from .view_nodes import View

# Lobe sets in tables, as `tabulate` makes them.
Tables = TableLobes | LiveTables | PatchLobes

_BASE_INPUTS = {BASE_COLOR: base_color_input, BASE_SLOPES: base_slopes_input}
SPACE_MARK = "Rec.709 Red"
_SOCKETS = {FLOAT: "NodeSocketFloat", COLOR: "NodeSocketColor", VECTOR: "NodeSocketVector"}


def stock_tables(made) -> Tables:
    """A lobe set in tables of the lobes that this Blender's nodes have."""
    if working_space() != REC709:  # a Metallic node's index is that of the working space's channels
        made = without_metals(made)
    return tabulate(made.lobe_set, HAS_DIELECTRIC, DIFFUSE_POWER)


def eevee_stock_tables(made, tables: Tables) -> Tables:
    """A lobe set in tables whose energies are right in EEVEE; `tables` are its `stock_tables`."""
    return eevee_tables(made.lobe_set, tables)


def group_inputs(lobe_set: Tables, owners: Sequence[str] | None = None) -> tuple[ShaderInput, ...]:
    """What the group reads live: the coverage of every layer that has one, the values that tables follow, and the tangent.

    `owners` are those of the layers and the base, see `owners_of`; those of the whole stack unless given.
    """
    if isinstance(lobe_set, LiveTables | TableLobes):
        owners = owners or _whole(lobe_set)
        normals = [normal_input(table.normal, owners) for table in lobe_set.tables if table.normal is not None]
        if isinstance(lobe_set, LiveTables):
            followed = [place_input(lobe_set.stack, place, owners) for place in lobe_set.followed]
        else:
            followed = [_BASE_INPUTS[place](owners[-1]) for place in lobe_set.followed]
        return tuple(dict.fromkeys([*([TANGENT_INPUT] if lobe_set.is_brushed else []), *followed, *normals]))
    covers = [i for i in shader_inputs(lobe_set.stack) if i.parameter in COVERAGE.parameters]
    return (*covers, *dict.fromkeys(i for patch, part in lobe_set.parts for i in group_inputs(part, owners_of(patch))))


def _whole(lobe_set: TableLobes | LiveTables) -> list[str]:
    """Owners of a whole stack, as far as its tables need them."""
    layers = [table.normal.layer for table in lobe_set.tables if table.normal is not None and table.normal.layer is not None]
    count = len(lobe_set.stack.layers) if isinstance(lobe_set, LiveTables) else max(layers, default=-1) + 1
    return [*map(layer_owner, range(count)), BASE]


def closure_count(lobe_set: Tables) -> int:
    """Closures of the group: patches share none unless they are too many."""
    if not isinstance(lobe_set, PatchLobes) or _is_crowded(lobe_set):
        return lobe_set.lobe_count
    return sum(part.lobe_count for _, part in lobe_set.parts)


def _is_crowded(lobe_set: PatchLobes) -> bool:
    """Whether patches cannot each have closures of their own."""
    return sum(part.lobe_count for _, part in lobe_set.parts) > MAX_NODE_CLOSURES


def build_group(tree: bpy.types.NodeTree, lobe_set: Tables, in_eevee: bool) -> None:
    """Fill an empty node group with what a lobe set that `tabulate` made does: one output "BSDF", and `group_inputs`. Cycles alone shows it unless `in_eevee`."""
    build = Builder(tree)
    inputs = group_inputs(lobe_set)
    for given in inputs:
        tree.interface.new_socket(given.osl_name, in_out="INPUT", socket_type=_SOCKETS[given.parameter.type])
    sockets = {}
    if inputs:
        node = build.node("NodeGroupInput")
        sockets = {given.osl_name: node.outputs[given.osl_name] for given in inputs}
    view = View(build, EnvironmentLookup() if in_eevee else ImageLookup(), sockets.get(TANGENT), sockets)
    if not isinstance(lobe_set, PatchLobes):
        closure = _closure_of(build, view, lobe_set, _whole(lobe_set))
    else:
        shares = {i.owner: sockets[i.osl_name] for i in inputs if i.parameter in COVERAGE.parameters}
        closure = pooled(build, view, lobe_set, shares) if _is_crowded(lobe_set) else _patched(build, view, lobe_set, shares)
    tree.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    output = build.node("NodeGroupOutput")
    build.link(closure, output.inputs["BSDF"])
    _mark_space(build.node("ShaderNodeRGB"))
    build.arrange()


def _mark_space(node: bpy.types.Node) -> None:
    """Make an RGB node what Blender converts with the rest of a group: whoever reads it knows the space of the group's colors."""
    node.name = node.label = SPACE_MARK
    node.outputs[0].default_value = (*into_working((1.0, 0.0, 0.0)), 1.0)


def _closure_of(build: Builder, view: View, lobe_set: TableLobes | LiveTables, owners: Sequence[str]) -> bpy.types.NodeSocket:
    part = part_of(build, view, lobe_set, owners)
    return build.sum([part.closure(i) for i in range(len(lobe_set.tables))])


def _patched(build: Builder, view: View, lobe_set: PatchLobes, shares: dict[str, bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    closures = [_closure_of(build, view, part, owners_of(patch)) for patch, part in lobe_set.parts]
    return _mixed(build, shares, [(patch.covered, closure) for (patch, _), closure in zip(lobe_set.parts, closures)])


def _mixed(build: Builder, shares: dict[str, bpy.types.NodeSocket], patches: list) -> bpy.types.NodeSocket:
    """Patches, each the layers that decide about it and its closure: the first layer divides them, and so on down."""
    (covered, closure), *others = patches
    if not others:
        return closure
    layer, _ = covered[0]
    there, gone = (_mixed(build, shares, [(c[1:], closure) for c, closure in patches if c[0] == (layer, side)]) for side in (True, False))
    mix = build.shader("ShaderNodeMixShader", shares[layer_owner(layer)], gone)
    build.link(there, mix.node.inputs[2])
    return mix
