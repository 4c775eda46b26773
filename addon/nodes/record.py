# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of a material's structure and values in its node tree: Blender's Copy and Paste Material takes trees, not properties.

It also is where a layer's values come from when somebody deleted its node.
"""

import json

import bpy

from .elements import find_node
from .properties import quietly
from .snapshot import restore, snapshot

KEY = "lamina_record"


def keep_record(material: bpy.types.Material) -> None:
    """Write down the structure, and each element's values and links by its node's id; of a deleted node the former ones stay."""
    lamina, former = material.lamina, _read(material).get("elements", {})
    elements = {}
    for element in (*lamina.layers, lamina.base):
        node = find_node(element)
        if node is None:
            elements[element.node] = former.get(element.node, {})
            continue
        links = {s.name: [s.links[0].from_node.name, s.links[0].from_socket.identifier] for s in node.inputs if s.is_linked}
        values = {s.name: _plain(s.default_value) for s in node.inputs if hasattr(s, "default_value")}
        elements[element.node] = {"values": values, "links": links}
    text = json.dumps({"structure": snapshot(lamina), "elements": elements})
    if material.node_tree.get(KEY) != text:
        material.node_tree[KEY] = text


def keep_structure(material: bpy.types.Material) -> None:
    """Write down the structure alone, where values stay those that the stock nodes show."""
    if data := _read(material):
        material.node_tree[KEY] = json.dumps(data | {"structure": snapshot(material.lamina)})


def drop_record(material: bpy.types.Material) -> None:
    """Forget the structure of a material that is Lamina's no more."""
    if KEY in material.node_tree:
        del material.node_tree[KEY]


def recorded(element) -> dict:
    """The recorded values {socket: value} and links {socket: [node, identifier]} of an element; empty where none are."""
    return _read(element.id_data).get("elements", {}).get(element.node, {})


def give_recorded(element, node: bpy.types.Node) -> None:
    """Set a new node of an element to what is recorded of the former one, its links to nodes that are still there too."""
    tree, found = node.id_data, recorded(element)
    for name, value in found.get("values", {}).items():
        if name in node.inputs:
            node.inputs[name].default_value = value
    for name, (source, identifier) in found.get("links", {}).items():
        origin = tree.nodes.get(source)
        socket = next((s for s in origin.outputs if s.identifier == identifier), None) if origin is not None else None
        if socket is not None and name in node.inputs:
            tree.links.new(socket, node.inputs[name])


def changed_values(material: bpy.types.Material) -> list[str]:
    """Names of the values, with their layer, that differ from the recorded ones."""
    names = []
    for element in (*material.lamina.shown_layers, material.lamina.base):
        node, former = find_node(element), recorded(element).get("values", {})
        if node is not None:
            names += [f"{element.name}: {s.name}" for s in node.inputs if s.name in former and _plain(s.default_value) != former[s.name]]
    return names


def adopt_pasted(material: bpy.types.Material) -> bool:
    """Make the properties of a material those of its node tree, after Blender's Paste Material; whether there was anything to do."""
    lamina, tree = material.lamina, material.node_tree
    if tree is None or material.library is not None or material.override_library is not None:
        return False
    own = [element.node for element in (*lamina.layers, lamina.base) if element.node]
    if KEY not in tree:
        # a plain material was pasted over layers: older files have no record, and so their nodes
        if lamina.is_layered and lamina.schema_version > 2 and not any(find_node(e) for e in (*lamina.layers, lamina.base)):
            material.property_unset("lamina")
            return True
        return False
    data = _read(material)
    if not data or list(data["elements"]) == own:
        return False
    if not all(node in tree.nodes for node in data["elements"]) or any(node in tree.nodes for node in own):
        return False
    with quietly():
        restore(lamina, data["structure"])
    return True


def _read(material) -> dict:
    try:
        data = json.loads(material.node_tree.get(KEY, "{}"))
        return data if isinstance(data.get("elements"), dict) and isinstance(data.get("structure"), dict) else {}
    except (ValueError, TypeError, AttributeError):
        return {}


def _plain(value):
    return value if isinstance(value, (int, float, bool, str)) else list(value)
