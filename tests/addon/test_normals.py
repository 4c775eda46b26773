# SPDX-License-Identifier: GPL-3.0-or-later
"""A normal of its own per layer: each closure renders as its closure model says in the frame of its layer's normal."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from support.goniometer import TOLERANCE, local_directions, parity

from lamina.addon.material import elements, material
from lamina.addon.rendering.measure import render_sun_sphere
from lamina.reference_py.lobes.closure import lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

OWN = {"normal": [0.0, 0.0, 0.0]}
COAT = {"kind": "dielectric", "ior": 1.5, "roughness": 0.5, "tint": [0.9, 0.7, 0.5]}
BENDS = {0: (0.15, 0.1, 0.05), 1: (-0.1, 0.2, 0.0), -1: (0.2, -0.15, 0.1)}
BASES = {
    "lambert": {"kind": "lambert", "color": [0.5, 0.4, 0.3]},
    "oren_nayar": {"kind": "oren_nayar", "color": [0.5, 0.4, 0.3]},
    "metal": {"kind": "conductor", "metal": "gold", "roughness": 0.5},
}


def shown(stack, tier):
    import bpy

    new = bpy.data.materials.new("bent")
    new.cycles.use_bump_map_correction = False  # which darkens diffuse closures whose normal is not the surface's
    material.apply_stack(new, stack, tier)
    return new


def bend(new, element, offset):
    """Link the normal of a layer to the surface's normal plus a world-space offset."""
    tree = new.node_tree
    geometry, add = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
    add.inputs[1].default_value = offset
    tree.links.new(geometry.outputs["Normal"], add.inputs[0])
    tree.links.new(add.outputs[0], elements.node_of(element).inputs["Normal"])


def bent(normal, offset):
    moved = normal + np.asarray(offset)
    return moved / np.linalg.norm(moved, axis=-1, keepdims=True)


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
@pytest.mark.parametrize("base", BASES)
def test_each_layer_renders_in_its_frame(blender, tier, base):
    """Two layers and the base; with one closure per element, each is the closure model's in its own frame."""
    layers = [{**COAT, **OWN}, {**COAT, "ior": 1.8, **OWN}]
    new = shown(Stack.from_dict({"layers": layers, "base": {**BASES[base], **OWN}}), tier)
    for index, element in ((0, new.lamina.layers[0]), (1, new.lamina.layers[1]), (-1, new.lamina.base)):
        bend(new, element, BENDS[index])
    lobe_set = make_lobe_set(material.stack_of(new), tier)

    def expected(normal, wi, wo):
        total = 0.0
        for place, offset in enumerate((BENDS[0], BENDS[1], BENDS[-1])):
            local_wi, local_wo = local_directions(bent(normal, offset), wi, wo)
            # a rough diffuse base has two
            own = lobe_set.lobes(np.maximum(local_wo[:, 2], 1e-4))[place : None if place == 2 else place + 1]
            visible = (local_wi[:, 2:] > 0.0) & (local_wo[:, 2:] > 0.0)
            total = total + np.where(visible, sum(lobe_f(lobe, local_wo, local_wi) for lobe in own) * local_wi[:, 2:], 0.0)
        return total

    picture = render_sun_sphere(new, 45.0, 64)
    normal = picture["normal"][picture["mask"]].astype(float)
    rendered, wanted = picture["radiance"][picture["mask"]], expected(normal, picture["wi"], picture["wo"])
    # away from the edges, where Cycles asks the geometry too
    inside = (normal @ picture["wo"] > 0.35) & (normal @ picture["wi"] > 0.05)
    errors = np.abs(rendered - wanted)[inside] / np.maximum(wanted[inside], 1e-3)
    print(f"{tier}, {base}: 99th percentile {np.percentile(errors, 99):.1e}")
    assert inside.sum() > 1000
    assert np.percentile(errors, 99) <= TOLERANCE


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
def test_an_unlinked_normal_is_the_surfaces(blender, tier):
    base = BASES["metal"]
    pictures = [
        render_sun_sphere(shown(Stack.from_dict({"layers": [{**COAT, **own}], "base": {**base, **own}}), tier), 45.0, 48)["radiance"] for own in ({}, OWN)
    ]
    assert np.array_equal(*pictures)


def test_a_covered_layer_keeps_its_normal(blender):
    """Where the coat is gone, its normal is too."""
    layers, base = [{**COAT, **OWN, "coverage": 0.0}], BASES["metal"]
    new = shown(Stack.from_dict({"layers": layers, "base": base}), "weidlich_wilkie")
    bend(new, new.lamina.layers[0], BENDS[0])
    bare = make_lobe_set(Stack.from_dict({"base": base}), "weidlich_wilkie")
    result = parity(new, lambda wo, wi: sum(lobe_f(lobe, wo, wi) for lobe in bare.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0), 45.0, 48)
    assert result.percentile_99 <= TOLERANCE


def test_stock_nodes_say_that_they_leave_normals_out(blender):
    import bpy

    new = bpy.data.materials.new("bent")
    material.apply_stack(new, Stack.from_dict({"layers": [{**COAT, **OWN}], "base": BASES["metal"]}), "weidlich_wilkie", "nodes")
    assert new.lamina.note == "stock nodes leave out the normal of layer 0"
