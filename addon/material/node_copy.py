# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of what feeds a layer's node: values, textures with all that is before them, drivers and keyframes."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import bpy

from .kind_groups import KIND_KEY

_NODE_PATH = re.compile(r'nodes\["(.*?)"\](.*)')
_INPUT_PATH = re.compile(r"\.inputs\[(\d+)\](.*)")
_KEY_PROPERTIES = (
    "interpolation", "easing", "amplitude", "back", "period", "type",
    "handle_left_type", "handle_right_type", "handle_left", "handle_right",
)  # fmt: skip


def copy_inputs(source: bpy.types.Node, target: bpy.types.Node) -> list[str]:
    """Give a node the inputs of another, as far as it has them by name, in the same material or another one.

    In the same one textures are shared, in another one their nodes are copied. Returns one sentence for each thing that
    cannot come along.
    """
    for socket in source.inputs:
        twin = target.inputs.get(socket.name)
        if twin is not None and hasattr(socket, "default_value"):
            twin.default_value = socket.default_value
    return copy_sources(source, target)


def copy_sources(source: bpy.types.Node, target: bpy.types.Node) -> list[str]:
    """The same without the values: textures, drivers and keyframes."""
    here, there = source.id_data, target.id_data
    notes: list[str] = []
    copies = {source.name: target}
    places: dict[int, int] = {}
    for place, socket in enumerate(source.inputs):
        twin = target.inputs.get(socket.name)
        if twin is None:
            continue
        places[place] = list(target.inputs).index(twin)
        for link in socket.links:
            if link.from_node.type == "GROUP" and link.from_node.node_tree is not None and KIND_KEY in link.from_node.node_tree:
                if here != there:
                    notes.append(f"{source.label}: {socket.name} was linked to another layer; the link stays behind")
                    continue
            origin = link.from_node if here == there else _copied(link.from_node, there, copies)
            made = there.links.new(_output_of(origin, link.from_socket), twin)
            made.is_muted = link.is_muted
    if here != there:
        for number, (name, node) in enumerate(list(copies.items())[1:], 1):
            node.location = (target.location_absolute.x - 240 * number, target.location_absolute.y)
    names = {name: node.name for name, node in copies.items()}
    notes += _copy_animation(here, there, lambda path: _renamed(path, names, {source.name: places}), source.label)
    return notes


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


@contextmanager
def animation_by_name(node: bpy.types.Node) -> Iterator[None]:
    """While the block changes which inputs a node has, or in which order, what animates them follows their names.

    Blender 4.5 leaves the paths as they are, and 5.2 follows the identifiers, which differ from group to group.
    """
    data, names = node.id_data.animation_data, [socket.name for socket in node.inputs]
    curves = [] if data is None else [*data.drivers, *(curve for bag in channel_bags(data) for curve in bag.fcurves)]
    found = []
    for curve in curves:
        match = _NODE_PATH.match(curve.data_path)
        place = _INPUT_PATH.match(match[2]) if match and bpy.utils.unescape_identifier(match[1]) == node.name else None
        if place and int(place[1]) < len(names):
            found.append((curve, names[int(place[1])], place[2]))
    yield
    for curve, name, rest in found:
        if name in node.inputs and curve.data_path != (path := f"{node.inputs[name].path_from_id()}{rest}"):
            curve.data_path = path


def own_actions(tree: bpy.types.NodeTree) -> None:
    """Give a copied tree copies of the actions that it shares: a node that is removed takes its curves out of them."""
    data = tree.animation_data
    if data is None:
        return
    for holder in (data, *(strip for track in data.nla_tracks for strip in track.strips)):
        if holder.action is not None:
            handle = holder.action_slot.handle if holder.action_slot else None
            holder.action = holder.action.copy()
            holder.action_slot = next((slot for slot in holder.action.slots if slot.handle == handle), None)


def channel_bags(data: bpy.types.AnimData) -> Iterator[bpy.types.ActionChannelbag]:
    """The keyframes of one owner: those of its action and of its NLA strips, without other owners' in the same actions."""
    used = [(data.action, data.action_slot)] + [(s.action, s.action_slot) for track in data.nla_tracks for s in track.strips]
    for action, slot in dict.fromkeys((a, s) for a, s in used if a is not None and s is not None):
        yield from (bag for layer in action.layers for strip in layer.strips if (bag := strip.channelbag(slot)) is not None)


def _copy_animation(here: bpy.types.NodeTree, there: bpy.types.NodeTree, renamed: Callable[[str], str], label: str) -> list[str]:
    """Drivers and keyframes of one tree, for copies of its nodes in another or the same; `renamed` gives a path for them.

    NLA strips of another material stay behind, and one sentence says so.
    """
    data = here.animation_data
    if data is None:
        return []
    for curve in list(data.drivers):
        if path := renamed(curve.data_path):
            copy = there.animation_data_create().drivers.from_existing(src_driver=curve)
            copy.data_path = path
    own = (
        []
        if data.action is None or data.action_slot is None
        else [bag for layer in data.action.layers for strip in layer.strips if (bag := strip.channelbag(data.action_slot)) is not None]
    )
    left = False
    for bag in channel_bags(data):
        found = [(curve, path) for curve in bag.fcurves if (path := renamed(curve.data_path))]
        if here != there and bag not in own:
            left |= bool(found)
            continue
        for curve, path in found:
            _copy_curve(curve, (bag if here == there else _channels_of(there)).fcurves, path)
    return [f"{label}: its NLA strips stay behind"] if left else []


def _renamed(path: str, names: Mapping[str, str], places: Mapping[str, Mapping[int, int]]) -> str:
    """An animation path, for the copy of its node, and of its input where `places` has its node's.

    Empty if the path is of another node, or of an input that the copy has not.
    """
    match = _NODE_PATH.match(path)
    node = bpy.utils.unescape_identifier(match[1]) if match else None
    if node not in names:
        return ""
    rest = match[2]
    if node in places and (socket := _INPUT_PATH.match(rest)):
        place = places[node].get(int(socket[1]))
        if place is None:
            return ""
        rest = f".inputs[{place}]{socket[2]}"
    return f'nodes["{bpy.utils.escape_identifier(names[node])}"]{rest}'


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
