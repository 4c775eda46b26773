# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of a material's structure and values in its node tree: Blender's Copy and Paste Material takes trees, not properties.

Tree and properties have the same stamp, a hash of the copy, unless the tree was pasted. The copy also is where a layer's
values come from when somebody deleted its node.
"""

import hashlib
import json

import bpy
import numpy as np

from ..shader.working_space import into_working, out_of_working
from .elements import find_node
from .marks import STAMP
from .properties import quietly
from .snapshot import restore, snapshot

KEY = "lamina_record"


def keep_record(material: bpy.types.Material) -> None:
    """Write down the structure, and each element's values and links by its node's id; of a deleted node the former ones stay.

    To be called where the stock nodes show the present values, which Check compares with the recorded ones.
    """
    lamina, former = material.lamina, _read(material).get("elements", {})
    elements = {}
    for element in (*lamina.layers, lamina.base):
        node = find_node(element)
        if node is None:
            elements[element.node] = former.get(element.node, {})
            continue
        links = {s.name: [s.links[0].from_node.name, s.links[0].from_socket.identifier] for s in node.inputs if s.is_linked}
        values = {s.name: _plain(s) for s in node.inputs if hasattr(s, "default_value")}
        elements[element.node] = {"values": values, "links": links}
    _write(material, elements)


def keep_structure(material: bpy.types.Material) -> None:
    """Write down the structure alone, where values stay those that the stock nodes show."""
    if data := _read(material):
        _write(material, data["elements"])


def _write(material, elements: dict) -> None:
    structure = {name: value for name, value in snapshot(material.lamina).items() if name not in ("stamp", "packed_problem")}
    text = json.dumps({"structure": structure, "elements": elements})
    stamp = hashlib.sha256(text.encode()).hexdigest()[:16]
    for name, value in ((KEY, text), (STAMP, stamp)):
        if material.node_tree.get(name) != value:
            material.node_tree[name] = value
    if material.lamina.stamp != stamp:
        material.lamina.stamp = stamp


def drop_record(material: bpy.types.Material) -> None:
    """Forget the structure of a material that is Lamina's no more."""
    material.property_unset("lamina")
    for key in (KEY, STAMP):
        if key in material.node_tree:
            del material.node_tree[key]


def recorded(element) -> dict:
    """The recorded values {socket: value} and links {socket: [node, identifier]} of an element; empty where none are."""
    return _read(element.id_data).get("elements", {}).get(element.node, {})


def give_recorded(element, node: bpy.types.Node) -> None:
    """Set a new node of an element to what is recorded of the former one, its links to nodes that are still there too."""
    tree, found = node.id_data, recorded(element)
    for name, value in found.get("values", {}).items():
        if name in node.inputs:
            is_color = node.inputs[name].type == "RGBA"
            node.inputs[name].default_value = (*into_working(value[:3]), 1.0) if is_color else value
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
            names += [f"{element.name}: {s.name}" for s in node.inputs if s.name in former and not np.allclose(_plain(s), former[s.name], rtol=0.0, atol=1e-6)]
    return names


def take_structure(material: bpy.types.Material) -> bool:
    """Set the properties to what the node tree's copy says; whether there is one."""
    data = _read(material)
    if data:
        with quietly():
            restore(material.lamina, data["structure"])
            material.lamina.stamp = material.node_tree[STAMP]
    return bool(data)


def _read(material) -> dict:
    try:
        data = json.loads(material.node_tree.get(KEY, "{}"))
        return data if isinstance(data.get("elements"), dict) and isinstance(data.get("structure"), dict) else {}
    except (ValueError, TypeError, AttributeError):
        return {}


def _plain(socket):
    """A socket's value as JSON has it; a color as the model has it, since nobody converts what is written here."""
    if socket.type == "RGBA":
        return [float(f"{v:.7g}") for v in out_of_working(list(socket.default_value)[:3])]
    return socket.default_value if isinstance(socket.default_value, (int, float, bool, str)) else list(socket.default_value)
