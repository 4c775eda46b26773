# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set in tables as Blender's own nodes: for Blenders and devices without OSL, and for EEVEE.

Tables are Color Ramps. Cycles samples a ramp at 256 even steps and is linear between; every knot is put exactly on such
a place, so a ramp is the table itself, up to float32. A ramp holds a weight, a color, or two numbers of a lobe's shape.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cached_property, reduce
from types import MappingProxyType

import bpy
import numpy as np

from ....reference_py.lobes.eevee import eevee_tables
from ....reference_py.lobes.patch_lobes import PatchLobes
from ....reference_py.lobes.pools import MAX_NODE_CLOSURES
from ....reference_py.lobes.tabulate import is_grey_dielectric, tabulate
from ....reference_py.lobes.view_table import AZIMUTH_PLACES, KNOTS, BaseColorTable, DiffuseTable, GlossyTable, OrenNayarTable, TableLobes, knot_cosines
from ....reference_py.material.schema import COLOR, COVERAGE, FLOAT, NORMAL, VECTOR
from ....reference_py.material.stack import Stack
from ....reference_py.optics.diffuse import fujii_roughness, oren_nayar_albedo, oren_nayar_color
from ....reference_py.optics.microfacet import SPECULAR_ALPHA
from ...blender.versions import DIFFUSE_POWER, HAS_DIELECTRIC
from ..inputs import BASE, TANGENT, TANGENT_INPUT, ShaderInput, base_color_input, layer_owner, owners_of, shader_inputs
from ..working_space import REC709, into_working, out_of_working, primaries, working_space
from .node_builder import Builder

SPACE_MARK = "Rec.709 Red"
_RAMP_PLACES = 256
# Places of a ramp from one knot to the next, the most that fit.
_STEP = _RAMP_PLACES // (KNOTS - 1)
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
# Any direction, added to the tangent: without it the tangent would vanish at the very normal, and Cycles divide by 0.
_SOME_DIRECTION = (5.7e-7, 3.1e-7, 7.6e-7)


def stock_tables(made) -> TableLobes | PatchLobes:
    """A lobe set in tables of the lobes that this Blender's nodes have."""
    return tabulate(made.lobe_set, HAS_DIELECTRIC, DIFFUSE_POWER)


def eevee_stock_tables(made) -> TableLobes | PatchLobes:
    """A lobe set in tables whose energies are right in EEVEE."""
    return eevee_tables(made.lobe_set)


def group_inputs(lobe_set: TableLobes | PatchLobes, owner: str = BASE) -> tuple[ShaderInput, ...]:
    """What the group reads live: the coverage of every layer that has one, a base's color where tables follow it, and the tangent.

    `owner` is whose the base's color is.
    """
    if isinstance(lobe_set, TableLobes):
        framed = any(getattr(table, "axis", None) is not None or getattr(table, "frame", None) is not None for table in lobe_set.tables)
        return (*([TANGENT_INPUT] if framed else []), *([base_color_input(owner)] if lobe_set.followed else []))
    covers = [i for i in shader_inputs(lobe_set.stack) if i.parameter in COVERAGE.parameters]
    return (*covers, *dict.fromkeys(i for patch, part in lobe_set.parts for i in group_inputs(part, owners_of(patch)[-1])))


def left_out(stack: Stack) -> str:
    """What these nodes leave out of a stack, in words; empty where it is nothing."""
    elements = [*((f"layer {i}", e) for i, e in enumerate(stack.layers)), ("the base", stack.base)]
    bent = [where for where, element in elements if element.has(NORMAL)]
    return f"stock nodes leave out the normal of {', '.join(bent)}" if bent else ""


def closure_count(lobe_set: TableLobes | PatchLobes) -> int:
    """Closures of the group: patches share none unless they are too many."""
    if isinstance(lobe_set, TableLobes) or _is_crowded(lobe_set):
        return lobe_set.lobe_count
    return sum(part.lobe_count for _, part in lobe_set.parts)


def _is_crowded(lobe_set: PatchLobes) -> bool:
    """Whether patches cannot each have closures of their own."""
    return sum(part.lobe_count for _, part in lobe_set.parts) > MAX_NODE_CLOSURES


def build_group(tree: bpy.types.NodeTree, lobe_set: TableLobes | PatchLobes) -> None:
    """Fill an empty node group with what a lobe set that `tabulate` made does: one output "BSDF", and `group_inputs`."""
    build = Builder(tree)
    inputs = group_inputs(lobe_set)
    for given in inputs:
        tree.interface.new_socket(given.osl_name, in_out="INPUT", socket_type=_SOCKETS[given.parameter.type])
    sockets = {}
    if inputs:
        node = build.node("NodeGroupInput")
        sockets = {given.osl_name: node.outputs[given.osl_name] for given in inputs}
    view = _View(build, sockets.get(TANGENT), sockets)
    if isinstance(lobe_set, TableLobes):
        closure = _closure_of(build, view, lobe_set, BASE)
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


def _closure_of(build: Builder, view: "_View", lobe_set: TableLobes, owner: str) -> bpy.types.NodeSocket:
    view.base_owner = owner
    return _sum(build, [_LOBES[type(table)](build, view, table) for table in lobe_set.tables])


def _patched(build: Builder, view: "_View", lobe_set: PatchLobes, shares: dict[str, bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    closures = [_closure_of(build, view, part, owners_of(patch)[-1]) for patch, part in lobe_set.parts]
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


class _View:
    """What lobes need of the view, made when the first of them asks."""

    def __init__(self, build: Builder, given_tangent: bpy.types.NodeSocket | None = None, sockets: Mapping[str, bpy.types.NodeSocket] = MappingProxyType({})):
        self._build, self.given_tangent, self._sockets = build, given_tangent, sockets
        self.base_owner = BASE
        self._base_colors: dict[str, bpy.types.NodeSocket] = {}
        self._azimuths: dict[float, list[bpy.types.NodeSocket]] = {}

    @cached_property
    def normal(self) -> bpy.types.NodeSocket:
        """The normal as Cycles bends it for a glossy lobe (osl/bent.h), with 0 for the least height, to save nodes.

        EEVEE bends nothing: its lobes keep their normal, and have the energy of this one.
        """
        build, shading, true = self._build, self._geometry.outputs["Normal"], self._geometry.outputs["True Normal"]
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
    def place(self) -> bpy.types.NodeSocket:
        """Where in a ramp the view is."""
        return self._build.math("MULTIPLY", self._build.math("SQRT", self._cosine), _STEP * (KNOTS - 1) / _RAMP_PLACES)

    @cached_property
    def side(self) -> bpy.types.NodeSocket:
        """Along the plane of incidence, as long as the sine of the view."""
        along_normal = self._build.vector("SCALE", self.normal, scale=self._cosine)
        return self._build.vector("SUBTRACT", self._incoming, along_normal)

    @property
    def base_color(self) -> bpy.types.NodeSocket:
        """The color of the base of `base_owner` in Rec.709, from 0 to 1."""
        if self.base_owner not in self._base_colors:
            given = self._sockets[base_color_input(self.base_owner).osl_name]
            color = _in_space(self._build, given, np.linalg.inv(primaries()))
            self._base_colors[self.base_owner] = self._build.vector("MINIMUM", self._build.vector("MAXIMUM", color, 0.0), 1.0)
        return self._base_colors[self.base_owner]

    def azimuth_shares(self, axis: float) -> list[bpy.types.NodeSocket]:
        """How much of each sheet of a table with this axis a view takes (`reference_py.lobes.view_table`)."""
        if axis not in self._azimuths:
            self._azimuths[axis] = self._shares(axis)
        return self._azimuths[axis]

    def _shares(self, axis: float) -> list[bpy.types.NodeSocket]:
        build = self._build
        across = build.vector("NORMALIZE", build.vector("CROSS_PRODUCT", self.normal, self.given_tangent))
        along = build.vector("CROSS_PRODUCT", across, self.normal)
        direction = build.vector("ADD", build.vector("SCALE", along, scale=float(np.cos(axis))), build.vector("SCALE", across, scale=float(np.sin(axis))))
        # along the normal all azimuths have the same weights
        length = build.math("MAXIMUM", build.vector("LENGTH", self.side), 1e-6)
        cosine = build.math("ABSOLUTE", build.math("DIVIDE", build.vector("DOT_PRODUCT", self.side, direction), length))
        place = build.math("MULTIPLY", cosine, AZIMUTH_PLACES[-1] / _RAMP_PLACES)
        return _numbers(build, place, AZIMUTH_PLACES, np.eye(len(AZIMUTH_PLACES)))

    @cached_property
    def tangent(self) -> bpy.types.NodeSocket:
        return self._build.vector("ADD", self.side, _SOME_DIRECTION)


def _lambert(build: Builder, view: _View, table: DiffuseTable) -> bpy.types.NodeSocket:
    return build.shader("ShaderNodeBsdfDiffuse", Color=_weight(build, view, table.weight, table.axis), Roughness=0.0)


def _base(build: Builder, view: _View, table: BaseColorTable) -> bpy.types.NodeSocket:
    return build.shader("ShaderNodeBsdfDiffuse", Color=_base_weight(build, view, table), Roughness=0.0)


def _base_weight(build: Builder, view: _View, table: BaseColorTable) -> bpy.types.NodeSocket:
    """own + through c / (1 - back c), channel by channel of Rec.709: numbers, which Blender would convert if they were colors."""
    color = view.base_color
    once = build.vector("DIVIDE", color, build.vector("MULTIPLY_ADD", color, build.combined(_columns(build, view, -table.back)), 1.0))
    columns = _columns(build, view, np.column_stack([table.through, table.own]))
    weight = build.vector("MULTIPLY_ADD", once, build.combined(columns[:3]), build.combined(columns[3:]))
    return _in_space(build, weight, primaries())


def _in_space(build: Builder, color: bpy.types.NodeSocket, rows: np.ndarray) -> bpy.types.NodeSocket:
    """The color times a matrix (3, 3) between Rec.709 and the working space; itself where that is Rec.709."""
    if working_space() == REC709:
        return color
    return build.combined([build.vector("DOT_PRODUCT", color, tuple(map(float, column))) for column in rows.T])


def _oren_nayar(build: Builder, view: _View, table: OrenNayarTable) -> bpy.types.NodeSocket:
    sigma = float(fujii_roughness(table.sigma_deg))
    colors = table.weight
    if working_space() != REC709:  # of its color such a node is not linear, so the energies are what is converted
        energy = into_working(oren_nayar_albedo(knot_cosines(), colors, table.sigma_deg, table.power))
        colors = out_of_working(oren_nayar_color(knot_cosines(), energy, table.sigma_deg, table.power))
    return build.shader("ShaderNodeBsdfDiffuse", Color=_weight(build, view, colors, table.axis), Roughness=sigma)


def _glossy(build: Builder, view: _View, table: GlossyTable) -> bpy.types.NodeSocket:
    if table.fresnel is not None:
        return _dielectric(build, view, table)
    sockets = {"Color": _weight(build, view, table.weight, table.axis)}
    alpha_x, alpha_y, slope = _columns(build, view, table.shape)
    if np.all(table.shape[:, 0] == table.shape[:, 1]):
        sockets["Roughness"], anisotropy = build.math("SQRT", alpha_x), 0.0
    else:
        sockets["Roughness"] = build.math("SQRT", build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y)))
        anisotropy = _anisotropy(build, alpha_x, alpha_y, table.shape)
    sockets["Anisotropy"] = _kept_apart(build, anisotropy, table.shape[:, :2])
    if table.frame is not None:
        sockets["Tangent"], sockets["Rotation"] = view.given_tangent, table.frame / (2.0 * np.pi)
    elif sockets["Anisotropy"] != 0.0:
        sockets["Tangent"] = view.tangent
    if np.any(table.shape[:, 2]):
        sockets["Normal"] = build.vector("MULTIPLY_ADD", view.side, slope, view.normal)
    return build.shader("ShaderNodeBsdfAnisotropic", settings={"distribution": _DISTRIBUTIONS[table.distribution]}, **sockets)


def _dielectric(build: Builder, view: _View, table: GlossyTable) -> bpy.types.NodeSocket:
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


def _bare_dielectric(build: Builder, view: _View, table: GlossyTable) -> bpy.types.NodeSocket:
    alpha, _, _ = _columns(build, view, table.shape)
    sockets = {"IOR": (table.fresnel.eta,) * 3, "Extinction": (0.0,) * 3, "Roughness": build.math("SQRT", alpha), "Anisotropy": 0.0}
    if SPECULAR_ALPHA < np.min(table.shape[:, 0]) < _NARROW_DIELECTRIC_ALPHA:
        # as a constant, Cycles would take so little for none; no place is as small
        sockets |= {"Anisotropy": build.math("MINIMUM", view.place, _SLIGHT_ANISOTROPY), "Tangent": view.tangent}
    settings = {"distribution": _DISTRIBUTIONS[table.distribution], "fresnel_type": "PHYSICAL_CONDUCTOR"}
    return build.shader("ShaderNodeBsdfMetallic", settings=settings, **sockets)


def _anisotropy(build: Builder, alpha_x, alpha_y, shape: np.ndarray) -> bpy.types.NodeSocket:
    """Cycles' alphas are R (1 - a) and R / (1 - a) for a > 0, R / (1 + a) and R (1 + a) for a < 0.

    So a = (1 - s) / max(s, 1) with s = sqrt(alpha_x / alpha_y), and R = sqrt(alpha_x alpha_y). Of most lobes one side is enough.
    """
    if np.all(shape[:, 0] <= shape[:, 1]):
        return build.math("SUBTRACT", 1.0, build.math("SQRT", build.math("DIVIDE", alpha_x, alpha_y)))
    if np.all(shape[:, 0] >= shape[:, 1]):
        return build.math("SUBTRACT", build.math("SQRT", build.math("DIVIDE", alpha_y, alpha_x)), 1.0)
    s = build.math("SQRT", build.math("DIVIDE", alpha_x, alpha_y))
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


def _pooled(build: Builder, view: _View, lobe_set: PatchLobes, covers: dict[str, bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    """Many patches as few closures: one Lambert of all, one of each pool (`reference_py.lobes.pools`), and one of equal tables."""
    lambert, pools, alone = [], {}, []
    for number, ((patch, part), share) in enumerate(zip(lobe_set.parts, _shares(build, covers, lobe_set))):
        view.base_owner = owners_of(patch)[-1]
        for i, table in enumerate(part.tables):
            if isinstance(table, BaseColorTable):
                lambert.append(_part_of(build, _base_weight(build, view, table), share))
            elif isinstance(table, DiffuseTable):
                lambert.append(_part_of(build, _weight(build, view, table.weight, table.axis), share))
            elif (number, i) in lobe_set.pools:
                pools.setdefault(lobe_set.pools[number, i], []).append((table, share))
            else:
                place = next((n for n, (known, _) in enumerate(alone) if _is_equal(known, table)), len(alone))
                alone[place:] = [(table, build.math("ADD", alone[place][1], share) if place < len(alone) else share), *alone[place + 1 :]]
    closures = [build.shader("ShaderNodeBsdfDiffuse", Color=_total(build, lambert), Roughness=0.0)] if lambert else []
    closures += [_pool(build, view, members) for members in pools.values()]
    for table, share in alone:
        mix = build.shader("ShaderNodeMixShader", share)
        build.link(_LOBES[type(table)](build, view, table), mix.node.inputs[2])
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


def _part_of(build: Builder, weight, share) -> bpy.types.NodeSocket:
    return build.vector("SCALE", weight if isinstance(weight, bpy.types.NodeSocket) else weight[:3], scale=share)


def _total(build: Builder, parts: list[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    return reduce(lambda a, b: build.vector("ADD", a, b), parts)


def _pool(build: Builder, view: _View, members: list[tuple[GlossyTable, bpy.types.NodeSocket]]) -> bpy.types.NodeSocket:
    parts = [_part_of(build, _weight(build, view, table.weight, table.axis), share) for table, share in members]
    energies = [build.vector("DOT_PRODUCT", part, (1.0 / 3.0,) * 3) for part in parts]
    shapes = [build.combined(_columns(build, view, table.shape)) for table, _ in members]
    least = build.math("MAXIMUM", reduce(lambda a, b: build.math("ADD", a, b), energies), 1e-20)
    summed = _total(build, [build.vector("SCALE", shape, scale=energy) for shape, energy in zip(shapes, energies)])
    separate = build.node("ShaderNodeSeparateXYZ")
    build.link(build.vector("SCALE", summed, scale=build.math("DIVIDE", 1.0, least)), separate.inputs[0])
    alpha_x, alpha_y, slope = separate.outputs
    s = build.math("SQRT", build.math("DIVIDE", alpha_x, build.math("MAXIMUM", alpha_y, 1e-12)))
    anisotropy = build.math("DIVIDE", build.math("SUBTRACT", 1.0, s), build.math("MAXIMUM", s, 1.0))
    return build.shader(
        "ShaderNodeBsdfAnisotropic",
        settings={"distribution": _DISTRIBUTIONS[members[0][0].distribution]},
        Color=_total(build, parts),
        Roughness=build.math("SQRT", build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y))),
        Anisotropy=anisotropy,
        Tangent=view.tangent,
        Normal=build.vector("MULTIPLY_ADD", view.side, slope, view.normal),
    )


def _is_equal(first, second) -> bool:
    if type(first) is not type(second):
        return False
    return all(np.array_equal(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))


_LOBES = {BaseColorTable: _base, DiffuseTable: _lambert, OrenNayarTable: _oren_nayar, GlossyTable: _glossy}


def _weight(build: Builder, view: _View, table: np.ndarray, axis: float | None):
    """A colour at the view: ramps, or a constant."""
    if axis is not None:
        sheets = [build.vector("SCALE", _view_ramp(build, view, sheet), scale=share) for share, sheet in zip(view.azimuth_shares(axis), table)]
        return reduce(lambda a, b: build.vector("ADD", a, b), sheets)
    if np.all(table == table[0]):
        return (*map(float, into_working(table[0])), 1.0)
    return _view_ramp(build, view, table)


def _columns(build: Builder, view: _View, table: np.ndarray) -> list:
    """The columns of numbers (KNOTS, 3) at the view."""
    return _numbers(build, view.place, _STEP * np.arange(KNOTS), table)


def _numbers(build: Builder, place: bpy.types.NodeSocket, places: Sequence[int], table: np.ndarray) -> list:
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
        node = _ramp(build, place, places, np.column_stack([np.repeat((table[:, first] - offset[first])[:, None], 3, axis=1), alpha]))
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


def _view_ramp(build: Builder, view: _View, table: np.ndarray) -> bpy.types.NodeSocket:
    """The colors (KNOTS, 3) of the model, none of them negative, at the view."""
    return _ramp(build, view.place, _STEP * np.arange(KNOTS), np.column_stack([into_working(table), np.ones(KNOTS)])).outputs["Color"]


def _ramp(build: Builder, place: bpy.types.NodeSocket, places: Sequence[int], table: np.ndarray) -> bpy.types.Node:
    """A Color Ramp of colors and alpha (n, 4), none of them negative, at these places (n,) of the ramp's."""
    node = build.node("ShaderNodeValToRGB")
    elements = node.color_ramp.elements
    for _ in range(len(places) - len(elements)):
        elements.new(1.0)
    # each color that is set by itself makes Blender look through the whole tree
    elements.foreach_set("position", np.asarray(places, np.float32) / _RAMP_PLACES)
    elements.foreach_set("color", np.asarray(table, np.float32).ravel())
    build.link(place, node.inputs[0])
    return node
