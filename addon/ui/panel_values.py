# SPDX-License-Identifier: GPL-3.0-or-later
"""The values of one layer or base in the panel, and small pieces that all of the panel is made of."""

import textwrap

from bpy.app.translations import pgettext_iface as iface_

from ...reference_py.errors import LaminaError
from ...reference_py.material.schema import Parameter
from ...reference_py.optics import microfacet
from ..blender import environment
from ..material import elements, means
from ..material.backend import OSL

_MARGIN, _CHARACTER = 60, 6.4  # pixels at scale 1: what borders and the icon take, and a mean letter
# By the schema's unit. A column for it would shift the value from under the others.
UNITS = {"nm": "in nanometers", "degrees": "in degrees", "turns": "in turns"}


def draw_element(layout, element) -> None:
    """Every parameter of a layer or the base: choices from the properties, values from the node's sockets."""
    try:
        node = elements.node_of(element)
    except LaminaError as error:
        layout.label(text=str(error), icon="ERROR")
        return
    kind = elements.kind_of(element)
    column = layout.column()
    if kind.alternatives:
        draw_choice(column, element, "given")
    for parameter in kind.given_by(element.given):
        if parameter.is_structural:
            draw_choice(column, element, parameter.name)
            continue
        socket = _draw_socket(column, element, node, parameter)
        if parameter.name == "roughness" and socket is not None and not socket.is_linked:
            slope = microfacet.slope_deg_from_roughness(socket.default_value, element.distribution)
            draw_fact(column, "", iface_("Mean slope {degrees}\N{DEGREE SIGN}").format(degrees=f"{slope:.1f}"))
    used = elements.used_features(element)
    for feature in kind.features:
        draw_choice(column, element, elements.use_of(feature))
        if feature not in used:
            continue
        if feature.alternatives:
            draw_choice(column, element, elements.given_of(feature))
        for parameter in elements.feature_parameters(element, feature):
            _draw_socket(column, element, node, parameter)


def _draw_socket(layout, element, node, parameter: Parameter):
    """Blender's own drawing of a socket: a dot to link a texture, what it is linked to, and a keyframe button."""
    socket = node.inputs.get(parameter.label)
    if socket is None:  # a file of an older version has it once its shader is made anew
        return None
    layout.template_node_view(element.id_data.node_tree, node, socket)
    mean = means.kept_mean(socket)
    if mean is not None:
        text = f"{mean:.3g}" if isinstance(mean, float) else " ".join(f"{v:.3g}" for v in mean)
        draw_fact(layout, "", iface_("Mean of {source}: {value}").format(source=means.mean_name(socket), value=text))
    if parameter.unit and not socket.is_linked:
        draw_fact(layout, "", iface_(UNITS[parameter.unit]))
    return socket


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
    left.label(text=label)
    right = split.row()
    right.active = False
    right.label(text=value, translate=False)


def draw_message(layout, context, message: str, icon: str):
    """A box with a sentence, broken into lines as wide as the panel. Returns the box, for a button."""
    box = layout.box()
    column = box.column(align=True)
    scale = context.preferences.system.ui_scale
    letters = max(int((context.region.width / scale - _MARGIN) / _CHARACTER), 10)
    for number, line in enumerate(textwrap.wrap(message[0].upper() + message[1:], letters)):
        column.label(text=line, icon="BLANK1" if number else icon, translate=False)
    return box
