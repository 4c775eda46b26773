# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that bakes textures: a step at a time with a window, with Escape to cancel; to the end without one."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ...reference_py.errors import LaminaError
from ..blender.translation import rpt_
from ..exchange import textures
from . import material_operators as ops
from .exchange_operators import SIZES, tell

_TICK = 0.05


class LAMINA_OT_bake_textures(ops.LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.bake_textures"
    bl_label = "Bake to Textures"
    bl_description = "Write base color, roughness, metallic and, where the material has them, normal and coat as pictures over the object's UV map"
    bl_options = {"REGISTER"}

    directory: StringProperty(name="Folder", description="Folder that the pictures are written to", subtype="DIR_PATH")
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    size: EnumProperty(name="Size", description="Width and height of each picture", items=[(str(n), f"{n} px", "") for n in SIZES], default="1024")

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            if not self.directory:
                raise LaminaError("choose a folder for the pictures")
            self._bake = textures.TextureBake(ops.material_of(context), context.object, bpy.path.abspath(self.directory), int(self.size))
        except LaminaError as error:
            self.report({"ERROR"}, error.told(rpt_))
            return {"CANCELLED"}
        self._steps = self._bake.steps()
        if bpy.app.background:
            while True:
                done = self._step(context)
                if done:
                    return done
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._leave(context)
            self.report({"INFO"}, rpt_("Lamina: bake cancelled; nothing was written"))
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}  # nothing may change while a bake reads it
        done = self._step(context)
        if done:
            self._leave(context)
        return done or {"RUNNING_MODAL"}

    def cancel(self, context):
        self._leave(context)

    def _step(self, context) -> set[str]:
        """Do one step; what the operator returns, or an empty set if there are more."""
        try:
            share = next(self._steps)
        except StopIteration:
            tell(self, rpt_("{count} files in {folder}").format(count=len(self._bake.files), folder=self._bake.folder), self._bake.report)
            return {"FINISHED"}
        except LaminaError as error:
            self.report({"ERROR"}, error.told(rpt_))
            return {"CANCELLED"}
        if not bpy.app.background:
            context.window_manager.progress_update(100.0 * share)
            context.workspace.status_text_set(rpt_("Lamina: baking textures, {percent} %; Esc cancels").format(percent=round(100.0 * share)))
        return set()

    def _leave(self, context) -> None:
        self._steps.close()
        manager = context.window_manager
        manager.event_timer_remove(self._timer)
        manager.progress_end()
        context.workspace.status_text_set(None)


CLASSES = (LAMINA_OT_bake_textures,)
