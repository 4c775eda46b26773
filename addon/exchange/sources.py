# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled node of somebody's material: its values, and what feeds and moves them."""

import re

import bpy
import numpy as np

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.exchange.principled import DEFAULTS
from ...reference_py.material.schema import COLOR, FLOAT, Parameter
from ..material.entry import find_entry
from ..material.principled_node import NORMALS, PRINCIPLED
from ..material.source_mean import mean_of, source_of_socket
from ..shader.working_space import out_of_working

_NODE_PATH = re.compile(r'nodes\["(.*?)"\]')


def principled_of(material: bpy.types.Material) -> bpy.types.Node:
    """The Principled node that is a material's surface, or the body in the user's own mix. Raises LaminaError where something else is."""
    tree = material.node_tree
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL") if tree is not None else None
    node = find_entry(output).former
    if node is None or node.bl_idname != PRINCIPLED:
        what = node.bl_label if node is not None else Sentence("nothing")
        raise LaminaError("material {material}: its surface is {what}; only a Principled BSDF can be converted", material=material.name, what=what)
    return node


def read_principled(node: bpy.types.Node) -> tuple[dict, dict[str, bpy.types.NodeSocket]]:
    """Values by socket name, of linked ones the means of what is linked, and the sources of these. Raises LaminaError where none can be baked now."""
    values, sources = {}, {}
    for socket in node.inputs:
        source = source_of_socket(socket)
        if source is not None and (socket.name in DEFAULTS or socket.name in NORMALS):
            sources[socket.name] = source
        if socket.name in DEFAULTS and source is not None:
            is_color = socket.type in ("RGBA", "VECTOR")
            value = mean_of(source, Parameter(socket.name, COLOR if is_color else FLOAT, None, "", "", maximum=1.0 if socket.type == "RGBA" else float("inf")))
            values[socket.name] = tuple(value) if is_color else value
        elif socket.name in DEFAULTS:
            values[socket.name] = _value_of(socket)
    return values, sources


def _value_of(socket: bpy.types.NodeSocket) -> float | tuple:
    value = socket.default_value
    if socket.type == "RGBA":
        return tuple(np.clip(out_of_working(tuple(value)[:3]), 0.0, None))
    return tuple(value) if socket.type == "VECTOR" else float(value)


def animated_parts(node: bpy.types.Node) -> bool:
    """Whether keyframes or drivers move a node's values."""
    data = node.id_data.animation_data
    if data is None:
        return False
    curves = list(data.drivers)
    if data.action is not None:
        curves += [c for layer in data.action.layers for strip in layer.strips for bag in strip.channelbags for c in bag.fcurves]
    names = (_NODE_PATH.match(curve.data_path) for curve in curves)
    return any(m and bpy.utils.unescape_identifier(m[1]) == node.name for m in names)
