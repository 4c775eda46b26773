# SPDX-License-Identifier: GPL-3.0-or-later
"""Many patches of layers as few closures."""

from functools import reduce

import bpy

from ....reference_py.lobes.patch_lobes import PatchLobes
from ..inputs import layer_owner, owners_of
from .glossy_nodes import DISTRIBUTIONS
from .lobe_nodes import part_of
from .node_builder import Builder
from .view_nodes import View


def pooled(build: Builder, view: View, lobe_set: PatchLobes, covers: dict[str, bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    """Many patches as few closures: one Lambert of all, one of each pool (`reference_py.lobes.pools`), and one of equal tables."""
    lambert, pools, alone = [], {}, []
    for number, ((patch, tables), share) in enumerate(zip(lobe_set.parts, _shares(build, covers, lobe_set))):
        part = part_of(build, view, tables, owners_of(patch))
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
    return build.sum(closures)


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
        settings={"distribution": DISTRIBUTIONS[members[0][0].tables[members[0][1]].distribution]},
        Color=_total(build, parts),
        Roughness=build.math("SQRT", build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y))),
        Anisotropy=anisotropy,
        Tangent=view.tangent,
        Normal=build.vector("MULTIPLY_ADD", view.side, slope, view.normal),
    )
