# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of what feeds a layer's node: values, textures with all that is before them, drivers and keyframes."""

import re

import bpy

from .kind_groups import KIND_KEY

_NODE_PATH = re.compile(r'nodes\["(.*?)"\](.*)')
_KEY_PROPERTIES = (
    "interpolation", "easing", "amplitude", "back", "period", "type",
    "handle_left_type", "handle_right_type", "handle_left", "handle_right",
)  # fmt: skip


def copy_inputs(source: bpy.types.Node, target: bpy.types.Node) -> list[str]:
    """Give a node the inputs of another of the same kind, in the same material or another one.

    In the same one textures are shared, in another one their nodes are copied. Returns one sentence for each thing that
    cannot come along.
    """
    here, there = source.id_data, target.id_data
    told: list[str] = []
    copies = {source.name: target}
    for socket in source.inputs:
        twin = target.inputs.get(socket.name)
        if twin is None:
            continue
        if hasattr(socket, "default_value"):
            twin.default_value = socket.default_value
        for link in socket.links:
            if link.from_node.type == "GROUP" and link.from_node.node_tree is not None and KIND_KEY in link.from_node.node_tree:
                if here != there:
                    told.append(f"{source.label}: {socket.name} was linked to another layer; the link stays behind")
                    continue
            origin = link.from_node if here == there else _copied(link.from_node, there, copies)
            made = there.links.new(_output_of(origin, link.from_socket), twin)
            made.is_muted = link.is_muted
    if here != there:
        for number, (name, node) in enumerate(list(copies.items())[1:], 1):
            node.location = (target.location.x - 240 * number, target.location.y)
    _copy_animation(here, there, {name: node.name for name, node in copies.items()})
    return told


def _copied(node: bpy.types.Node, tree: bpy.types.NodeTree, copies: dict[str, bpy.types.Node]) -> bpy.types.Node:
    """A copy of a node in another tree, with what feeds it."""
    if node.name in copies:
        return copies[node.name]
    copy = copies[node.name] = tree.nodes.new(node.bl_idname)
    copy.name, copy.label, copy.mute = node.name, node.label, node.mute
    _copy_properties(node, copy)
    for socket, twin in zip(node.inputs, copy.inputs):
        if hasattr(socket, "default_value"):
            twin.default_value = socket.default_value
        for link in socket.links:
            tree.links.new(_output_of(_copied(link.from_node, tree, copies), link.from_socket), twin)
    for socket, twin in zip(node.outputs, copy.outputs):
        if hasattr(socket, "default_value"):  # a Value or RGB node has its value there
            twin.default_value = socket.default_value
    return copy


def _output_of(node: bpy.types.Node, like: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """A node's output that stands where a socket stands in its own node."""
    return node.outputs[list(like.node.outputs).index(like)]


# Blender's own bookkeeping, and what `_copied` sets itself.
_LEFT_OUT = frozenset((
    "rna_type", "name", "label", "parent", "location", "location_absolute", "dimensions", "select", "mute", "inputs", "outputs",
    "internal_links", "bl_idname", "is_active_output", "show_preview",
))  # fmt: skip


def _copy_properties(source, target) -> None:
    """All settings of a node, with its ramps, curves, image users and mappings."""
    for prop in source.bl_rna.properties:
        name = prop.identifier
        if name in _LEFT_OUT or name.startswith("bl_"):
            continue
        value = getattr(source, name)
        if prop.type == "COLLECTION":
            _copy_items(value, getattr(target, name))
        elif prop.type == "POINTER" and prop.is_readonly:
            if value is not None:
                _copy_properties(value, getattr(target, name))
        elif not prop.is_readonly:
            setattr(target, name, value)
    if isinstance(source, bpy.types.CurveMapping):
        target.update()


def _copy_items(source, target) -> None:
    """Stops of a ramp, curves and their points: as many, each with the same settings."""
    while hasattr(target, "remove") and len(target) > len(source):
        target.remove(target[-1])
    while hasattr(target, "new") and len(target) < len(source):
        item = source[len(target)]
        target.new(item.position) if hasattr(item, "position") else target.new(*item.location)
    for item, twin in zip(source, target):
        _copy_properties(item, twin)


def _copy_animation(here: bpy.types.NodeTree, there: bpy.types.NodeTree, names: dict[str, str]) -> None:
    """Drivers and keyframes of the nodes of one tree, for their copies in another or the same, by name."""
    data = here.animation_data
    if data is None:
        return
    for curve in list(data.drivers):
        if path := _renamed(curve.data_path, names):
            copy = there.animation_data_create().drivers.from_existing(src_driver=curve)
            copy.data_path = path
    tracks = [strip.action for track in data.nla_tracks for strip in track.strips]
    for action in filter(None, (data.action, *tracks)):
        for bag in [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]:
            found = [(curve, path) for curve in bag.fcurves if (path := _renamed(curve.data_path, names))]
            for curve, path in found:
                _copy_curve(curve, (bag if here == there else _channels_of(there)).fcurves, path)


def _renamed(path: str, names: dict[str, str]) -> str:
    """An animation path, for the copy of its node; empty if the path is of another node."""
    match = _NODE_PATH.match(path)
    name = names.get(bpy.utils.unescape_identifier(match[1])) if match else None
    return f'nodes["{bpy.utils.escape_identifier(name)}"]{match[2]}' if name else ""


def _channels_of(tree: bpy.types.NodeTree) -> bpy.types.ActionChannelbag:
    """The keyframes of a tree's own action, which is made if there is none."""
    data = tree.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new("Lamina Layers")
    if data.action_slot is None:
        data.action_slot = data.action.slots.new("NODETREE", tree.name)
    layer = data.action.layers[0] if data.action.layers else data.action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(data.action_slot, ensure=True)


def _copy_curve(source: bpy.types.FCurve, curves, path: str) -> None:
    # Blender 4.5 has no call that copies a curve
    copy = curves.new(path, index=source.array_index)
    copy.extrapolation, copy.mute = source.extrapolation, source.mute
    copy.keyframe_points.add(len(source.keyframe_points))
    for key, twin in zip(source.keyframe_points, copy.keyframe_points):
        twin.co = key.co
        for name in _KEY_PROPERTIES:
            setattr(twin, name, getattr(key, name))
    for modifier in source.modifiers:
        twin = copy.modifiers[0] if copy.modifiers and modifier == source.modifiers[0] else copy.modifiers.new(modifier.type)
        _copy_properties(modifier, twin)
    copy.update()
