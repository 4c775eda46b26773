# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that are found by what they are for, whatever they are called: a property of the node survives renaming and Blender's Paste Material."""

import bpy
import numpy as np

ROLE = "lamina_role"


class Roles:
    """Lamina's nodes in one tree by role. Blender looks through the whole tree after each change, so only what differs is set."""

    def __init__(self, tree: bpy.types.NodeTree):
        self.tree = tree
        self._nodes: dict[str, bpy.types.Node] = {}
        for node in tree.nodes:
            if role := node.get(ROLE):
                self._nodes.setdefault(role, node)  # copies by the user's hand come later
        # every `socket.links` would look through all links of the tree
        self._into = {link.to_socket.as_pointer(): link for link in tree.links}

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
    """Set a socket's value where it differs; sockets hold float32. A color gets its alpha."""
    value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
    if not np.array_equal(np.asarray(socket.default_value, np.float32), np.asarray(value, np.float32)):
        socket.default_value = value
