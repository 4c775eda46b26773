# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that look for what is wrong with a material and mend it. Each is one undo step."""

import bpy
from bpy.props import StringProperty

from ...reference_py.errors import LaminaError
from ..blender.translation import rpt_
from ..check import check
from ..material import reading
from .material_operators import LayeredOperator, material_of


def _found(context) -> list["check.Finding"]:
    return check.find(material_of(context), context.scene, context.preferences)


def _said(finding: "check.Finding") -> str:
    return finding.text(rpt_)


class LAMINA_OT_check(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.check"
    bl_label = "Check"
    bl_description = "Look for what keeps the material from rendering as its layers say: OSL, nodes, links, groups and values"
    bl_options = {"REGISTER"}

    def run(self, context):
        reading.measure_means(material_of(context))
        found = _found(context)
        for finding in found:
            self.report({"INFO" if finding.level == check.NOTE else "WARNING"}, f"Lamina: {_said(finding)}")
        if not found:
            self.report({"INFO"}, rpt_("Lamina: nothing is wrong with the material"))


class LAMINA_OT_mend(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.mend"
    bl_label = "Mend"
    bl_description = "Mend this one thing"

    finding: StringProperty(name="Finding", description="Key of what Check found", options={"HIDDEN"})

    def run(self, context):
        check.mend(material_of(context), context.scene, context.preferences, self.finding)


class LAMINA_OT_mend_all(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.mend_all"
    bl_label = "Mend All"
    bl_description = "Mend everything that Check found and that can be mended; the scene's engine and OSL stay as they are"

    def run(self, context):
        material, tried = material_of(context), set()
        while left := [f for f in _found(context) if f.mending and f.level != check.NOTE and f.code != "without_osl" and f.key not in tried]:
            tried.add(left[0].key)
            try:
                check.mend(material, context.scene, context.preferences, left[0].key)
            except LaminaError as error:  # another finding may be the reason, and is mended later
                self.report({"WARNING"}, f"Lamina: {error.told(rpt_)}")


CLASSES = (LAMINA_OT_check, LAMINA_OT_mend, LAMINA_OT_mend_all)
