# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks made from the panel: an image, painted, inverted, with a ramp, several of one layer; nothing that fed the coverage is lost."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from support.stacks import on_a_plane

from lamina.addon.material import mask_links
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.reading import measured_stack
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "name": "Coat"}], "base": {"kind": "lambert"}})


@pytest.fixture
def material(blender):
    return on_a_plane(blender, STACK)


def coverage(material) -> float:
    """The mean that the mask gives, by Blender's own drawing of the nodes."""
    return measured_stack(material).layers[0]["coverage"]


def paint(image, left: float) -> None:
    """Gray `left` on the left half, white on the right."""
    pixels = np.ones((image.size[1], image.size[0], 4), np.float32)
    pixels[:, : image.size[0] // 2, :3] = left
    image.pixels.foreach_set(pixels.ravel())
    image.update()


def test_an_image_is_white_at_first_and_is_the_mask(material):
    assert bpy.ops.lamina.mask_image("EXEC_DEFAULT", True, size="512") == {"FINISHED"}
    image = mask_links.image_of(material.lamina.layers[0])
    assert tuple(image.size) == (512, 512) and image.colorspace_settings.name == "Non-Color" and image.packed_file is not None
    assert coverage(material) == pytest.approx(1.0)
    paint(image, 0.0)
    assert coverage(material) == pytest.approx(0.5, abs=0.01)


def test_inverted_twice_is_as_before(material):
    with pytest.raises(RuntimeError, match="Coat has no mask; add one first"):
        bpy.ops.lamina.mask_invert()
    bpy.ops.lamina.mask_image(size="512")
    image = mask_links.image_of(material.lamina.layers[0])
    paint(image, 0.4)
    before = coverage(material)
    assert before == pytest.approx(0.7, abs=0.01)
    count = len(material.node_tree.nodes)
    bpy.ops.lamina.mask_invert()
    assert coverage(material) == pytest.approx(0.3, abs=0.01) and mask_links.image_of(material.lamina.layers[0]) == image
    bpy.ops.lamina.mask_invert()
    assert coverage(material) == pytest.approx(before, abs=1e-4) and len(material.node_tree.nodes) == count


def test_a_second_mask_joins_what_feeds_the_coverage(material):
    layer = material.lamina.layers[0]
    layer.use_coverage = True
    value = material.node_tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 0.5
    material.node_tree.links.new(value.outputs[0], node_of(layer).inputs["Coverage"])
    bpy.ops.lamina.mask_image(size="512")
    paint(mask_links.image_of(material.lamina.layers[0]), 0.0)
    assert coverage(material) == pytest.approx(0.25, abs=0.01)
    assert value.outputs[0].is_linked


def test_a_ramp_is_one_and_changes_the_mask(material):
    bpy.ops.lamina.mask_image(size="512")
    paint(mask_links.image_of(material.lamina.layers[0]), 0.2)
    bpy.ops.lamina.mask_ramp()
    ramp = mask_links.ramp_of(material.lamina.layers[0])
    bpy.ops.lamina.mask_ramp()
    assert mask_links.ramp_of(material.lamina.layers[0]) == ramp
    ramp.color_ramp.elements[0].position = 0.5
    assert coverage(material) == pytest.approx(0.5, abs=0.02)


def test_painting_goes_to_the_mask(material):
    with pytest.raises(RuntimeError, match="Coat has no image as a mask"):
        bpy.ops.lamina.mask_paint()
    bpy.ops.lamina.mask_image(size="512")
    bpy.ops.lamina.mask_invert()
    assert bpy.ops.lamina.mask_paint() == {"FINISHED"}
    paint_settings = bpy.context.scene.tool_settings.image_paint
    assert bpy.context.object.mode == "TEXTURE_PAINT" and paint_settings.mode == "IMAGE"
    assert paint_settings.canvas == mask_links.image_of(material.lamina.layers[0])
    bpy.ops.object.mode_set(mode="OBJECT")
    while bpy.context.object.data.uv_layers:
        bpy.context.object.data.uv_layers.remove(bpy.context.object.data.uv_layers[0])
    with pytest.raises(RuntimeError, match="painting needs a mesh with a UV map"):
        bpy.ops.lamina.mask_paint()


def test_a_mask_that_fails_leaves_nothing(material, monkeypatch):
    before = {node.name for node in material.node_tree.nodes}
    images = len(bpy.data.images)
    monkeypatch.setattr(materials, "refresh", lambda *_: (_ for _ in ()).throw(LaminaError("no")))
    with pytest.raises(LaminaError, match="no"):
        mask_links.new_image_mask(material, 0, 64)
    assert {node.name for node in material.node_tree.nodes} == before and len(bpy.data.images) == images
    assert not material.lamina.layers[0].use_coverage
