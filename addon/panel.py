# SPDX-License-Identifier: GPL-3.0-or-later
"""The Lamina panel in the Material tab: layers, their values, the base, and what Cycles is told."""

import textwrap

import bpy

from ..reference_py.errors import LaminaError
from ..reference_py.network import AutoNetwork
from ..reference_py.optics.microfacet import slope_deg_from_roughness
from ..reference_py.schema import COLOR
from . import bakes
from . import material as materials
from . import operators as ops
from .backend import OSL, backend_here, notice
from .elements import kind_of, node_of, shown_parameters, use_of, used_features
from .rendering import environment
from .script_node import device_problem, scene_problem
from .shader_node import backend_of

_MARGIN, _CHARACTER = 60, 6.4  # pixels at scale 1: what borders and the icon take, and a mean letter


class LAMINA_UL_layers(bpy.types.UIList):
    """Layers from the top."""

    def draw_item(self, _context, layout, _data, element, _icon, _active_data, _active_name):
        row = layout.row()
        row.use_property_split = row.use_property_decorate = False
        name = row.row()
        name.active = element.visible
        name.prop(element, "name", text="", emboss=False, icon="MOD_THICKNESS")
        _draw_swatch(row, element)
        _draw_choice(row, element, "visible", text="", emboss=False, icon="HIDE_OFF" if element.visible else "HIDE_ON")

    def draw_filter(self, _context, _layout):
        """Nothing: the order of a stack means something, so it is neither sorted nor filtered."""


def _draw_swatch(layout, element) -> None:
    """The color of a layer that has one, as far as no texture gives it."""
    node = element.id_data.node_tree.nodes.get(element.node)
    label = next((p.label for p in kind_of(element).sockets if p.type == COLOR), None)
    if node is not None and label is not None and not node.inputs[label].is_linked:
        row = layout.row()
        row.ui_units_x = 1.4
        row.prop(node.inputs[label], "default_value", text="")


class LAMINA_MT_presets(bpy.types.Menu):
    bl_label = "Presets"

    def draw(self, _context):
        self.layout.operator_enum(ops.LAMINA_OT_apply_preset.bl_idname, "preset")
        self.layout.separator()
        self.layout.operator(ops.LAMINA_OT_import_stack.bl_idname, text="Import...", icon="IMPORT")


class LAMINA_MT_specials(bpy.types.Menu):
    bl_label = "Lamina Specials"

    def draw(self, _context):
        self.layout.operator(ops.LAMINA_OT_import_stack.bl_idname, text="Import...", icon="IMPORT")
        self.layout.operator(ops.LAMINA_OT_export_stack.bl_idname, text="Export...", icon="EXPORT")
        self.layout.separator()
        self.layout.operator(ops.LAMINA_OT_regenerate.bl_idname, icon="FILE_REFRESH")


class LAMINA_PT_material(bpy.types.Panel):
    bl_label = "Lamina"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    # Panels without a header come first. Below Preview and Surface, which for a Lamina material is a long list of
    # the shader's links, nobody would find the layers. So the header is a sub-panel's.
    bl_options = {"HIDE_HEADER"}

    @classmethod
    def poll(cls, context):
        material = ops.material_of(context)
        if material is not None:
            return not material.is_grease_pencil
        return ops.can_hold_material(getattr(context, "object", None))

    def draw(self, context):
        header, layout = self.layout.panel("lamina")
        header.label(text=self.bl_label)
        if layout is None:
            return
        layout.use_property_split = True
        material = ops.material_of(context)
        _draw_status(layout, context, material)
        if material is None or not material.lamina.is_layered:
            layout.menu(LAMINA_MT_presets.__name__, text="Pick a Preset", icon="PRESET")
            return
        _draw_stack(layout, material)
        lamina = material.lamina
        if 0 <= lamina.active_layer < len(lamina.layers):
            layer = lamina.layers[lamina.active_layer]
            header, body = layout.panel("lamina_layer")
            header.label(text=layer.name)
            if body:
                body.active = layer.visible
                _draw_element(body, layer)
        header, body = layout.panel("lamina_base")
        header.label(text="Base")
        header.operator_menu_enum(ops.LAMINA_OT_set_base.bl_idname, "kind", text=kind_of(lamina.base).label)
        if body:
            _draw_element(body, lamina.base)
        header, body = layout.panel("lamina_shader", default_closed=True)
        header.label(text="Shader")
        header.label(text=lamina.note.partition(":")[0])
        if body:
            _draw_shader(body, context, material)


def _draw_status(layout, context, material) -> None:
    """What keeps the material from being edited or rendered, in words, with the button that helps if there is one."""
    try:
        if material is not None:
            materials.require_editable(material)
            backend_here(material.lamina.backend)
        if material is not None and material.lamina.problem:
            raise LaminaError(material.lamina.problem)
    except LaminaError as error:
        _draw_message(layout, context, str(error), "ERROR")
        return
    if material is None or not material.lamina.is_layered:
        return
    if _is_stale(material):
        box = _draw_message(layout, context, "values changed; the shader holds the old ones", "INFO")
        box.operator(ops.LAMINA_OT_regenerate.bl_idname, text="Update")
    _draw_bake(layout, material)
    if backend_of(material) != OSL:
        if told := notice(material.lamina.backend):
            _draw_message(layout, context, told, "INFO")
    elif not environment.osl_available()[0]:
        box = _draw_message(layout, context, f"the shader is an OSL script, and {environment.osl_available()[1]}", "ERROR")
        box.operator(ops.LAMINA_OT_regenerate.bl_idname, text="Make It of Stock Nodes")
    elif problem := scene_problem(context.scene):
        box = _draw_message(layout, context, problem, "INFO")
        box.operator(ops.LAMINA_OT_enable_osl.bl_idname)
    elif problem := device_problem(context.scene, context.preferences):
        _draw_message(layout, context, problem, "INFO")


def _draw_bake(layout, material) -> None:
    """A running bake with its progress, or why there is none."""
    row = layout.row(align=True)
    if bake := bakes.bake_of(material):
        row.progress(factor=bake.share, text="Computing the truth; shown by tier analytic")
        row.operator(ops.LAMINA_OT_cancel_bake.bl_idname, text="", icon="CANCEL")
    elif reason := bakes.given_up(material):
        row.label(text=f"Shown by tier analytic; bake {reason}", icon="INFO")
        row.operator(ops.LAMINA_OT_retry_bake.bl_idname, text="", icon="FILE_REFRESH")


def _draw_message(layout, context, message: str, icon: str):
    box = layout.box()
    column = box.column(align=True)
    scale = context.preferences.system.ui_scale
    letters = max(int((context.region.width / scale - _MARGIN) / _CHARACTER), 10)
    for number, line in enumerate(textwrap.wrap(message[0].upper() + message[1:], letters)):
        column.label(text=line, icon="BLANK1" if number else icon)
    return box


def _draw_stack(layout, material) -> None:
    lamina = material.lamina
    row = layout.row(align=True)
    row.use_property_split = False
    row.prop(lamina, "stack_name", text="")
    row.menu(LAMINA_MT_presets.__name__, text="", icon="PRESET")
    row = layout.row()
    row.template_list(
        LAMINA_UL_layers.__name__, "", lamina, "layers", lamina, "active_layer", rows=4, sort_lock=True
    )
    column = row.column(align=True)
    column.operator(ops.LAMINA_OT_layer_add.bl_idname, text="", icon="ADD")
    column.operator(ops.LAMINA_OT_layer_remove.bl_idname, text="", icon="REMOVE")
    column.separator()
    column.menu(LAMINA_MT_specials.__name__, text="", icon="DOWNARROW_HLT")
    column.separator()
    column.operator(ops.LAMINA_OT_layer_move.bl_idname, text="", icon="TRIA_UP").direction = "UP"
    column.operator(ops.LAMINA_OT_layer_move.bl_idname, text="", icon="TRIA_DOWN").direction = "DOWN"


def _draw_element(layout, element) -> None:
    """Every parameter of a layer or the base: choices from the properties, values from the node's sockets."""
    try:
        node = node_of(element)
    except LaminaError as error:
        layout.label(text=str(error), icon="ERROR")
        return
    kind = kind_of(element)
    column = layout.column()
    if kind.alternatives:
        _draw_choice(column, element, "given")
    for parameter in shown_parameters(kind, element.given):
        if parameter.is_structural:
            _draw_choice(column, element, parameter.name)
            continue
        socket = _draw_socket(column, element, node, parameter)
        if parameter.name == "roughness" and not socket.is_linked:
            slope = slope_deg_from_roughness(socket.default_value, element.distribution)
            _draw_fact(column, "", f"Mean slope {slope:.1f}\N{DEGREE SIGN}")
    used = used_features(element)
    for feature in kind.features:
        _draw_choice(column, element, use_of(feature))
        for parameter in feature.parameters if feature in used else ():
            _draw_socket(column, element, node, parameter)


def _draw_socket(layout, element, node, parameter):
    """Blender's own drawing of a socket: a dot to link a texture, what it is linked to, and a keyframe button."""
    socket = node.inputs.get(parameter.label)
    if socket is not None:  # a file of an older version has it once its shader is made anew
        layout.template_node_view(element.id_data.node_tree, node, socket)
    return socket


def _draw_choice(layout, owner, name: str, **options) -> None:
    """A property that makes the shader anew, greyed out where that cannot be done."""
    row = layout.row()
    row.enabled = owner.id_data.lamina.backend != OSL or environment.osl_available()[0]
    row.prop(owner, name, **options)


def _draw_fact(layout, label: str, value: str) -> None:
    """A line to read, in the columns of the properties."""
    split = layout.split(factor=0.4)
    left = split.row()
    left.alignment = "RIGHT"
    left.label(text=label)
    right = split.row()
    right.active = False
    right.label(text=value)


def _is_stale(material) -> bool:
    try:
        return materials.is_stale(material)
    except LaminaError:  # what is wrong with the values is drawn beside them
        return False


def _draw_shader(layout, context, material) -> None:
    lamina = material.lamina
    _draw_choice(layout, lamina, "tier")
    if lamina.tier == AutoNetwork.tier:
        layout.prop(lamina, "tolerance")
    layout.prop(lamina, "backend")
    node = material.node_tree.nodes.get(lamina.shader_node)
    code = node and (node.script if backend_of(material) == OSL else node.node_tree)
    if lamina.note:
        _draw_message(layout, context, f"chosen: {lamina.note}", "INFO")
    _draw_fact(layout, "Lobes", str(lamina.lobe_count))
    _draw_fact(layout, "Code", code.name if code is not None else "missing; regenerate the shader")
    if lamina.source:
        _draw_fact(layout, "Source", lamina.source)


CLASSES = (LAMINA_UL_layers, LAMINA_MT_presets, LAMINA_MT_specials, LAMINA_PT_material)
