# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing node trees as expressions: operands are sockets, which get linked, or numbers, which get set."""

import math
import operator
from collections.abc import Sequence

import bpy

_COLUMN, _ROW = 200, 260
_ARITHMETIC = {
    "SQRT": math.sqrt,
    "MULTIPLY": operator.mul,
    "DIVIDE": operator.truediv,
    "SUBTRACT": operator.sub,
    "MAXIMUM": max,
    "MINIMUM": min,
}


class Builder:
    """Makes nodes in one tree."""

    def __init__(self, tree: bpy.types.NodeTree):
        self._tree = tree

    def node(self, kind: str) -> bpy.types.Node:
        node = self._tree.nodes.new(kind)
        node.select = False
        return node

    def link(self, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
        self._tree.links.new(source, target)

    def math(self, operation: str, *operands):
        """A Math node's output, or a number where all operands are numbers."""
        if not any(isinstance(operand, bpy.types.NodeSocket) for operand in operands):
            return _ARITHMETIC[operation](*operands)
        node = self.node("ShaderNodeMath")
        node.operation = operation
        for socket, operand in zip(node.inputs, operands):
            self._give(operand, socket)
        return node.outputs["Value"]

    def vector(self, operation: str, *operands, scale=None) -> bpy.types.NodeSocket:
        """A Vector Math node; a single number stands for three of them."""
        node = self.node("ShaderNodeVectorMath")
        node.operation = operation
        for socket, operand in zip(node.inputs, operands):
            self._give((operand,) * 3 if isinstance(operand, float) else operand, socket)
        if scale is not None:
            self._give(scale, node.inputs["Scale"])
        return next(socket for socket in node.outputs if socket.enabled)

    def combined(self, operands):
        """Three numbers as a vector's output, or as a tuple where none is a socket."""
        if not any(isinstance(operand, bpy.types.NodeSocket) for operand in operands):
            return tuple(operands)
        if all(operand is operands[0] for operand in operands):
            return operands[0]  # a number's socket gives all three
        node = self.node("ShaderNodeCombineXYZ")
        for socket, operand in zip(node.inputs, operands):
            self._give(operand, socket)
        return node.outputs["Vector"]

    def shader(self, kind: str, *operands, settings: dict[str, str] | None = None, **named) -> bpy.types.NodeSocket:
        """A shader node, its inputs given in order or by name."""
        node = self.node(kind)
        for setting, choice in (settings or {}).items():
            setattr(node, setting, choice)
        for socket, operand in zip(node.inputs, operands):
            self._give(operand, socket)
        for name, operand in named.items():
            self._give(operand, node.inputs[name])
        return node.outputs[0]

    def sum(self, closures: Sequence[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
        """All closures added."""
        head, *tail = closures
        return self.shader("ShaderNodeAddShader", head, self.sum(tail)) if tail else head

    def _give(self, operand, socket) -> None:
        if isinstance(operand, bpy.types.NodeSocket):
            self.link(operand, socket)
        else:
            socket.default_value = operand

    def arrange(self) -> None:
        """Columns by how many nodes come before; rows in the order of making."""
        sources: dict[str, set[str]] = {node.name: set() for node in self._tree.nodes}
        for link in self._tree.links:
            sources[link.to_node.name].add(link.from_node.name)
        depth: dict[str, int] = {}

        def depth_of(name: str) -> int:
            if name not in depth:
                depth[name] = 1 + max(map(depth_of, sources[name]), default=-1)
            return depth[name]

        rows: dict[int, int] = {}
        places = []
        for node in self._tree.nodes:
            column = depth_of(node.name)
            places += (_COLUMN * column, -_ROW * rows.get(column, 0))
            rows[column] = rows.get(column, 0) + 1
        self._tree.nodes.foreach_set("location", places)
