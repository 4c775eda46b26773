# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences."""

import bpy
from bpy.props import BoolProperty


class LaminaPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__.rsplit(".", 2)[0]

    stamps_note: BoolProperty(
        name="Materials in the Stamp's Note",
        description="Write names, errors and hashes of the Lamina materials of a render into the metadata of its picture",
        default=True,
    )

    def draw(self, _context) -> None:
        self.layout.prop(self, "stamps_note")
