# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of layers in the panel, the base as its last row, and the buttons and menus beside it."""

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ...reference_py.material.schema import COLOR, CONDUCTOR
from ...reference_py.optics import microfacet
from ..material import elements
from ..material.properties import choice_label
from ..operators import layer_operators as layer_ops
from ..operators import material_operators as ops
from .panel_values import draw_choice
from .swatch_icons import icon_of

_ROWS, _MOST_ROWS = 3, 12
# Region widths, in pixels at scale 1, below which a row leaves out its numbers, and its swatch of color.
_NUMBERS_WIDTH, _COLOR_WIDTH = 330, 250


class LAMINA_UL_layers(bpy.types.UIList):
    """Layers from the top."""

    def draw_item(self, context, layout, _data, element, _icon, _active_data, _active_name, index=0):
        lamina = element.id_data.lamina
        row = layout.row()
        row.use_property_split = row.use_property_decorate = False
        name = row.row(align=True)
        name.active = lamina.shows(element)
        name.prop(element, "name", text="", emboss=False, icon_value=icon_of(element))
        draw_facts(context, name, element)
        buttons = row.row(align=True)
        soloed = lamina.solo == element.node
        buttons.operator(layer_ops.LAMINA_OT_layer_solo.bl_idname, text="", emboss=False, icon="SOLO_ON" if soloed else "SOLO_OFF").index = index
        draw_choice(buttons, element, "visible", text="", emboss=False, icon="HIDE_OFF" if element.visible else "HIDE_ON")
        buttons.operator(layer_ops.LAMINA_OT_layer_drag.bl_idname, text="", emboss=False, icon="GRIP").index = index

    def draw_filter(self, _context, _layout):
        """Nothing: the order of a stack means something, so it is neither sorted nor filtered."""


def draw_facts(context, layout, element) -> None:
    """Roughness in degrees and thickness as numbers, and the color, as far as no texture gives them."""
    node = elements.find_node(element)
    if node is None:
        return
    width = context.region.width / context.preferences.system.ui_scale
    if width > _NUMBERS_WIDTH:
        numbers = layout.row()
        numbers.alignment, numbers.active = "RIGHT", False
        numbers.label(text="  ".join(_facts(element, node)), translate=False)
    label = next((p.label for p in elements.kind_of(element).sockets if p.type == COLOR and p.name in ("tint", "color")), None)
    if width > _COLOR_WIDTH and label is not None and not node.inputs[label].is_linked:
        swatch = layout.row()
        swatch.ui_units_x = 1.4
        swatch.prop(node.inputs[label], "default_value", text="")


def _facts(element, node) -> list[str]:
    """What a row says in numbers; a value that a texture gives is the name of its socket."""
    facts = []
    for label, words in (("Roughness", _slope), ("Thickness", "\N{MULTIPLICATION SIGN}{:.3g}".format)):
        socket = node.inputs.get(label)
        if socket is not None:
            facts.append(iface_(label) if socket.is_linked else words(socket.default_value, *_distribution(element, label)))
    return facts


def _distribution(element, label: str) -> tuple[str, ...]:
    return (element.distribution,) if label == "Roughness" else ()


def _slope(roughness: float, distribution: str) -> str:
    return f"{microfacet.slope_deg_from_roughness(roughness, distribution):.1f}\N{DEGREE SIGN}"


def _row_selected(_window) -> int:
    material = ops.material_of(bpy.context)
    return material.lamina.active_layer if material is not None else 0


def _select_row(_window, index: int) -> None:
    material = ops.material_of(bpy.context)
    if material is not None:
        material.lamina.active_layer = index


class LaminaWindow(bpy.types.PropertyGroup):
    """What the list of layers needs outside of the material that the context shows, so that a click does not touch it."""

    active_layer: bpy.props.IntProperty(name="Active Layer", description="Layer shown below the list", min=0, get=_row_selected, set=_select_row, options=set())


class LAMINA_MT_add_layer(bpy.types.Menu):
    bl_label = "Add Layer"

    def draw(self, _context):
        self.layout.operator_enum(layer_ops.LAMINA_OT_layer_add.bl_idname, "kind")
        self.layout.separator()
        self.layout.operator_enum(layer_ops.LAMINA_OT_layer_add_ready.bl_idname, "ready")


class LAMINA_MT_specials(bpy.types.Menu):
    bl_label = "Lamina Specials"

    def draw(self, _context):
        layout = self.layout
        layout.operator(layer_ops.LAMINA_OT_layer_duplicate.bl_idname, icon="DUPLICATE")
        layout.operator(layer_ops.LAMINA_OT_layer_copy.bl_idname, icon="COPYDOWN")
        layout.operator(layer_ops.LAMINA_OT_layer_copy.bl_idname, text="Copy All Layers", icon="COPYDOWN").all_layers = True
        layout.operator(layer_ops.LAMINA_OT_layer_paste.bl_idname, icon="PASTEDOWN")
        layout.separator()
        layout.operator(ops.LAMINA_OT_import_stack.bl_idname, text="Import...", icon="IMPORT")
        layout.operator(ops.LAMINA_OT_export_stack.bl_idname, text="Export...", icon="EXPORT")
        layout.menu("LAMINA_MT_exchange", icon="FILE_REFRESH")
        layout.separator()
        layout.operator("lamina.check", icon="VIEWZOOM")
        layout.operator(ops.LAMINA_OT_regenerate.bl_idname, icon="FILE_REFRESH")


def draw_layers(layout, context, lamina) -> None:
    """The list with its buttons, and below it the base."""
    row = layout.row()
    left = row.column(align=True)
    rows = min(max(len(lamina.layers), _ROWS), _MOST_ROWS)
    left.template_list(
        LAMINA_UL_layers.__name__, "", lamina, "layers", context.window_manager.lamina, "active_layer", rows=rows, maxrows=_MOST_ROWS, sort_lock=True
    )
    _draw_base_row(left.box(), context, lamina.base)
    column = row.column(align=True)
    column.menu(LAMINA_MT_add_layer.__name__, text="", icon="ADD")
    column.operator(layer_ops.LAMINA_OT_layer_remove.bl_idname, text="", icon="REMOVE")
    column.separator()
    column.menu(LAMINA_MT_specials.__name__, text="", icon="DOWNARROW_HLT")
    column.separator()
    column.operator(layer_ops.LAMINA_OT_layer_move.bl_idname, text="", icon="TRIA_UP").direction = "UP"
    column.operator(layer_ops.LAMINA_OT_layer_move.bl_idname, text="", icon="TRIA_DOWN").direction = "DOWN"


def _draw_base_row(box, context, base) -> None:
    row = box.row(align=True)
    row.use_property_split = row.use_property_decorate = False
    row.label(text=_base_name(base), icon_value=icon_of(base), translate=False)
    draw_facts(context, row, base)


def _base_name(base) -> str:
    """What the base is, in a row: a named metal's name, else its kind's."""
    named = base.kind == CONDUCTOR.name and base.given == "metal"
    return f"{iface_('Base')}: {iface_(choice_label(base.metal) if named else elements.kind_of(base).label)}"


CLASSES = (LaminaWindow, LAMINA_UL_layers, LAMINA_MT_add_layer, LAMINA_MT_specials)
