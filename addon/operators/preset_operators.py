# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of presets, and what it does with those that users save."""

from dataclasses import replace

import bpy
from bpy.props import StringProperty

from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ..blender.translation import CONTEXT, rpt_
from ..blender.user_folders import presets_folder
from ..jobs import saving
from ..library import asset_library, preset_assets, user_presets
from ..library.preset_catalogues import CATALOGUES, OWN, catalogue_id
from ..library.preset_icons import preset_icon, user_preset_icon
from ..material import chosen, reading
from ..material import material as materials
from . import material_operators as ops

_DIALOG_WIDTH = 400  # pixels: for the sentences of what a preset leaves out
# Before the source of the numbers that a preset was begun from: they may have been changed since.
_BEGUN_FROM = "Own preset, begun from: "


def _source(before: str) -> str:
    return f"{_BEGUN_FROM}{before.removeprefix(_BEGUN_FROM)}" if before else "Own preset"


class LAMINA_OT_save_preset(ops.LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.save_preset"
    bl_label = "Save as Preset"
    bl_description = "Keep the material's visible layers and base with their textures as a preset and asset of yours; its picture is rendered beside the window"
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the preset: letters, digits, spaces, - and _", maxlen=user_presets.LONGEST)

    def invoke(self, context, _event):
        self.name = ops.material_of(context).lamina.stack_name[: user_presets.LONGEST]
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG_WIDTH)

    def draw(self, context):
        self.layout.prop(self, "name")
        for sentence in preset_assets.left_out(ops.material_of(context)):
            self.layout.label(text=sentence, icon="INFO", translate=False)

    def run(self, context):
        material = ops.material_of(context)
        stack = reading.measured_stack(material)
        stack = replace(stack, name=self.name.strip(), source=_source(stack.source))
        sentences = preset_assets.left_out(material)
        if not bpy.app.background:
            saving.start(material, self.name, stack, catalogue_id(OWN))
            for sentence in sentences:
                self.report({"INFO"}, f"Lamina: {sentence}")
            return
        name, why = preset_assets.save(material, self.name, stack, catalogue_id(OWN))
        asset_library.show_own()
        for sentence in sentences:
            self.report({"INFO"}, f"Lamina: {sentence}")
        if why:
            self.report({"WARNING"}, rpt_("Lamina: the preset has no picture: {reason}").format(reason=why))
        self.report({"INFO"}, rpt_("Lamina: preset {name} saved in {folder}").format(name=presets.label(name), folder=presets_folder()))


class LAMINA_OT_cancel_preset(ops.LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.cancel_preset"
    bl_label = "Cancel Saving"
    bl_description = "Stop saving the preset; nothing of it is left"
    bl_options = {"REGISTER"}

    def run(self, _context):
        saving.cancel()


class LAMINA_OT_apply_user_preset(ops.StackOperator, bpy.types.Operator):
    bl_idname = "lamina.apply_user_preset"
    bl_label = "Apply Own Preset"
    bl_description = "Make the material a stack of layers that you saved, in place of what it shows"

    name: StringProperty(name="Name", description="Name of the preset")

    def stack(self) -> Stack:
        return user_presets.load(self.name)

    def apply(self, material, stack) -> None:
        asset = user_presets.asset_of(self.name)
        if not asset.is_file():
            materials.apply_stack(material, stack, *chosen.for_new(material))
            return
        with preset_assets.asset_of(asset) as source:
            materials.apply_stack(material, stack, *chosen.for_new(material), finish=lambda target: preset_assets.dress(source, target))


class LAMINA_OT_remove_preset(ops.LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.remove_preset"
    bl_label = "Remove Preset"
    bl_description = "Delete a preset that you saved, with its picture and its textures"
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the preset")

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def run(self, _context):
        user_presets.remove(self.name)
        self.report({"INFO"}, rpt_("Lamina: preset {name} removed").format(name=presets.label(self.name)))


class LAMINA_MT_remove_preset(bpy.types.Menu):
    bl_label = "Remove Preset"

    def draw(self, _context):
        for name in user_presets.names():
            text, icon = presets.label(name), user_preset_icon(name)
            self.layout.operator(LAMINA_OT_remove_preset.bl_idname, text=text, translate=False, icon_value=icon).name = name


def draw_presets(layout) -> None:
    """A column of every catalogue, one of the user's own presets, and below what is done with files."""
    row = layout.row()
    for catalogue, names in CATALOGUES.items():
        column = row.column()
        column.label(text=catalogue, text_ctxt=CONTEXT)
        column.separator()
        for name in names:
            text, icon = presets.label(name), preset_icon(name)
            column.operator(ops.LAMINA_OT_apply_preset.bl_idname, text=text, icon_value=icon).preset = name
    own = user_presets.names()
    if own:
        column = row.column()
        column.label(text=OWN, text_ctxt=CONTEXT)
        column.separator()
        for name in own:
            text, icon = presets.label(name), user_preset_icon(name)
            column.operator(LAMINA_OT_apply_user_preset.bl_idname, text=text, translate=False, icon_value=icon).name = name
    layout.separator()
    layout.operator(LAMINA_OT_save_preset.bl_idname, text="Save as Preset...", icon="ADD")
    if own:
        layout.menu(LAMINA_MT_remove_preset.__name__, icon="REMOVE")


CLASSES = (LAMINA_OT_save_preset, LAMINA_OT_cancel_preset, LAMINA_OT_apply_user_preset, LAMINA_OT_remove_preset, LAMINA_MT_remove_preset)
