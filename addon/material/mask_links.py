# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks made by hand: nodes between an image, or whatever feeds a layer's coverage, and the coverage. What fed it before is kept.

Several masks of a layer are multiplied: the layer is where all of them say so.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.material.schema import COVERAGE
from .elements import node_of
from .material import changing
from .reading import require_layered

# What a node between a mask and a coverage does, so that it is found again.
LINK = "lamina_mask"
_IMAGE, _JOIN, _INVERT, _RAMP = "image", "join", "invert", "ramp"
_LABELS = {_IMAGE: "Painted Mask", _JOIN: "Masks", _INVERT: "Inverted", _RAMP: "Ramp"}
_TYPES = {_IMAGE: "ShaderNodeTexImage", _JOIN: "ShaderNodeMath", _INVERT: "ShaderNodeMath", _RAMP: "ShaderNodeValToRGB"}
_APART = 200


def new_image_mask(material: bpy.types.Material, index: int, size: int) -> bpy.types.Image:
    """Feed a layer's coverage by a new white image of size x size pixels, on top of what feeds it already."""
    with _changing_masks(material) as tree:
        layer = material.lamina.layers[index]
        layer.use_coverage = True
        socket = _coverage(layer)
        image = bpy.data.images.new(f"{layer.name} Mask", size, size, alpha=False)
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(np.ones(4 * size * size, np.float32))
        image.update()
        image.pack()  # kept with the file; Blender packs nothing of a generated image whose pixels nobody wrote
        node = _new(tree, _IMAGE, socket)
        node.image = image
        if not socket.is_linked:
            tree.links.new(node.outputs["Color"], socket)
        else:
            join = _between(tree, _JOIN, socket)
            join.operation = "MULTIPLY"
            tree.links.new(node.outputs["Color"], join.inputs[1])
    return image


def invert_mask(material: bpy.types.Material, index: int) -> None:
    """Let a layer be where it was not; twice is as before. Raises LaminaError where there is no mask."""
    with _changing_masks(material) as tree:
        socket = _masked(material.lamina.layers[index])
        link = socket.links[0]
        if link.from_node.get(LINK) == _INVERT and link.from_node.inputs[1].is_linked:
            former = link.from_node
            tree.links.new(former.inputs[1].links[0].from_socket, socket)
            tree.nodes.remove(former)
            return
        node = _between(tree, _INVERT, socket, 1)
        node.operation, node.inputs[0].default_value = "SUBTRACT", 1.0


def ramp_mask(material: bpy.types.Material, index: int) -> bpy.types.Node:
    """A ramp of grays between a layer's mask and its coverage, the one that is there or a new one. Raises LaminaError where there is no mask."""
    with _changing_masks(material) as tree:
        socket = _masked(material.lamina.layers[index])
        found = ramp_of(material.lamina.layers[index])
        return found if found is not None else _between(tree, _RAMP, socket)


def ramp_of(layer) -> bpy.types.Node | None:
    """The ramp that is the last node before a layer's coverage."""
    return next((link.from_node for link in _coverage(layer).links if link.from_node.get(LINK) == _RAMP), None)


def image_of(layer) -> bpy.types.Image | None:
    """The image that was put on a layer's coverage last, past what was put between."""
    sockets = [_coverage(layer)]
    while sockets:
        link = next(iter(sockets.pop(0).links), None)
        if link is None:
            continue
        node = link.from_node
        if node.bl_idname == _TYPES[_IMAGE]:
            return node.image
        if LINK in node:
            sockets += reversed(node.inputs)  # of a join, the upper mask is the second
    return None


def _coverage(layer) -> bpy.types.NodeSocket:
    return node_of(layer).inputs[COVERAGE.parameters[0].label]


def _masked(layer) -> bpy.types.NodeSocket:
    socket = _coverage(layer)
    if not layer.use_coverage or not socket.is_linked:
        raise LaminaError("{layer} has no mask; add one first", layer=layer.name)
    return socket


def _new(tree, what: str, socket) -> bpy.types.Node:
    node = tree.nodes.new(_TYPES[what])
    node[LINK], node.label, node.select = what, _LABELS[what], False
    node.location = socket.node.location_absolute.x - _APART * (1 + sum(LINK in n for n in tree.nodes)), socket.node.location_absolute.y
    return node


def _between(tree, what: str, socket, place: int = 0) -> bpy.types.Node:
    """A node between a socket and what feeds it."""
    source = socket.links[0].from_socket
    node = _new(tree, what, socket)
    tree.links.new(source, node.inputs[place])
    tree.links.new(node.outputs[0], socket)
    return node


@contextmanager
def _changing_masks(material: bpy.types.Material) -> Iterator[bpy.types.NodeTree]:
    """As `changing`; on an error the nodes that were made go too, and links are as before."""
    require_layered(material)
    before = {node.name for node in material.node_tree.nodes}
    links = [(link.from_socket, link.to_socket) for link in material.node_tree.links]
    try:
        with changing(material) as tree:
            yield tree
    except Exception:
        for node in [node for node in material.node_tree.nodes if LINK in node and node.name not in before]:
            if getattr(node, "image", None) is not None:
                bpy.data.images.remove(node.image)
            material.node_tree.nodes.remove(node)
        for source, target in links:
            if not target.is_linked:
                material.node_tree.links.new(source, target)
        raise
