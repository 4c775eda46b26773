# SPDX-License-Identifier: GPL-3.0-or-later
"""A preset goes on what can show a surface; where nothing would come of it, Blender says why and nothing changes."""

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.material.holders import can_hold_material
from lamina.addon.operators import material_operators as ops

pytestmark = pytest.mark.blender

WITH_SURFACE = {
    "mesh": lambda: bpy.ops.mesh.primitive_plane_add(), "curve": lambda: bpy.ops.curve.primitive_bezier_circle_add(),
    "surface": lambda: bpy.ops.surface.primitive_nurbs_surface_circle_add(), "text": lambda: bpy.ops.object.text_add(),
    "metaball": lambda: bpy.ops.object.metaball_add(), "hair": lambda: show("hair", bpy.data.hair_curves.new("hair")),
    "points": lambda: show("points", bpy.data.pointclouds.new("points")),
}  # fmt: skip
WITHOUT = {
    "volume": lambda: show("volume", bpy.data.volumes.new("volume")), "grease pencil": lambda: bpy.ops.object.grease_pencil_add(type="STROKE"),
    "light": lambda: bpy.ops.object.light_add(), "empty": lambda: bpy.ops.object.empty_add(),
}  # fmt: skip
CALLS = {"preset": lambda: bpy.ops.lamina.apply_preset(preset="clean_copper"), "convert": lambda: bpy.ops.lamina.convert_principled()}


def show(name, data):
    item = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item


def state():
    return [(m.name, m.lamina.is_layered, len(m.node_tree.nodes) if m.node_tree else 0) for m in bpy.data.materials], bpy.context.scene.render.engine


@pytest.mark.parametrize("make", WITH_SURFACE.values(), ids=WITH_SURFACE)
def test_every_object_with_a_surface_takes_a_preset(blender, make):
    make()
    assert can_hold_material(bpy.context.object) and CALLS["preset"]() == {"FINISHED"}
    assert bpy.context.object.active_material.lamina.is_layered


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
@pytest.mark.parametrize("filled", [False, True])
@pytest.mark.parametrize("make", WITHOUT.values(), ids=WITHOUT)
def test_what_shows_no_surface_is_refused_with_a_reason(blender, make, filled, call):
    make()
    item = bpy.context.object
    if filled and hasattr(item.data, "materials") and not item.data.materials:
        item.data.materials.append(bpy.data.materials.new("plain"))
    before = state()
    with pytest.raises(RuntimeError) as error:
        call()
    assert any(word in str(error.value) for word in ("shows no surface", "Grease Pencil", "Select a")), error.value
    assert state() == before


def test_the_reason_names_what_is_in_the_way(blender):
    WITHOUT["volume"]()
    assert ops.why_no_material(bpy.context).startswith("volume shows no surface: choose a mesh")
    WITHOUT["grease pencil"]()
    strokes = bpy.context.object.active_material or bpy.data.materials.new("strokes")
    if not strokes.is_grease_pencil:
        bpy.data.materials.create_gpencil_data(strokes)
    WITH_SURFACE["mesh"]()
    bpy.context.object.data.materials.append(strokes)
    assert ops.why_no_material(bpy.context) == f"{strokes.name} is a Grease Pencil material: it shows strokes and no surface"
    assert not bpy.ops.lamina.apply_preset.poll() and not bpy.ops.lamina.import_stack.poll()
    bpy.context.object.data.materials[0] = bpy.data.materials.new("plain")
    assert ops.why_no_material(bpy.context) == "" and bpy.ops.lamina.apply_preset.poll()
