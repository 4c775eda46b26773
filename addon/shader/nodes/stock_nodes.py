# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set in tables as Blender's own nodes: for Blenders and devices without OSL, and for EEVEE.

Tables over the view are Color Ramps (`view_nodes`), which hold a weight, a color, or two numbers of a lobe's shape; tables over live
values too are an image (`live_nodes`).
"""

from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import reduce

import bpy
import numpy as np

from ....reference_py.lobes.eevee import eevee_tables
from ....reference_py.lobes.live_tables import LiveTables
from ....reference_py.lobes.lobe import ConductorCurve
from ....reference_py.lobes.patch_lobes import PatchLobes
from ....reference_py.lobes.pools import MAX_NODE_CLOSURES
from ....reference_py.lobes.tabulate import is_grey_dielectric, tabulate, without_metals
from ....reference_py.lobes.view_table import (
    BASE_COLOR,
    BASE_SLOPES,
    KNOTS,
    BaseColorTable,
    DiffuseTable,
    GlossyTable,
    OrenNayarTable,
    RoughBase,
    TableLobes,
    is_glossy,
    knot_cosines,
)
from ....reference_py.material.schema import COLOR, COVERAGE, FLOAT, VECTOR
from ....reference_py.optics.diffuse import fujii_roughness, oren_nayar_albedo, oren_nayar_color
from ....reference_py.optics.microfacet import SPECULAR_ALPHA
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
from ..working_space import REC709, into_working, out_of_working, primaries, working_space
from .live_nodes import LiveNodes
from .node_builder import Builder
from .rough_base_nodes import rough_base
from .table_lookup import EnvironmentLookup, ImageLookup
from .view_nodes import STEP, View, in_space, numbers, ramp

# Lobe sets in tables, as `tabulate` makes them.
Tables = TableLobes | LiveTables | PatchLobes

_BASE_INPUTS = {BASE_COLOR: base_color_input, BASE_SLOPES: base_slopes_input}
SPACE_MARK = "Rec.709 Red"
_SOCKETS = {FLOAT: "NodeSocketFloat", COLOR: "NodeSocketColor", VECTOR: "NodeSocketVector"}
_DISTRIBUTIONS = {"ggx": "GGX", "beckmann": "BECKMANN"}
# Cycles evaluates isotropic lobes in float32 from 1 - cos^2, off by 3e-7 / alpha^2. Below this alpha the error of the
# least anisotropy that a Glossy node does not ignore, 1e-3, is the smaller one.
NARROW_ALPHA = 0.017
_LEAST_ANISOTROPY = 1.01e-4
# Of the Metallic node, to which any anisotropy will do, and the alpha below which it is given (osl/break_isotropy.h).
_SLIGHT_ANISOTROPY, _NARROW_DIELECTRIC_ALPHA = 2e-6, 0.06
# A table that is anisotropic the other way by no more than this counts as isotropic.
_NEARLY_ISOTROPIC = 1e-3


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
        closure = _pooled(build, view, lobe_set, shares) if _is_crowded(lobe_set) else _patched(build, view, lobe_set, shares)
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
    part = _part_of(build, view, lobe_set, owners)
    return _sum(build, [part.closure(i) for i in range(len(lobe_set.tables))])


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


def _sum(build: Builder, closures: list[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    head, *tail = closures
    return build.shader("ShaderNodeAddShader", head, _sum(build, tail)) if tail else head


def _lambert(build: Builder, view: View, table: DiffuseTable, owner: str) -> bpy.types.NodeSocket:
    return build.shader("ShaderNodeBsdfDiffuse", Color=_weight(build, view, table.weight, table.axis), Roughness=0.0, **view.own_normal)


def _base(build: Builder, view: View, table: BaseColorTable, owner: str) -> bpy.types.NodeSocket:
    color = _base_weight(build, view, table, owner)
    if table.distribution is not None:
        return _glossy(build, view, table.now, owner, color)
    return build.shader("ShaderNodeBsdfDiffuse", Color=color, Roughness=0.0, **view.own_normal)


def _base_weight(build: Builder, view: View, table: BaseColorTable, owner: str) -> bpy.types.NodeSocket:
    """own + through c / (1 - back c), channel by channel of Rec.709: numbers, which Blender would convert if they were colors."""
    columns = _columns(build, view, np.column_stack([table.through, table.own]))
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
    return build.shader("ShaderNodeBsdfDiffuse", Color=_weight(build, view, colors, table.axis), Roughness=sigma, **view.own_normal)


def _part_of(build: Builder, view: View, lobe_set: TableLobes | LiveTables, owners: Sequence[str]) -> "_FixedPart | _LivePart":
    return _LivePart(build, view, lobe_set, owners) if isinstance(lobe_set, LiveTables) else _FixedPart(build, view, lobe_set, owners)


def _views(view: View, lobe_set: TableLobes | LiveTables, owners: Sequence[str]) -> list[View]:
    """The view of each table from the normal that it is about."""
    return [view.about(None if table.normal is None else normal_input(table.normal, owners)) for table in lobe_set.tables]


class _FixedPart:
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
            _base_weight(self._build, view, table, self._owner) if isinstance(table, BaseColorTable) else _weight(self._build, view, table.weight, table.axis)
        )

    def columns(self, number: int) -> list:
        return _columns(self._build, self._views[number], self.tables[number].shape)

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


class _LivePart:
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
            return _metallic_node(build, view, table.distribution, *self._nodes[number].metal(table.fresnel), root_x, shape)
        if table.fresnel is not None:
            index = self._nodes[number].index or table.fresnel.eta
            return _metallic_node(build, view, table.distribution, build.combined([index] * 3), (0.0,) * 3, root_x, shape)
        roughness = root_x if root_x is root_y else build.math("SQRT", build.math("MULTIPLY", root_x, root_y))

        def anisotropy():
            return _anisotropy(build, lambda a, b: build.math("DIVIDE", a, b), root_x, root_y, shape)

        frame = self._nodes[number].brushing if table.is_brushed else None
        return _glossy_node(build, view, table.distribution, self.weight(number), roughness, anisotropy, slope, shape, frame)

    def is_same(self, number: int, other, other_number: int) -> bool:
        return False


def _glossy(build: Builder, view: View, table: GlossyTable, owner: str, color=None) -> bpy.types.NodeSocket:
    if table.fresnel is not None:
        return _dielectric(build, view, table)
    color = _weight(build, view, table.weight, table.axis) if color is None else color
    alpha_x, alpha_y, slope = _columns(build, view, table.shape)
    round_ = _is_round(table.shape)
    roughness = build.math("SQRT", alpha_x if round_ else build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y)))

    def anisotropy():
        return _anisotropy(build, lambda a, b: build.math("SQRT", build.math("DIVIDE", a, b)), alpha_x, alpha_y, table.shape)

    return _glossy_node(build, view, table.distribution, color, roughness, anisotropy, slope, table.shape, table.frame)


def _is_round(shape: np.ndarray) -> bool:
    return bool(np.all(shape[:, 0] == shape[:, 1]))


def _glossy_node(
    build: Builder,
    view: View,
    distribution: str,
    color,
    roughness,
    anisotropy: Callable,
    slope,
    shape: np.ndarray,
    frame: float | bpy.types.NodeSocket | None = None,
) -> bpy.types.NodeSocket:
    """A Glossy node of these operands; `shape` (n, 3) is all that its alphas and slope can be, and `anisotropy` is asked where it is not round.

    `frame` is in radians from the tangent, or a socket of full turns.
    """
    sockets = {"Color": color, "Roughness": roughness}
    if _is_round(shape) and np.min(shape[:, 0]) < NARROW_ALPHA < np.max(shape[:, 0]):
        sockets["Anisotropy"] = build.math("MULTIPLY", build.math("LESS_THAN", roughness, NARROW_ALPHA**0.5), _LEAST_ANISOTROPY)
    else:
        sockets["Anisotropy"] = _kept_apart(build, 0.0 if _is_round(shape) else anisotropy(), shape[:, :2])
    if frame is not None:
        turns = frame if isinstance(frame, bpy.types.NodeSocket) else frame / (2.0 * np.pi)
        sockets["Tangent"], sockets["Rotation"] = view.given_tangent, turns
    elif sockets["Anisotropy"] != 0.0:
        sockets["Tangent"] = view.tangent
    if np.any(shape[:, 2]):
        sockets["Normal"] = build.vector("MULTIPLY_ADD", view.side, slope, view.normal)
    else:
        sockets |= view.own_normal
    return build.shader("ShaderNodeBsdfAnisotropic", settings={"distribution": _DISTRIBUTIONS[distribution]}, **sockets)


def _dielectric(build: Builder, view: View, table: GlossyTable) -> bpy.types.NodeSocket:
    """A metal without extinction. Metallic nodes have no weight: what is missing to 1 is mixed off, what is more is added."""
    assert HAS_DIELECTRIC and is_grey_dielectric(table), "see reference_py.lobes.tabulate"
    closures = []
    for weight in (np.minimum(table.weight, 1.0), np.maximum(table.weight - 1.0, 0.0)):
        if np.all(weight == 1.0):
            closures.append(_bare_dielectric(build, view, table))
        elif np.any(weight > 0.0):
            share, _, _ = _columns(build, view, weight)
            mix = build.shader("ShaderNodeMixShader", share)
            build.link(_bare_dielectric(build, view, table), mix.node.inputs[2])
            closures.append(mix)
    return _sum(build, closures)


def _bare_dielectric(build: Builder, view: View, table: GlossyTable) -> bpy.types.NodeSocket:
    alpha, _, _ = _columns(build, view, table.shape)
    return _metallic_node(build, view, table.distribution, (table.fresnel.eta,) * 3, (0.0,) * 3, build.math("SQRT", alpha), table.shape)


def _metallic_node(build: Builder, view: View, distribution: str, index, extinction, roughness, shape: np.ndarray) -> bpy.types.NodeSocket:
    """A Metallic node of these operands; `shape` (n, 3) is all that its alphas can be."""
    sockets = {"IOR": index, "Extinction": extinction, "Roughness": roughness, "Anisotropy": 0.0} | view.own_normal
    if SPECULAR_ALPHA < np.min(shape[:, 0]) < _NARROW_DIELECTRIC_ALPHA:
        # as a constant, Cycles would take so little for none; no place is as small
        sockets |= {"Anisotropy": build.math("MINIMUM", view.place, _SLIGHT_ANISOTROPY), "Tangent": view.tangent}
    settings = {"distribution": _DISTRIBUTIONS[distribution], "fresnel_type": "PHYSICAL_CONDUCTOR"}
    return build.shader("ShaderNodeBsdfMetallic", settings=settings, **sockets)


def _anisotropy(build: Builder, ratio: Callable, x, y, shape: np.ndarray) -> bpy.types.NodeSocket:
    """Cycles' alphas are R (1 - a) and R / (1 - a) for a > 0, R / (1 + a) and R (1 + a) for a < 0.

    So a = (1 - s) / max(s, 1) with s = sqrt(alpha_x / alpha_y), and R = sqrt(alpha_x alpha_y). Of most lobes one side is enough.
    `ratio` gives s, or one over it, of two operands.
    """
    if np.all(shape[:, 0] <= shape[:, 1]):
        return build.math("SUBTRACT", 1.0, ratio(x, y))
    if np.all(shape[:, 0] >= shape[:, 1]):
        return build.math("SUBTRACT", ratio(y, x), 1.0)
    s = ratio(x, y)
    return build.math("DIVIDE", build.math("SUBTRACT", 1.0, s), build.math("MAXIMUM", s, 1.0))


def _kept_apart(build: Builder, anisotropy, alphas: np.ndarray):
    """The anisotropy, for a narrow lobe not so small that Cycles takes it for isotropic."""
    if not SPECULAR_ALPHA < np.min(alphas) < NARROW_ALPHA:
        return anisotropy
    across = np.log(alphas[:, 1] / alphas[:, 0])
    if np.min(across) > -_NEARLY_ISOTROPIC:
        return build.math("MAXIMUM", anisotropy, _LEAST_ANISOTROPY)
    if np.max(across) < _NEARLY_ISOTROPIC:
        return build.math("MINIMUM", anisotropy, -_LEAST_ANISOTROPY)
    return anisotropy


def _pooled(build: Builder, view: View, lobe_set: PatchLobes, covers: dict[str, bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    """Many patches as few closures: one Lambert of all, one of each pool (`reference_py.lobes.pools`), and one of equal tables."""
    lambert, pools, alone = [], {}, []
    for number, ((patch, tables), share) in enumerate(zip(lobe_set.parts, _shares(build, covers, lobe_set))):
        part = _part_of(build, view, tables, owners_of(patch))
        for i in range(len(part.tables)):
            if part.is_lambert(i):
                lambert.append(_share_of(build, part.weight(i), share))
            elif (number, i) in lobe_set.pools:
                pools.setdefault(lobe_set.pools[number, i], []).append((part, i, share))
            else:
                place = next((n for n, (known, k, _) in enumerate(alone) if known.is_same(k, part, i)), len(alone))
                alone[place:] = [(part, i, build.math("ADD", alone[place][2], share) if place < len(alone) else share), *alone[place + 1 :]]
    closures = [build.shader("ShaderNodeBsdfDiffuse", Color=_total(build, lambert), Roughness=0.0)] if lambert else []
    closures += [_pool(build, view, members) for members in pools.values()]
    for part, i, share in alone:
        mix = build.shader("ShaderNodeMixShader", share)
        build.link(part.closure(i), mix.node.inputs[2])
        closures.append(mix)
    return _sum(build, closures)


def _shares(build: Builder, covers: dict[str, bpy.types.NodeSocket], lobe_set: PatchLobes) -> list[bpy.types.NodeSocket]:
    """The share of each patch; what patches begin with alike is multiplied once."""
    found: dict[tuple, bpy.types.NodeSocket] = {}

    def share(covered):
        if covered not in found:
            layer, there = covered[-1]
            cover = covers[layer_owner(layer)] if there else build.math("SUBTRACT", 1.0, covers[layer_owner(layer)])
            found[covered] = build.math("MULTIPLY", share(covered[:-1]), cover) if covered[:-1] else cover
        return found[covered]

    return [share(patch.covered) for patch, _ in lobe_set.parts]


def _share_of(build: Builder, weight, share) -> bpy.types.NodeSocket:
    return build.vector("SCALE", weight if isinstance(weight, bpy.types.NodeSocket) else weight[:3], scale=share)


def _total(build: Builder, parts: list[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    return reduce(lambda a, b: build.vector("ADD", a, b), parts)


def _pool(build: Builder, view: View, members: list) -> bpy.types.NodeSocket:
    parts = [_share_of(build, part.weight(i), share) for part, i, share in members]
    energies = [build.vector("DOT_PRODUCT", part, (1.0 / 3.0,) * 3) for part in parts]
    shapes = [build.combined(part.columns(i)) for part, i, _ in members]
    least = build.math("MAXIMUM", reduce(lambda a, b: build.math("ADD", a, b), energies), 1e-20)
    summed = _total(build, [build.vector("SCALE", shape, scale=energy) for shape, energy in zip(shapes, energies)])
    separate = build.node("ShaderNodeSeparateXYZ")
    build.link(build.vector("SCALE", summed, scale=build.math("DIVIDE", 1.0, least)), separate.inputs[0])
    alpha_x, alpha_y, slope = separate.outputs
    s = build.math("SQRT", build.math("DIVIDE", alpha_x, build.math("MAXIMUM", alpha_y, 1e-12)))
    anisotropy = build.math("DIVIDE", build.math("SUBTRACT", 1.0, s), build.math("MAXIMUM", s, 1.0))
    return build.shader(
        "ShaderNodeBsdfAnisotropic",
        settings={"distribution": _DISTRIBUTIONS[members[0][0].tables[members[0][1]].distribution]},
        Color=_total(build, parts),
        Roughness=build.math("SQRT", build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y))),
        Anisotropy=anisotropy,
        Tangent=view.tangent,
        Normal=build.vector("MULTIPLY_ADD", view.side, slope, view.normal),
    )


_LOBES = {BaseColorTable: _base, RoughBase: rough_base, DiffuseTable: _lambert, OrenNayarTable: _oren_nayar, GlossyTable: _glossy}


def _weight(build: Builder, view: View, table: np.ndarray, axis: float | None):
    """A colour at the view: ramps, or a constant."""
    if axis is not None:
        sheets = [build.vector("SCALE", _view_ramp(build, view, sheet), scale=share) for share, sheet in zip(view.azimuth_shares(axis), table)]
        return reduce(lambda a, b: build.vector("ADD", a, b), sheets)
    if np.all(table == table[0]):
        return (*map(float, into_working(table[0])), 1.0)
    return _view_ramp(build, view, table)


def _columns(build: Builder, view: View, table: np.ndarray) -> list:
    """The columns of numbers (KNOTS, 3) at the view."""
    return numbers(build, view.place, STEP * np.arange(KNOTS), table)


def _view_ramp(build: Builder, view: View, table: np.ndarray) -> bpy.types.NodeSocket:
    """The colors (KNOTS, 3) of the model, none of them negative, at the view."""
    return ramp(build, view.place, STEP * np.arange(KNOTS), np.column_stack([into_working(table), np.ones(KNOTS)])).outputs["Color"]
