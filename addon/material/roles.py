# SPDX-License-Identifier: GPL-3.0-or-later
"""Which node of a material is what: a custom property says it, which renaming and Blender's Copy and Paste leave alone."""

import bpy
import numpy as np

from ..shader.nodes.node_groups import GROUP_KEY
from ..shader.working_space import into_working
from .backend import NODES, OSL

ROLE = "lamina_role"
# The Mix Shader over both branches, and what asks whether the script runs; the branches themselves have the names of their backends.
SWITCH, TEST = "switch", "test"
# The stock nodes with EEVEE's own weights, and the output that shows them there alone.
EEVEE, EEVEE_OUTPUT = "eevee", "eevee output"
# The frames around the nodes of layers, and around the shader.
LAYERS_FRAME, SHADER_FRAME = "layers frame", "shader frame"
_TYPES = {OSL: "ShaderNodeScript", NODES: "ShaderNodeGroup"}


def node_with(material: bpy.types.Material, role: str) -> bpy.types.Node | None:
    """The material's node of a role; of copies the one that is linked. None where there is none."""
    tree = material.node_tree
    if tree is None:
        return None
    found = [node for node in tree.nodes if node.get(ROLE) == role]
    if not found:
        return _of_older_file(material, role)
    return next((node for node in found if any(socket.is_linked for socket in node.outputs)), found[0])


def _of_older_file(material, role: str) -> bpy.types.Node | None:
    """Schema 1 and 2 had one shader node and named it. A script goes before stock nodes, which were EEVEE's where there is one."""
    name, nodes = material.lamina.shader_node, material.node_tree.nodes
    if not name:
        return None
    made = sorted((node for node in nodes if ROLE not in node and _is_made(node)), key=lambda node: node.bl_idname == _TYPES[NODES])
    node = nodes.get(name) or next(iter(made), None)
    return node if node is not None and node.bl_idname == _TYPES.get(role) and ROLE not in node else None


def _is_made(node) -> bool:
    """Whether a node's code is generated, whatever somebody named it."""
    if node.bl_idname == _TYPES[OSL]:
        return node.script is not None and "\nshader lamina_" in node.script.as_string()
    return node.bl_idname == _TYPES[NODES] and node.node_tree is not None and GROUP_KEY in node.node_tree


class Roles:
    """Lamina's nodes in one tree by role. Blender looks through the whole tree after each change, so only what differs is set."""

    def __init__(self, tree: bpy.types.NodeTree):
        self.tree = tree
        # every `socket.links` would look through all links of the tree
        self._into = {link.to_socket.as_pointer(): link for link in tree.links}
        feeding = {link.from_node.name for link in tree.links}
        self._nodes: dict[str, bpy.types.Node] = {}
        for node in sorted(tree.nodes, key=lambda node: node.name not in feeding):
            if role := node.get(ROLE):
                self._nodes.setdefault(role, node)  # of copies by the user's hand the one that is linked

    def get(self, role: str) -> bpy.types.Node | None:
        return self._nodes.get(role)

    def make(self, role: str, kind: str, label: str, place: tuple[float, float]) -> bpy.types.Node:
        """The node of a role, a new one where there is none."""
        node = self.get(role)
        if node is None:
            node = self._nodes[role] = self.tree.nodes.new(kind)
            node[ROLE], node.label, node.location, node.hide, node.select = role, label, place, True, False
        return node

    def remove(self, roles) -> None:
        for role in roles:
            if node := self._nodes.pop(role, None):
                self.tree.nodes.remove(node)

    def source(self, socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        """What was linked to a socket when the roles were read."""
        link = self._into.get(socket.as_pointer())
        return link.from_socket if link is not None else None

    def link(self, source: bpy.types.NodeSocket | None, socket: bpy.types.NodeSocket) -> None:
        """Let `source` feed a socket; None unlinks it."""
        former = self.source(socket)
        if source is not None and former != source:
            self._into[socket.as_pointer()] = self.tree.links.new(source, socket)
        elif source is None and former is not None:
            self.tree.links.remove(self._into.pop(socket.as_pointer()))


def give(socket: bpy.types.NodeSocket, value) -> None:
    """Set a socket's value where it differs; sockets hold float32. A color is the model's, and gets its alpha."""
    value = (*into_working(value), 1.0) if socket.type == "RGBA" and len(value) == 3 else value
    if not np.array_equal(np.asarray(socket.default_value, np.float32), np.asarray(value, np.float32)):
        socket.default_value = value
