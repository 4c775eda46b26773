# SPDX-License-Identifier: GPL-3.0-or-later
"""What feeds the sockets of a Principled node and of a stack's layers, and the nodes that a link goes through."""

import re
from collections.abc import Iterator

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.exchange.matching import ColorMap
from ...reference_py.exchange.principled import DEFAULTS, PLACES
from ..nodes.elements import kind_of, node_of, used_features
from ..nodes.kind_groups import KIND_KEY

PRINCIPLED = "ShaderNodeBsdfPrincipled"
_NORMALS = ("Normal", "Coat Normal")
_APART = 200
_NODE_PATH = re.compile(r'nodes\["(.*?)"\]')


def principled_of(material: bpy.types.Material) -> bpy.types.Node:
    """The Principled node that is a material's surface. Raises LaminaError where something else is."""
    tree = material.node_tree
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL") if tree is not None else None
    surface = output.inputs["Surface"] if output is not None else None
    node = surface.links[0].from_node if surface is not None and surface.is_linked else None
    if node is None or node.bl_idname != PRINCIPLED:
        what = node.bl_label if node is not None else "nothing"
        raise LaminaError(f"material {material.name}: its surface is {what}; only a Principled BSDF can be converted")
    return node


def read_principled(node: bpy.types.Node) -> tuple[dict, dict[str, bpy.types.NodeSocket]]:
    """Values by socket name, and the sources of those that are linked."""
    values, sources = {}, {}
    for socket in node.inputs:
        if socket.is_linked and (socket.name in DEFAULTS or socket.name in _NORMALS):
            sources[socket.name] = socket.links[0].from_socket
        if socket.name in DEFAULTS:
            value = socket.default_value
            values[socket.name] = tuple(value)[:3] if socket.type == "RGBA" else float(value)
    return values, sources


def parameter_of(element, parameter: str) -> str:
    """`parameter` as the element's kind calls it: a metal's color is its reflectance."""
    return "reflectance" if parameter == "color" and kind_of(element).alternatives else parameter


def linked_places(material: bpy.types.Material, owners: dict[str, int]) -> Iterator[tuple[str, object, object, bpy.types.NodeSocket]]:
    """(socket of Principled, element, schema's parameter, source) of every link that Principled has a place for."""
    elements = [*material.lamina.shown_layers, material.lamina.base]
    for socket, roles, name in PLACES:
        for role in [r for r in roles if r in owners][:1] if name != "normal" else [r for r in roles if r in owners]:
            element = elements[owners[role]]
            source = source_of(element, parameter_of(element, name))
            if source is not None:
                yield socket, element, kind_of(element).parameter(parameter_of(element, name)), source
                break


def source_of(element, name: str) -> bpy.types.NodeSocket | None:
    """What is linked to an element's parameter, if it takes part."""
    kind = kind_of(element)
    unused = {p.name for f in kind.features if f not in used_features(element) for p in f.parameters}
    if name in unused or name not in {p.name for p in kind.sockets}:
        return None
    if name == "reflectance" and name not in element.given:
        return None
    socket = node_of(element).inputs[kind.parameter(name).label]
    return socket.links[0].from_socket if socket.is_linked else None


def is_layer(node: bpy.types.Node) -> bool:
    """Whether a node holds the values of a layer or base."""
    return node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None and KIND_KEY in node.node_tree


def link_through(source: bpy.types.NodeSocket, target: bpy.types.NodeSocket, colors: ColorMap) -> None:
    """Link a color to a socket by way of a color map, made of Vector Math nodes."""
    tree = target.id_data
    steps = (
        ("MULTIPLY_ADD", colors.p1, colors.p0), ("MULTIPLY_ADD", colors.p2, np.ones(3)), ("DIVIDE", None, None),
        ("MAXIMUM", np.zeros(3), None), ("MINIMUM", np.full(3, colors.most), None),
    )  # fmt: skip
    nodes = []
    for place, (operation, first, second) in enumerate(steps):
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.operation, node.label, node.hide = operation, "Lamina color", True
        node.location = (target.node.location.x - _APART * (len(steps) - place), target.node.location.y)
        for socket, value in zip(list(node.inputs)[1:], (first, second)):
            if value is not None:
                socket.default_value = tuple(float(v) for v in value)
        nodes.append(node)
    above, below, divided, positive, bounded = nodes
    for node in (above, below):
        tree.links.new(source, node.inputs[0])
    tree.links.new(above.outputs[0], divided.inputs[0])
    tree.links.new(below.outputs[0], divided.inputs[1])
    tree.links.new(divided.outputs[0], positive.inputs[0])
    tree.links.new(positive.outputs[0], bounded.inputs[0])
    tree.links.new(bounded.outputs[0], target)


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
