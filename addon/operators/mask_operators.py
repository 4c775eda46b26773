# SPDX-License-Identifier: GPL-3.0-or-later
"""What the menus of masks do. Each operator is one undo step."""

import bpy
from bpy.props import EnumProperty

from ...reference_py.material.masks import GENERATORS
from ..blender.translation import rpt_, tip_
from ..exchange import mask_bake
from ..material import layers
from . import material_operators as ops
from .layer_operators import SelectedLayerOperator
from .texture_operator import SIZES

_VALUES = (("coverage", "Coverage", "Where the layer is"), ("roughness", "Roughness", "Where the layer is rough"))


class LAMINA_OT_add_mask(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.add_mask"
    bl_label = "Add Mask"
    bl_description = "Let a generated pattern say where the selected layer has a value"

    generator: EnumProperty(name="Generator", items=[(g.name, g.label, g.help) for g in GENERATORS.values()])
    value: EnumProperty(name="Value", items=_VALUES)

    @classmethod
    def description(cls, _context, properties):
        return tip_(GENERATORS[properties.generator].help)

    def run(self, context):
        material = ops.material_of(context)
        layers.add_mask(material, material.lamina.active_layer, self.value, self.generator)


class LAMINA_OT_bake_masks(ops.LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.bake_masks"
    bl_label = "Bake Masks"
    bl_description = "Keep the material's masks as pictures or attributes, for EEVEE and OptiX, which know no bevel"

    into: EnumProperty(
        name="Into",
        items=[
            ("IMAGE", "Image", "Pictures over the active object's UV map, packed into the file"),
            ("ATTRIBUTE", "Attribute", "Attributes of the vertices of all meshes that have the material"),
        ],
    )
    size: EnumProperty(name="Size", description="Width and height of each picture", items=[(str(n), f"{n} px", "") for n in SIZES], default="1024")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context):
        material = ops.material_of(context)
        sharing = mask_bake.sharing(material, context.scene)
        items = sharing or [context.object] if self.into == "ATTRIBUTE" else [context.object]
        count = mask_bake.bake_masks(material, items, self.into, int(self.size))
        others = [item.name for item in sharing if item not in items]
        if others:
            sentence = rpt_("Lamina: the masks are those of {object} alone; {others} have the material too")
            self.report({"WARNING"}, sentence.format(object=items[0].name, others=", ".join(others[:3])))
        self.report({"INFO"}, rpt_("Lamina: masks kept: {count}").format(count=count))


class LAMINA_OT_live_masks(ops.LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.live_masks"
    bl_label = "Draw Masks Live"
    bl_description = "Let the material's masks draw live again in place of what Bake Masks kept"

    def run(self, context):
        count = mask_bake.draw_live(ops.material_of(context))
        self.report({"INFO"}, rpt_("Lamina: masks that draw live again: {count}").format(count=count))


class LAMINA_MT_add_mask(bpy.types.Menu):
    bl_label = "Add Mask"

    def draw(self, _context):
        for generator in GENERATORS.values():
            button = self.layout.operator(LAMINA_OT_add_mask.bl_idname, text=generator.label)
            button.generator, button.value = generator.name, generator.value


CLASSES = (LAMINA_OT_add_mask, LAMINA_OT_bake_masks, LAMINA_OT_live_masks, LAMINA_MT_add_mask)
