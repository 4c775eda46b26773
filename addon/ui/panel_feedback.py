# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says of a material: one line below the list, whose height never changes, and all of it in what its button opens."""

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.lobes import methods
from ...reference_py.material.qualities import AUTO
from ..blender.translation import CONTEXT, iface_
from ..check import check
from ..jobs import bakes, fitting, saving
from ..material import hand_over, reading, roles, shader_node, state
from ..material.backend import NODES, OSL, branches_here, notice
from ..operators import check_operators as check_ops
from ..operators import material_operators as ops
from .panel_values import draw_choice, draw_fact, draw_message

_POPOVER_UNITS = 18


def problem_of(material) -> str:
    """What keeps a material from being edited or made here, in words; empty where nothing does."""
    if material is None:
        return ""
    try:
        reading.require_editable(material)
        if not material.lamina.is_layered:
            branches_here(material.lamina.backend)
    except LaminaError as error:
        return error.told(iface_)
    return ""


def draw_status(layout, context, material) -> None:
    """One line: what runs, or the worst of what is wrong, or how final the picture is; at its end the button that shows all."""
    row = layout.row(align=True)
    row.use_property_split = False
    findings = _findings(context, material)
    problem = problem_of(material)
    level = check.ERROR if problem else next((finding.level for finding in findings), check.NOTE)
    _draw_line(row, material, next((f.text(iface_) for f in findings if f.level != check.NOTE), problem))
    # an icon for each level of what is found
    row.popover(LAMINA_PT_findings.__name__, text="", icon={check.ERROR: "ERROR", check.WARNING: "INFO", check.NOTE: "CHECKMARK"}[level])


def _draw_line(row, material, problem: str) -> None:
    lamina = material.lamina
    soloed = next((index for index, layer in enumerate(lamina.layers) if layer.node == lamina.solo), None)
    if bake := bakes.bake_of(material):
        row.progress(factor=bake.share, text=iface_("Computing the final look"))
        row.operator(ops.LAMINA_OT_cancel_bake.bl_idname, text="", icon="CANCEL")
    elif fitting.running() is not None:
        draw_fit(row)
    elif saving.running() is not None:
        row.progress(factor=saving.running().share, text=iface_("Saving the preset"))
        row.operator("lamina.cancel_preset", text="", icon="CANCEL")
    elif problem:
        row.label(text=problem[0].upper() + problem[1:], translate=False)
    elif soloed is not None:
        row.label(text=iface_("Only {layer} is shown").format(layer=lamina.layers[soloed].name), translate=False)
        row.operator("lamina.layer_solo", text="", icon="X").index = soloed
    else:
        row.label(text=shown_quality(material), translate=False)


def shown_quality(material) -> str:
    """How final what a material shows is, in words."""
    try:
        return iface_("Final look" if state.is_final(material) else "Preview")
    except LaminaError:
        return iface_("Preview")  # a value is out of range, which Check tells


def draw_fit(row) -> None:
    """The progress of the fit that runs."""
    row.progress(factor=fitting.running().share, text=iface_("Fitting the measurement"))
    row.operator("lamina.cancel_fit", text="", icon="CANCEL")


def draw_unlayered_status(layout, context, material) -> None:
    """Below the ways to begin: what keeps one from it, and what a fit that runs, or that failed, says."""
    if problem := problem_of(material):
        draw_message(layout, context, problem, "ERROR")
    if fitting.running() is not None:
        draw_fit(layout.row(align=True))
    elif sentence := _fit_summary(context, material):
        draw_message(layout, context, sentence, "INFO")


def _findings(context, material) -> list["check.Finding"]:
    return check.find(material, context.scene, context.preferences)


def _fit_summary(context, material) -> str:
    return fitting.last_summary(material) or fitting.last_summary(getattr(context, "object", None))


class LAMINA_PT_findings(bpy.types.Panel):
    """Not a part of the panel: it lies over it, and so moves nothing."""

    bl_label = "What Is Wrong"
    bl_description = "All that Check finds, with a button for what can be mended here"
    bl_space_type = "PROPERTIES"
    bl_region_type = "HEADER"
    bl_options = {"INSTANCED"}
    bl_ui_units_x = _POPOVER_UNITS

    def draw(self, context):
        material = ops.material_of(context)
        draw_findings(self.layout, context, material)


def draw_findings(layout, context, material) -> None:
    """All that is known of a material's state, each with the button that mends it."""
    found = _findings(context, material)
    if problem := problem_of(material):
        draw_message(layout, context, problem, "ERROR", _POPOVER_UNITS)
    for finding in found:
        if finding.level == check.NOTE and finding.code != "without_osl":
            continue  # of what does not show here; Check says it
        box = draw_message(layout, context, finding.text(iface_), "INFO" if finding.level == check.NOTE else finding.level, _POPOVER_UNITS)
        if finding.mending and finding.code == "without_osl":
            box.operator(ops.LAMINA_OT_enable_osl.bl_idname)
        elif finding.mending:
            box.operator(check_ops.LAMINA_OT_mend.bl_idname, text=finding.mending).finding = finding.key
    if sum(bool(finding.mending) and finding.level != check.NOTE for finding in found) > 1:
        layout.operator(check_ops.LAMINA_OT_mend_all.bl_idname, icon="TOOL_SETTINGS")
    for sentence in filter(None, (*_device_notes(material), _fit_summary(context, material))):
        draw_message(layout, context, sentence, "INFO", _POPOVER_UNITS)
    if all(finding.level == check.NOTE for finding in found) and not problem:
        layout.label(text="Nothing is wrong", text_ctxt=CONTEXT, icon="CHECKMARK")
    layout.operator(check_ops.LAMINA_OT_check.bl_idname, icon="VIEWZOOM")


def _device_notes(material) -> list[str]:
    """What the devices that run no OSL, or few lobes, make of a material."""
    notes = [notice(material.lamina.backend).told(iface_)] if shader_node.backend_of(material) != OSL else []
    if material.lamina.lobe_count > methods.MAX_CLOSURES:
        notes.append(iface_("too many covered layers for OptiX devices, which may show less of them"))
    return notes


def draw_shader(layout, material) -> None:
    """Quality and backend, and what they cost: always as many lines, so that nothing below the mouse moves."""
    lamina = material.lamina
    layout.prop(lamina, "stack_name")
    draw_choice(layout, lamina, "tier")
    row = layout.row()
    row.active = lamina.tier == AUTO
    row.prop(lamina, "tolerance")
    layout.prop(lamina, "backend")
    script, stock = roles.node_with(material, OSL), roles.node_with(material, NODES)
    draw_fact(layout, "Made Of", iface_("OSL and Stock Nodes" if script and stock else "OSL" if script else "Stock Nodes"))
    draw_fact(layout, "Estimated Error", f"{lamina.error:.2g} %" if lamina.error >= 0.0 else iface_("not known"))
    cost = iface_("{times} of a glossy node").format(times=f"{lamina.cost:.1f}\N{MULTIPLICATION SIGN}")
    draw_fact(layout, "Cost", cost if lamina.cost > 0.0 else iface_("not known"))
    draw_fact(layout, "For Export", _hand_over(material))
    draw_fact(layout, "Source", lamina.source)


def _hand_over(material) -> str:
    """What exporters find of a material."""
    error = material.lamina.hand_over_error
    if not hand_over.has_hand_over(material):
        return iface_("none until the next change or save")
    if error < 0.0:
        return iface_("Principled, error not known until values rest")
    return iface_("Principled, error {percent} %").format(percent=f"{error:.2g}")


CLASSES = (LAMINA_PT_findings,)
