# SPDX-License-Identifier: GPL-3.0-or-later
"""A normal of its own per layer: each closure renders as its closure model says in the frame of its layer's normal."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from support.goniometer import TOLERANCE, local_directions, parity

from lamina.addon.check import check
from lamina.addon.material import elements, material
from lamina.addon.rendering.measure import render_sun_sphere
from lamina.addon.shader.nodes.stock_nodes import stock_tables
from lamina.reference_py.lobes.closure import lobe_energy, lobe_f
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.place import Place
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


def shown(stack, tier, backend="auto"):
    new = bpy.data.materials.new("bent")
    new.cycles.use_bump_map_correction = False  # which darkens diffuse closures whose normal is not the surface's
    material.apply_stack(new, stack, tier, backend)
    material.refresh(new, settle=True)
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


LAYERS = [{**COAT, **OWN}, {**COAT, "ior": 1.8, **OWN}]


def all_bent(base, tier, backend):
    """Two layers and the base, each with another normal."""
    new = shown(Stack.from_dict({"layers": LAYERS, "base": {**BASES[base], **OWN}}), tier, backend)
    for index, element in ((0, new.lamina.layers[0]), (1, new.lamina.layers[1]), (-1, new.lamina.base)):
        bend(new, element, BENDS[index])
    return new


def assert_each_lobe_in_its_frame(new, lobe_set, label, offset_of=lambda lobe: BENDS[-1 if lobe.normal.layer is None else lobe.normal.layer]):
    """Each lobe is that of its weight and shape at the view from its own normal."""

    def expected(normal, wi, wo):
        total = 0.0
        for i in range(lobe_set.lobe_count):
            local_wi, local_wo = local_directions(bent(normal, offset_of(lobe_set.lobes(np.ones(1))[i])), wi, wo)
            lobe = lobe_set.lobes(np.maximum(local_wo[:, 2], 1e-4))[i]
            visible = (local_wi[:, 2:] > 0.0) & (local_wo[:, 2:] > 0.0)
            total = total + np.where(visible, lobe_f(lobe, local_wo, local_wi) * local_wi[:, 2:], 0.0)
        return total

    picture = render_sun_sphere(new, 45.0, 64)
    normal = picture["normal"][picture["mask"]].astype(float)
    rendered, wanted = picture["radiance"][picture["mask"]], expected(normal, picture["wi"], picture["wo"])
    # away from the edges, where Cycles asks the geometry too
    inside = (normal @ picture["wo"] > 0.35) & (normal @ picture["wi"] > 0.05)
    errors = np.abs(rendered - wanted)[inside] / np.maximum(wanted[inside], 1e-3)
    print(f"{label}: 99th percentile {np.percentile(errors, 99):.1e}")
    assert inside.sum() > 1000
    assert np.percentile(errors, 99) <= TOLERANCE


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("base", BASES)
def test_each_lobe_renders_in_its_frame(blender, tier, base):
    new = all_bent(base, tier, "osl")
    assert_each_lobe_in_its_frame(new, make_lobe_set(material.stack_of(new), tier).lobe_set, f"{tier}, {base}")


@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("base", BASES)
def test_stock_nodes_do_so_too(blender, tier, base):
    new = all_bent(base, tier, "nodes")
    assert_each_lobe_in_its_frame(new, stock_tables(make_lobe_set(material.stack_of(new), tier)), f"{tier}, {base}, stock nodes")
    assert not [f.code for f in check.find(new, bpy.context.scene, bpy.context.preferences) if f.code != "without_osl"]


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_a_bake_over_live_values_keeps_its_normals(blender, backend):
    """A tinted coat over paint, all about one bent normal, whose tint comes from a node."""
    new = shown(Stack.from_dict({"layers": LAYERS[:1], "base": {**BASES["lambert"], **OWN}}), "baked", backend)
    layer = new.lamina.layers[0]
    tint = new.node_tree.nodes.new("ShaderNodeRGB")
    tint.outputs[0].default_value = (0.8, 0.5, 0.3, 1.0)
    new.node_tree.links.new(tint.outputs[0], elements.node_of(layer).inputs["Tint"])
    for element in (layer, new.lamina.base):
        bend(new, element, BENDS[0])
    material.refresh(new, settle=True)
    stack = material.stack_of(new)
    live = Place(0, "tint").with_value(stack, [0.8, 0.5, 0.3])
    made = make_lobe_set(live, "baked", live=(Place(0, "tint"),))
    lobe_set = made.lobe_set if backend == "osl" else stock_tables(made)
    assert_each_lobe_in_its_frame(new, lobe_set, f"live, {backend}", lambda lobe: BENDS[0])


def test_a_normal_leaves_the_bake_in_force():
    """Its energy is that of the bake without, and what the top reflects has a lobe of its own, which follows the top's normal."""
    stack = Stack.from_dict({"layers": LAYERS[:1], "base": {**BASES["metal"], **OWN}})
    plain = Stack.from_dict({"layers": [COAT], "base": BASES["metal"]})
    cosines = np.array([0.2, 0.6, 1.0])
    for method in ("baked", "auto"):
        own, bare = (make_lobe_set(one, method).lobe_set for one in (stack, plain))
        assert own.name == bare.name == "baked"
        energies = [sum(lobe_energy(lobe, cosines) for lobe in lobe_set.lobes(cosines)) for lobe_set in (own, bare)]
        assert energies[0] == pytest.approx(energies[1], rel=2e-3)
        assert [lobe.normal.layer for lobe in own.lobes(cosines)][:2] == [0, None]


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
def test_an_unlinked_normal_is_the_surfaces(blender, tier, backend):
    new = shown(Stack.from_dict({"layers": LAYERS[:1], "base": {**BASES["metal"], **OWN}}), tier, backend)
    unlinked = render_sun_sphere(new, 45.0, 48)["radiance"]
    for element in (*new.lamina.layers, new.lamina.base):
        bend(new, element, (0.0, 0.0, 0.0))
    assert render_sun_sphere(new, 45.0, 48)["radiance"] == pytest.approx(unlinked, rel=1e-4, abs=1e-6)


def test_a_covered_layer_keeps_its_normal(blender):
    """Where the coat is gone, its normal is too."""
    layers, base = [{**COAT, **OWN, "coverage": 0.0}], BASES["metal"]
    new = shown(Stack.from_dict({"layers": layers, "base": base}), "weidlich_wilkie")
    bend(new, new.lamina.layers[0], BENDS[0])
    bare = make_lobe_set(Stack.from_dict({"base": base}), "weidlich_wilkie")
    result = parity(new, lambda wo, wi: sum(lobe_f(lobe, wo, wi) for lobe in bare.lobes(wo[..., 2])) * (wi[..., 2:] > 0.0), 45.0, 48)
    assert result.percentile_99 <= TOLERANCE
