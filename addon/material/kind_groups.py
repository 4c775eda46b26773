# SPDX-License-Identifier: GPL-3.0-or-later
"""One pass-through node group per kind of layer or base; its interface is the schema's.

A group node of such a tree is a layer: the values, textures, drivers and keyframes sit on its sockets and stay
there whatever happens to the order. Interfaces are append-only, so files of older versions keep their links.
"""

import bpy
import numpy as np

from ...reference_py.material.schema import COLOR, FLOAT, NORMAL, SCHEMA, Kind, Parameter
from ..shader.working_space import into_working

KIND_KEY = "lamina_kind"
# What sockets were called before, by what they are called now.
_FORMER_LABELS = {"Scattered Share": "Scatter Albedo"}
_SOCKET_TYPES = {FLOAT: "NodeSocketFloat", COLOR: "NodeSocketColor"}


def group_key(kind: Kind) -> str:
    """What names the group of a kind: that of an opaque layer is another than that of the base, which has no coverage."""
    return f"{kind.name}_layer" if kind.name in SCHEMA.bases and kind is not SCHEMA.bases[kind.name] else kind.name


def group_of(kind: Kind) -> bpy.types.NodeTree:
    """The node group of a kind in this file, made or extended to the schema's parameters as needed."""
    own = (g for g in bpy.data.node_groups if g.get(KIND_KEY) == group_key(kind) and g.library is None)
    tree = next((g for g in own if hands_on(g, kind)), None)
    if tree is None:
        return fresh_group(kind)
    declare_missing(tree, kind)
    return tree


def fresh_group(kind: Kind) -> bpy.types.NodeTree:
    """A new node group of a kind."""
    tree = bpy.data.node_groups.new(f"Lamina {kind.label}", "ShaderNodeTree")
    tree[KIND_KEY] = group_key(kind)
    tree.nodes.new("NodeGroupInput").location = (-200, 0)
    tree.nodes.new("NodeGroupOutput").location = (200, 0)
    declare_missing(tree, kind)
    return tree


def hands_on(tree: bpy.types.NodeTree, kind: Kind) -> bool:
    """Whether a group hands every value of its kind on that it has a socket for, as nobody edited it."""
    if not _has_ends(tree):
        return False
    known = {p.label for p in kind.sockets}
    taken = {item.name for item in tree.interface.items_tree if item.in_out == "INPUT"}
    given = {item.name for item in tree.interface.items_tree if item.in_out == "OUTPUT"}
    outputs = next(n for n in tree.nodes if n.bl_idname == "NodeGroupOutput")
    fed = {
        socket.name
        for socket in outputs.inputs
        for link in socket.links
        if link.from_node.bl_idname == "NodeGroupInput" and link.from_socket.name == socket.name and not link.is_muted
    }
    return bool(taken) and taken & known <= given & fed and given & known <= taken


def _has_ends(tree) -> bool:
    return {"NodeGroupInput", "NodeGroupOutput"} <= {node.bl_idname for node in tree.nodes}


def declare_missing(tree: bpy.types.NodeTree, kind: Kind) -> None:
    """Give a kind's group, as an older file has it, the sockets that came later, at its end."""
    _follow_schema(tree, kind)
    present = {item.name for item in tree.interface.items_tree if item.in_out == "INPUT"}
    missing = [p for p in kind.sockets if p.label not in present]
    for parameter in missing:
        _declare(tree, parameter)
    if missing:
        _pass_through(tree)
        _give_defaults(tree, missing)


def _follow_schema(tree, kind: Kind) -> None:
    """Sockets of older files get their present names, ranges and tooltips; links, values and animation stay."""
    known = {p.label: p for p in kind.sockets}
    for item in tree.interface.items_tree:
        label = next((now for now, former in _FORMER_LABELS.items() if item.name == former), item.name)
        if item.name != label:
            item.name = label
        if item.in_out == "INPUT" and label in known:
            _describe(item, known[label])


def _describe(item, parameter: Parameter) -> None:
    """Range and tooltip of a socket. The range is the slider's: a socket takes what is typed or set beyond it.

    Each change makes Blender look through all trees that have the group, so only what differs is set.
    """
    wanted = {"description": parameter.tooltip}
    if parameter.type != COLOR:
        wanted |= {"min_value": parameter.minimum, "max_value": parameter.slider_maximum}
    for name, value in wanted.items():
        if getattr(item, name) != (np.float32(value) if isinstance(value, float) else value):
            setattr(item, name, value)


def update_groups() -> None:
    """Give the sliders of an older version's groups the ranges of this one's. No value changes."""
    kinds = {group_key(kind): kind for kind in (*SCHEMA.layers.values(), *SCHEMA.bases.values())}
    for tree in bpy.data.node_groups:
        if tree.is_editable and tree.get(KIND_KEY) in kinds:
            _follow_schema(tree, kinds[tree[KIND_KEY]])


def _declare(tree, parameter: Parameter) -> None:
    socket_type = _SOCKET_TYPES.get(parameter.type, "NodeSocketVector")
    socket = tree.interface.new_socket(parameter.label, in_out="INPUT", socket_type=socket_type)
    _describe(socket, parameter)
    if parameter.type == COLOR:
        socket.default_value = (*into_working(parameter.default), 1.0)
    else:
        socket.default_value = parameter.default
        # a direction has no value to type: it is linked, or the surface's own
        socket.hide_value = parameter is NORMAL.parameters[0]
        if parameter.type == FLOAT and (parameter.minimum, parameter.maximum) == (0.0, 1.0):
            socket.subtype = "FACTOR"
    tree.interface.new_socket(parameter.label, in_out="OUTPUT", socket_type=socket_type)


def _give_defaults(tree, parameters: list[Parameter]) -> None:
    """Nodes that are there already get new sockets with zeros: give them the schema's defaults."""
    owners = [m.node_tree for m in bpy.data.materials if m.library is None and m.node_tree is not None]
    for node in [n for owner in owners for n in owner.nodes if n.bl_idname == "ShaderNodeGroup" and n.node_tree == tree]:
        for parameter in parameters:
            give_value(node.inputs[parameter.label], parameter, parameter.default)


def give_value(socket: bpy.types.NodeSocket, parameter: Parameter, value) -> None:
    """Set a socket to a value of the model."""
    socket.default_value = (*into_working(value), 1.0) if parameter.type == COLOR else value


def _pass_through(tree) -> None:
    inputs = next(n for n in tree.nodes if n.bl_idname == "NodeGroupInput")
    outputs = next(n for n in tree.nodes if n.bl_idname == "NodeGroupOutput")
    for socket in outputs.inputs:
        if socket.name and not socket.is_linked:
            tree.links.new(inputs.outputs[socket.name], socket)
