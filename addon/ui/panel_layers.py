# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of layers in the panel, the base as its last row, and the buttons and menus beside it."""

from functools import cache

import bpy

from ...reference_py.material import ready_layers
from ...reference_py.material.schema import COLOR, CONDUCTOR, SCHEMA
from ...reference_py.optics import microfacet
from ..blender.translation import CONTEXT, iface_
from ..material import elements
from ..material.properties import choice_label
from ..operators import layer_operators as layer_ops
from ..operators import mask_operators as mask_ops
from ..operators import material_operators as ops
from .panel_values import draw_choice
from .swatch_icons import icon_of, icon_of_layer

_ROWS, _MOST_ROWS = 4, 12
_BUTTON = 20  # pixels at scale 1
# What a row has beside its icon and name, from the left, in the width of buttons. What does not fit is dropped from the right.
_COLUMNS = {"eye": 1.0, "swatch": 1.3, "Roughness": 1.8, "Thickness": 2.1, "solo": 1.0, "grip": 1.0}
_NAME = 3.5  # at least
_AROUND = 2.7  # the panel's borders, the list's and the column of buttons


class LAMINA_UL_layers(bpy.types.UIList):
    """Layers from the top."""

    def draw_item(self, context, layout, _data, element, _icon, _active_data, _active_name, index=0):
        lamina = element.id_data.lamina
        carried, to = layer_ops.carried_in(element.id_data) or (index, index)
        row = layout.row(align=True)
        row.use_property_split = row.use_property_decorate = False
        row.active = lamina.shows(element) and not index == carried != to
        icon = {"icon_value": icon_of(element)}
        if index == to != carried:  # where it would be dropped: the bar above or below this row, in the icon's place, so that nothing moves
            icon = {"icon": "TRIA_UP_BAR" if to < carried else "TRIA_DOWN_BAR"}
        row.prop(element, "name", text="", emboss=False, **icon)
        shown = _columns(context)
        if "eye" in shown:
            draw_choice(row, element, "visible", text="", emboss=False, icon="HIDE_OFF" if element.visible else "HIDE_ON")
        _draw_facts(row, element, shown)
        if "solo" in shown:
            draw_row_buttons(row, lamina, element, index, "grip" in shown)

    def draw_filter(self, _context, _layout):
        """Nothing: the order of a stack means something, so it is neither sorted nor filtered."""


def columns_at(width: float) -> list[str]:
    """The columns that fit beside a row's icon and name in a region of this width, in pixels at scale 1."""
    left, shown = width / _BUTTON - _AROUND - 1.0 - _NAME, []
    for name, column in _COLUMNS.items():
        left -= column
        if left < 0.0:
            break
        shown.append(name)
    return shown


def _columns(context) -> list[str]:
    return columns_at(context.region.width / context.preferences.system.ui_scale)


def draw_row_buttons(layout, lamina, element, index: int, has_grip: bool = True) -> None:
    """What is done with one layer: shown alone, and carried. Where rows are too narrow for them they are in the layer's header."""
    soloed = lamina.solo == element.node
    layout.operator(layer_ops.LAMINA_OT_layer_solo.bl_idname, text="", emboss=False, icon="SOLO_ON" if soloed else "SOLO_OFF").index = index
    if has_grip:
        layout.operator(layer_ops.LAMINA_OT_layer_drag.bl_idname, text="", emboss=False, icon="GRIP").index = index


def _draw_facts(layout, element, shown: list[str]) -> None:
    """The color, the roughness in degrees and the thickness, as far as they fit; each has its place also where an element has none."""
    node = elements.find_node(element)
    label = next((p.label for p in elements.kind_of(element).sockets if p.type == COLOR and p.name in ("tint", "color")), None)
    if "swatch" in shown:
        swatch = _place(layout, "swatch")
        if node is not None and label is not None and not node.inputs[label].is_linked:
            swatch.prop(node.inputs[label], "default_value", text="")
        else:
            swatch.label(text="")
    for name, words in (("Roughness", _slope), ("Thickness", "\N{MULTIPLICATION SIGN}{:.3g}".format)):
        if name not in shown:
            return
        number = _place(layout, name)
        number.alignment, number.active = "RIGHT", False
        socket = node.inputs.get(name) if node is not None else None
        if socket is None:
            number.label(text="")
        else:
            number.label(text=iface_("tex.") if socket.is_linked else words(socket.default_value, *_distribution(element, name)), translate=False)


def _place(layout, column: str):
    row = layout.row()
    row.ui_units_x = _COLUMNS[column]
    return row


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
        row = self.layout.row()
        column = _group(row, text="Plain")
        for kind in SCHEMA.layers.values():
            icon = icon_of_layer(ready_layers.layers_of({"layers": [{"kind": kind.name}]}, kind.name)[0])
            column.operator(layer_ops.LAMINA_OT_layer_add.bl_idname, text=kind.label, icon_value=icon).kind = kind.name
        for group, names in _ready_groups().items():
            column = _group(row, text=group.title())
            for name, (label, layer) in names.items():
                column.operator(layer_ops.LAMINA_OT_layer_add_ready.bl_idname, text=label, icon_value=icon_of_layer(layer)).ready = name


def _group(row, text: str):
    column = row.column()
    column.label(text=text, text_ctxt=CONTEXT)
    column.separator()
    return column


@cache
def _ready_groups() -> dict[str, dict[str, tuple]]:
    """By group and name: a ready layer's label, and the lowest of its layers, which gives it its color; read when a menu first shows them."""
    groups: dict[str, dict[str, tuple]] = {group: {} for group in ready_layers.GROUPS}
    for name in ready_layers.names():
        label, _source, layers = ready_layers.load(name)
        groups[ready_layers.group_of(name)][name] = (label, layers[-1])
    return groups


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
        layout.menu(mask_ops.LAMINA_MT_add_mask.__name__, icon="MOD_MASK")
        layout.operator(mask_ops.LAMINA_OT_bake_masks.bl_idname, icon="RENDER_STILL")
        layout.operator(mask_ops.LAMINA_OT_live_masks.bl_idname, icon="FILE_REFRESH")
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
    _draw_facts(row, base, _columns(context))


def _base_name(base) -> str:
    """What the base is, in a row: a named metal's name, else its kind's."""
    named = base.kind == CONDUCTOR.name and base.given == "metal"
    return f"{iface_('Base')}: {iface_(choice_label(base.metal) if named else elements.kind_of(base).label)}"


CLASSES = (LaminaWindow, LAMINA_UL_layers, LAMINA_MT_add_layer, LAMINA_MT_specials)
