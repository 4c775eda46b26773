# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks that are made by hand, from the panel: an image to paint on, turned about, and its contrast."""

import bpy
from bpy.props import EnumProperty

from ...reference_py.errors import LaminaError
from ..material import mask_links
from .layer_operators import SelectedLayerOperator
from .mask_operators import LAMINA_MT_add_mask
from .material_operators import material_of

_SIZES = (512, 1024, 2048, 4096)


def _selected(context):
    material = material_of(context)
    return material, material.lamina.active_layer


class LAMINA_OT_mask_image(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.mask_image"
    bl_label = "New Painted Mask"
    bl_description = "Give the selected layer a white image as a mask, to paint black where the layer is not; it joins the masks that are there"

    size: EnumProperty(name="Size", description="Width and height of the image", items=[(str(n), f"{n} px", "") for n in _SIZES], default="1024")

    def run(self, context):
        mask_links.new_image_mask(*_selected(context), int(self.size))


class LAMINA_OT_mask_paint(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.mask_paint"
    bl_label = "Paint Mask"
    bl_description = "Switch to Texture Paint on the image of the selected layer's mask"

    def run(self, context):
        material, index = _selected(context)
        layer, item = material.lamina.layers[index], context.object
        image = mask_links.image_of(layer)
        if image is None:
            raise LaminaError("{layer} has no image as a mask; add a New Painted Mask first", layer=layer.name)
        if item is None or item.type != "MESH" or not item.data.uv_layers:
            raise LaminaError("painting needs a mesh with a UV map; unwrap the active object first")
        bpy.ops.object.mode_set(mode="TEXTURE_PAINT")
        paint = context.scene.tool_settings.image_paint
        paint.mode, paint.canvas = "IMAGE", image


class LAMINA_OT_mask_invert(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.mask_invert"
    bl_label = "Invert Mask"
    bl_description = "Put the selected layer where its mask says that it is not; press it again to put it back"

    def run(self, context):
        mask_links.invert_mask(*_selected(context))


class LAMINA_OT_mask_ramp(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.mask_ramp"
    bl_label = "Mask Ramp"
    bl_description = "Put a ramp after the selected layer's mask, to make it harder, softer, more or less"

    def run(self, context):
        mask_links.ramp_mask(*_selected(context))


class LAMINA_MT_mask(bpy.types.Menu):
    bl_label = "Mask"

    def draw(self, _context):
        layout = self.layout
        layout.menu(LAMINA_MT_add_mask.__name__, icon="MOD_MASK")
        layout.operator(LAMINA_OT_mask_image.bl_idname, icon="IMAGE_DATA")
        layout.operator(LAMINA_OT_mask_paint.bl_idname, icon="BRUSH_DATA")
        layout.operator(LAMINA_OT_mask_invert.bl_idname, icon="ARROW_LEFTRIGHT")
        layout.operator(LAMINA_OT_mask_ramp.bl_idname, icon="COLOR")


CLASSES = (LAMINA_OT_mask_image, LAMINA_OT_mask_paint, LAMINA_OT_mask_invert, LAMINA_OT_mask_ramp, LAMINA_MT_mask)
