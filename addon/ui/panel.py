# SPDX-License-Identifier: GPL-3.0-or-later
"""The Lamina panel in the Material tab: layers, their values, the base, and how they are rendered.

The list is the first thing in it, and nothing above it comes or goes: whoever clicks a row hits it.
"""

from functools import cache

import bpy

from .. import later
from ..blender.translation import CONTEXT
from ..material import elements
from ..material.holders import can_hold_material
from ..operators import material_operators as ops
from ..operators.fit_operators import LAMINA_OT_fit_measurement
from ..operators.preset_operators import draw_presets
from . import panel_feedback, panel_layers
from .panel_feedback import draw_shader, draw_status, draw_unlayered_status, shown_quality
from .panel_layers import draw_layers, draw_row_buttons
from .panel_values import draw_element

# Seconds after the panel is first drawn, all of which is shown by then.
_SEEN = 0.3


class LAMINA_MT_presets(bpy.types.Menu):
    bl_label = "Presets"

    def draw(self, _context):
        draw_presets(self.layout)
        self.layout.operator(ops.LAMINA_OT_import_stack.bl_idname, text="Import...", icon="IMPORT")
        self.layout.operator(LAMINA_OT_fit_measurement.bl_idname, text="Fit Measurement...", icon="RNDCURVE")


@cache
def _read_the_rest() -> None:
    """The first time that the panel is seen: what a click needs is read before it comes."""
    if not bpy.app.background:
        bpy.app.timers.register(later.read_soon(), first_interval=_SEEN)


class LAMINA_PT_material(bpy.types.Panel):
    bl_label = "Lamina"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    # Panels without a header come first. Below Preview and Surface, which for a Lamina material is a long list of
    # the shader's links, nobody would find the layers. So the header is a sub-panel's.
    bl_options = {"HIDE_HEADER"}

    @classmethod
    def poll(cls, context):
        material = ops.material_of(context)
        if material is not None:
            return not material.is_grease_pencil
        return can_hold_material(getattr(context, "object", None))

    def draw(self, context):
        _read_the_rest()
        header, layout = self.layout.panel("lamina")
        header.label(text=self.bl_label, text_ctxt=CONTEXT)
        header.menu(LAMINA_MT_presets.__name__, text="Presets", text_ctxt=CONTEXT, icon="PRESET")
        if layout is None:
            return
        layout.use_property_split = True
        material = ops.material_of(context)
        if material is None or not material.lamina.is_layered:
            layout.menu(LAMINA_MT_presets.__name__, text="Pick a Preset", text_ctxt=CONTEXT, icon="PRESET")
            layout.operator(ops.LAMINA_OT_new_material.bl_idname, icon="ADD")
            layout.operator("lamina.convert_principled", icon="NODE_MATERIAL")
            draw_unlayered_status(layout, context, material)
            return
        lamina = material.lamina
        draw_layers(layout, context, lamina)
        draw_status(layout, context, material)
        if 0 <= lamina.active_layer < len(lamina.layers):
            layer = lamina.layers[lamina.active_layer]
            header, body = layout.panel("lamina_layer")
            header.label(text=layer.name, translate=False)
            draw_row_buttons(header, lamina, layer, lamina.active_layer)
            if body:
                body.active = lamina.shows(layer)
                draw_element(body, layer)
        header, body = layout.panel("lamina_base")
        header.label(text="Base", text_ctxt=CONTEXT)
        header.operator_menu_enum(ops.LAMINA_OT_set_base.bl_idname, "kind", text=elements.kind_of(lamina.base).label, text_ctxt=CONTEXT)
        if body:
            draw_element(body, lamina.base)
        header, body = layout.panel("lamina_shader", default_closed=True)
        header.label(text="Shader", text_ctxt=CONTEXT)
        header.label(text=shown_quality(material), translate=False)
        if body:
            draw_shader(body, material)


CLASSES = (*panel_layers.CLASSES, *panel_feedback.CLASSES, LAMINA_MT_presets, LAMINA_PT_material)
