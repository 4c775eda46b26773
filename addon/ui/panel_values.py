# SPDX-License-Identifier: GPL-3.0-or-later
"""The values of one layer or base in the panel, and small pieces that all of the panel is made of."""

import textwrap

from ...reference_py.errors import LaminaError
from ...reference_py.material.schema import COVERAGE, Parameter
from ..blender import environment
from ..blender.translation import CONTEXT, iface_
from ..material import elements, seen_color
from ..material.backend import OSL
from ..operators import mask_link_operators as mask_ops
from ..operators.note_operator import LAMINA_OT_note
from . import value_notes

_NOTE = 0.8  # buttons: the place of an icon beside a value
_MARGIN, _CHARACTER, _UNIT = 60, 6.4, 20  # pixels at scale 1: what borders and the icon take, a mean letter, and a button


def draw_element(layout, element) -> None:
    """Every parameter of a layer or the base: choices from the properties, values from the node's sockets."""
    try:
        node = elements.node_of(element)
    except LaminaError as error:
        layout.label(text=error.told(iface_), icon="ERROR", translate=False)
        return
    kind = elements.kind_of(element)
    column = layout.column()
    if kind.alternatives:
        draw_choice(column, element, "given")
    for parameter in kind.given_by(element.given):
        if parameter.is_structural:
            draw_choice(column, element, parameter.name)
        else:
            _draw_socket(column, element, node, parameter)
        if parameter.name == "thickness" and seen_color.has_seen_color(element):
            row = column.row()
            row.enabled = seen_color.is_settable(element)
            row.prop(node, seen_color.NAME)
    used = elements.used_features(element)
    for feature in kind.features:
        draw_choice(column, element, elements.use_of(feature))
        if feature not in used:
            continue
        if feature.alternatives:
            draw_choice(column, element, elements.given_of(feature))
        if feature is COVERAGE:
            _draw_mask(column)
        for parameter in elements.feature_parameters(element, feature):
            _draw_socket(column, element, node, parameter)


def _draw_mask(layout) -> None:
    """The ways to make a layer's mask; above its value, which Blender draws with all nodes that an artist unfolds, a ramp too."""
    row = layout.row(align=True)
    row.use_property_split = False
    row.menu(mask_ops.LAMINA_MT_mask.__name__, text="Mask", text_ctxt=CONTEXT, icon="MOD_MASK")
    row.operator(mask_ops.LAMINA_OT_mask_paint.bl_idname, text="", icon="BRUSH_DATA")


def _draw_socket(layout, element, node, parameter: Parameter) -> None:
    """Blender's own drawing of a socket: a dot to link a texture, what it is linked to, and a keyframe button.

    What there is to say of a value is an icon beside it with a tooltip: a line would push what is below.
    """
    socket = node.inputs.get(parameter.label)
    if socket is None:  # a file of an older version has it once its shader is made anew
        return
    row = layout.row(align=True)
    row.column().template_node_view(element.id_data.node_tree, node, socket)
    note = value_notes.note_of(element, node, parameter)
    row = row.row()
    row.ui_units_x = _NOTE
    if note is None:
        row.label(text="", icon="BLANK1")
    else:
        row.operator(LAMINA_OT_note.bl_idname, text="", icon=note.icon, emboss=False).text = note.text


def draw_choice(layout, owner, name: str, **options) -> None:
    """A property that makes the shader anew, greyed out where that cannot be done."""
    row = layout.row()
    row.enabled = owner.id_data.lamina.backend != OSL or environment.osl_available()[0]
    row.prop(owner, name, **options)


def draw_fact(layout, label: str, value: str) -> None:
    """A line to read, in the columns of the properties."""
    split = layout.split(factor=0.4)
    left = split.row()
    left.alignment = "RIGHT"
    left.label(text=label, text_ctxt=CONTEXT)
    right = split.row()
    right.active = False
    right.label(text=value, translate=False)


def draw_message(layout, context, message: str, icon: str, units: float = 0.0):
    """A box with a sentence, broken into lines as wide as the panel, or as `units` of a button. Returns the box, for a button."""
    box = layout.box()
    column = box.column(align=True)
    width = units * _UNIT or context.region.width / context.preferences.system.ui_scale
    letters = max(int((width - _MARGIN) / _CHARACTER), 10)
    for number, line in enumerate(textwrap.wrap(message[0].upper() + message[1:], letters)):
        column.label(text=line, icon="BLANK1" if number else icon, translate=False)
    return box
