# SPDX-License-Identifier: GPL-3.0-or-later
"""The icon beside a value: its tooltip is the note, which a click puts into the status bar for those who want to keep it."""

import bpy
from bpy.props import StringProperty


class LAMINA_OT_note(bpy.types.Operator):
    bl_idname = "lamina.note"
    bl_label = "Note"
    bl_description = "What there is to say of this value"
    bl_options = {"INTERNAL"}

    text: StringProperty(name="Note", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def description(cls, _context, properties):
        return properties.text

    def execute(self, _context):
        self.report({"INFO"}, self.text)
        return {"FINISHED"}


CLASSES = (LAMINA_OT_note,)
