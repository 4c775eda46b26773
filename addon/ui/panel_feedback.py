# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel tells: what is wrong and how it is mended, a running bake, and what Cycles was sentence."""

from bpy.app.translations import pgettext_iface as iface_

from ...reference_py.errors import LaminaError
from ...reference_py.material.qualities import AUTO
from ..check import check
from ..jobs import bakes, fitting
from ..material import hand_over, reading, roles, shader_node
from ..material.backend import NODES, OSL, branches_here, notice
from ..operators import check_operators as check_ops
from ..operators import material_operators as ops
from .panel_values import draw_choice, draw_fact, draw_message

_MOST_FINDINGS = 4


def draw_status(layout, context, material) -> None:
    """What keeps the material from being edited or rendered, in words, with the button that helps if there is one."""
    try:
        if material is not None:
            reading.require_editable(material)
            if not material.lamina.is_layered:
                branches_here(material.lamina.backend)
    except LaminaError as error:
        draw_message(layout, context, str(error), "ERROR")
        return
    if material is None or not material.lamina.is_layered:
        return
    found = [finding for finding in check.find(material, context.scene, context.preferences) if finding.level != check.NOTE]
    problem = material.lamina.problem
    if problem and problem not in [finding.text() for finding in found]:
        draw_message(layout, context, problem, "ERROR")
    _draw_bake(layout, material)
    _draw_solo(layout, material.lamina)
    _draw_findings(layout, context, found)


def _draw_bake(layout, material) -> None:
    """A running bake with its progress, or why there is none."""
    row = layout.row(align=True)
    if bake := bakes.bake_of(material):
        row.progress(factor=bake.share, text=iface_("Computing the truth; shown by tier analytic"))
        row.operator(ops.LAMINA_OT_cancel_bake.bl_idname, text="", icon="CANCEL")


def _draw_solo(layout, lamina) -> None:
    for index, layer in enumerate(lamina.layers):
        if layer.node == lamina.solo:
            row = layout.row(align=True)
            row.label(text=iface_("Only {layer} is shown").format(layer=layer.name), icon="SOLO_ON", translate=False)
            row.operator("lamina.layer_solo", text="", icon="X").index = index


def _draw_findings(layout, context, findings: list["check.Finding"]) -> None:
    for finding in findings[:_MOST_FINDINGS]:
        box = draw_message(layout, context, finding.text(iface_), finding.level)
        if finding.mending:
            box.operator(check_ops.LAMINA_OT_mend.bl_idname, text=finding.mending).finding = finding.key
    if len(findings) > _MOST_FINDINGS:
        more = iface_("and {count} more").format(count=len(findings) - _MOST_FINDINGS)
        layout.label(text=more, translate=False)
    if sum(bool(finding.mending) for finding in findings) > 1:
        layout.operator(check_ops.LAMINA_OT_mend_all.bl_idname, icon="TOOL_SETTINGS")


def draw_shader(layout, context, material) -> None:
    """Tier and backend, what was chosen, and what it costs."""
    lamina = material.lamina
    draw_choice(layout, lamina, "tier")
    if lamina.tier == AUTO:
        layout.prop(lamina, "tolerance")
    layout.prop(lamina, "backend")
    script, stock = roles.node_with(material, OSL), roles.node_with(material, NODES)
    code = [what.name for what in (script and script.script, stock and stock.node_tree) if what is not None]
    if lamina.note:
        draw_message(layout, context, iface_("chosen: {note}").format(note=lamina.note), "INFO")
    draw_fact(layout, "Made Of", iface_("OSL and Stock Nodes" if script and stock else "OSL" if script else "Stock Nodes"))
    draw_fact(layout, "Lobes", str(lamina.lobe_count))
    if lamina.error >= 0.0:
        draw_fact(layout, "Estimated Error", f"{lamina.error:.2g} %")
    if lamina.cost > 0.0:
        draw_fact(layout, "Relative Cost", iface_("{times} of a glossy node").format(times=f"{lamina.cost:.1f}\N{MULTIPLICATION SIGN}"))
    draw_fact(layout, "Hand-over", _hand_over(material))
    draw_fact(layout, "Code", ", ".join(code) if code else iface_("missing; regenerate the shader"))
    if lamina.source:
        draw_fact(layout, "Source", lamina.source)
    _draw_without_osl(layout, context, material)
    layout.operator(check_ops.LAMINA_OT_check.bl_idname, icon="VIEWZOOM")


def _hand_over(material) -> str:
    """What exporters find of a material."""
    error = material.lamina.hand_over_error
    if not hand_over.has_hand_over(material):
        return iface_("none until the next change or save")
    if error < 0.0:
        return iface_("Principled, error not known until values rest")
    return iface_("Principled, error {percent} %").format(percent=f"{error:.2g}")


def _draw_without_osl(layout, context, material) -> None:
    """Why the material or the scene shows stock nodes, and the button that changes it. Where that costs nothing the status does not say it."""
    if shader_node.backend_of(material) != OSL and (sentence := notice(material.lamina.backend, iface_)):
        draw_message(layout, context, sentence, "INFO")
    for finding in check.find(material, context.scene, context.preferences):
        if finding.code == "without_osl" and finding.level == check.NOTE:
            box = draw_message(layout, context, finding.text(iface_), "INFO")
            if finding.mending:
                box.operator(ops.LAMINA_OT_enable_osl.bl_idname)


def draw_fit(layout, context, material) -> None:
    """A running fit with its progress, or what the last one sentence of this material or object."""
    if (running := fitting.running()) is not None:
        row = layout.row(align=True)
        row.progress(factor=running.share, text=iface_("Fitting the measurement"))
        row.operator("lamina.cancel_fit", text="", icon="CANCEL")
    elif sentence := fitting.last_summary(material) or fitting.last_summary(getattr(context, "object", None)):
        draw_message(layout, context, sentence, "INFO")
