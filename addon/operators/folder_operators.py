# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons of the preferences about what Lamina keeps on the disk."""

import bpy

from ...reference_py.lobes import cache
from ..blender.translation import rpt_
from ..blender.user_folders import cache_folder
from .material_operators import LaminaOperator


class LAMINA_OT_clear_cache(LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.clear_cache"
    bl_label = "Clear"
    bl_description = "Remove the final looks that are kept between sessions; they are computed again where they are needed"
    bl_options = {"REGISTER"}

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def run(self, _context):
        gone = cache.clean(cache_folder())
        self.report({"INFO"}, rpt_("Lamina: {count} files removed, {size} MB").format(count=gone.files, size=f"{gone.size / 1e6:.1f}"))


CLASSES = (LAMINA_OT_clear_cache,)
