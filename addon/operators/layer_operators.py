# SPDX-License-Identifier: GPL-3.0-or-later
"""What the buttons beside the list of layers do. Each operator is one undo step."""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty

from ...reference_py.errors import LaminaError
from ...reference_py.material import ready_layers
from ...reference_py.material.schema import SCHEMA
from ..blender.translation import iface_, rpt_, tip_
from ..material import layers
from .material_operators import LayeredOperator, material_of

_ROW_HEIGHT = 20  # pixels of a list's row at scale 1

# Of the material that has it: the layer that is carried, and where it would be dropped.
_carried: dict[str, tuple[int, int]] = {}

# Without a window there is no clipboard, so the text is kept here too.
_copied = ""


class LAMINA_OT_layer_add(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_add"
    bl_label = "Add Layer"
    bl_description = "Add a layer above the selected one"

    kind: EnumProperty(name="Kind", items=[(k.name, k.label, k.help) for k in SCHEMA.layers.values()])

    def run(self, context):
        material = material_of(context)
        layers.add_layer(material, self.kind, _place(material))


class LAMINA_OT_layer_add_ready(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_add_ready"
    bl_label = "Add Ready Layer"
    bl_description = "Add a layer with the values of a known coating above the selected one"

    ready: EnumProperty(name="Layer", items=[(name, *ready_layers.label_and_source(name)) for name in ready_layers.names()])

    @classmethod
    def description(cls, _context, properties):
        return tip_(ready_layers.label_and_source(properties.ready)[1])

    def run(self, context):
        material = material_of(context)
        layers.add_layers(material, ready_layers.load(self.ready)[2], _place(material))


class SelectedLayerOperator(LayeredOperator):
    """An operator on the selected layer."""

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        lamina = material_of(context).lamina
        if not 0 <= lamina.active_layer < len(lamina.layers):
            cls.poll_message_set(tip_("No layer is selected"))
            return False
        return True


class LAMINA_OT_layer_duplicate(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_duplicate"
    bl_label = "Duplicate Layer"
    bl_description = "Copy the selected layer with its textures, drivers and keyframes"

    def run(self, context):
        material = material_of(context)
        layers.duplicate_layer(material, material.lamina.active_layer)


class LAMINA_OT_layer_remove(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_remove"
    bl_label = "Remove Layer"
    bl_description = "Remove the selected layer, its node and what animates it"

    def run(self, context):
        material = material_of(context)
        layers.remove_layer(material, material.lamina.active_layer)


class LAMINA_OT_layer_move(SelectedLayerOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_move"
    bl_label = "Move Layer"
    bl_description = "Move the selected layer up or down, also by Ctrl + Up and Down over the panel; textures and animation move with it"

    @classmethod
    def poll(cls, context):
        space = context.space_data
        if space is not None and space.type == "PROPERTIES" and space.context != "MATERIAL":
            return False  # its keys are those of every tab
        return super().poll(context)

    direction: EnumProperty(name="Direction", items=[("UP", "Up", "Toward the viewer"), ("DOWN", "Down", "Toward the base")])

    def run(self, context):
        material = material_of(context)
        index = material.lamina.active_layer
        to = index + (-1 if self.direction == "UP" else 1)
        if not 0 <= to < len(material.lamina.layers):
            if self.direction == "UP":
                raise LaminaError("{layer} is the top layer already", layer=material.lamina.layers[index].name)
            raise LaminaError("{layer} is the lowest layer already", layer=material.lamina.layers[index].name)
        layers.move_layer(material, index, to)


def carried_in(material: bpy.types.Material) -> tuple[int, int] | None:
    """Place of the layer of a material that is carried, and the one that it gets if it is dropped now."""
    return _carried.get(material.name_full)


class RowOperator(LayeredOperator):
    """An operator on the layer of a row of the list."""

    index: IntProperty(name="Layer", description="Place of the layer, 0 is the top", min=0)

    def require_row(self, material) -> None:
        """Raise LaminaError for a place where no layer is."""
        if self.index >= len(material.lamina.layers):
            raise LaminaError("there is no layer {index}; the material has {count}", index=self.index, count=len(material.lamina.layers))


class LAMINA_OT_layer_solo(RowOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_solo"
    bl_label = "Solo Layer"
    bl_description = "Show this layer alone over the base; press it again to show all visible layers"

    def run(self, context):
        material = material_of(context)
        self.require_row(material)
        layers.solo_layer(material, self.index)


class LAMINA_OT_layer_drag(RowOperator, bpy.types.Operator):
    """Blender's lists cannot be dragged by an add-on, so a layer is carried: a click takes it, the next one drops it.

    Until then the list has a bar at the row above or below which it would be dropped, and the material stays as it is.
    """

    bl_idname = "lamina.layer_drag"
    bl_label = "Carry Layer"
    bl_description = "Take this layer along with the mouse; click to drop it, Escape puts it back"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    def run(self, _context):
        raise LaminaError("a layer is carried with the mouse; use Move Layer instead")

    def invoke(self, context, event):
        material = material_of(context)
        try:
            self.require_row(material)
        except LaminaError as error:
            self.report({"ERROR"}, error.told(rpt_))
            return {"CANCELLED"}
        self._start_y, self._material = event.mouse_y, material.name_full
        _carried[self._material] = self.index, self.index
        name = material.lamina.layers[self.index].name
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("SCROLL_Y")
        context.workspace.status_text_set(iface_("Lamina carries {layer}: a click drops it, Escape puts it back").format(layer=name))
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        _carried.pop(self._material, None)
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)

    def modal(self, context, event):
        material = bpy.data.materials[self._material]
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.cancel(context)
            _redraw(context)
            return {"CANCELLED"}
        if event.type in {"LEFTMOUSE", "RET"} and event.value == "PRESS":
            to = _carried[self._material][1]
            self.cancel(context)
            return self._drop(material, to)
        if event.type == "MOUSEMOVE":
            rows = round((self._start_y - event.mouse_y) / (_ROW_HEIGHT * context.preferences.system.ui_scale))
            _carried[self._material] = self.index, max(0, min(self.index + rows, len(material.lamina.layers) - 1))
            _redraw(context)
        return {"RUNNING_MODAL"}

    def _drop(self, material, to: int) -> set[str]:
        if to == self.index:
            return {"CANCELLED"}
        try:
            layers.move_layer(material, self.index, to)
        except LaminaError as error:
            self.report({"ERROR"}, error.told(rpt_))
            return {"CANCELLED"}
        return {"FINISHED"}


def _redraw(context) -> None:
    if context.area is not None:
        context.area.tag_redraw()


class LAMINA_OT_layer_copy(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_copy"
    bl_label = "Copy Layer"
    bl_description = "Put the selected layer on the clipboard, to paste it into this or another material"
    bl_options = {"REGISTER"}

    all_layers: BoolProperty(name="All Layers", description="Copy all layers of the material, not only the selected one")

    @classmethod
    def poll(cls, context):
        if super().poll(context) and not material_of(context).lamina.layers:
            cls.poll_message_set(tip_("The material has no layers to copy"))
            return False
        return super().poll(context)

    def run(self, context):
        global _copied
        material = material_of(context)
        count, active = len(material.lamina.layers), material.lamina.active_layer
        chosen = range(count) if self.all_layers else [min(active, count - 1)]
        _copied = context.window_manager.clipboard = layers.copied_text(material, chosen)


class LAMINA_OT_layer_paste(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.layer_paste"
    bl_label = "Paste Layers"
    bl_description = "Put the copied layers above the selected one, with textures and animation if their material is in this file"

    def run(self, context):
        material = material_of(context)
        text = _copied if bpy.app.background else context.window_manager.clipboard
        for note in layers.paste_layers(material, text, _place(material)):
            self.report({"WARNING"}, f"Lamina: {note}")


def _place(material) -> int:
    """Where a new layer goes: above the selected one."""
    return min(material.lamina.active_layer, len(material.lamina.layers))


CLASSES = (
    LAMINA_OT_layer_add,
    LAMINA_OT_layer_add_ready,
    LAMINA_OT_layer_duplicate,
    LAMINA_OT_layer_remove,
    LAMINA_OT_layer_move,
    LAMINA_OT_layer_solo,
    LAMINA_OT_layer_drag,
    LAMINA_OT_layer_copy,
    LAMINA_OT_layer_paste,
)
