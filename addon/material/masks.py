# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks in a material: nodes of the generators' groups, which feed values of layers. A link of the user's is never replaced."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.material.masks import GENERATORS, KEY, Mask, can_be_masked, generator_of, masks_of
from ...reference_py.material.schema import COVERAGE
from ...reference_py.material.stack import Base, Layer
from .elements import kind_of, node_of, read_element, use_of
from .mask_groups import BAKED, MASK_KEY, OUTPUT, USE_BAKED, mask_group
from .source_mean import source_of_socket

_LEFT, _ROW = 260, 200
# How much rougher than before a surface is where a new mask is.
_CONTRAST = 0.4


def give_masks(tree: bpy.types.NodeTree, elements: Sequence, sources: Sequence[Layer | Base]) -> None:
    """Feed the values of elements by the masks of what they were made from; values that are linked stay linked."""
    for element, source in zip(elements, sources):
        for name, mask in source.masks.items():
            socket = node_of(element).inputs[kind_of(element).parameter(name).label]
            if not socket.is_linked:
                _feed(tree, socket, mask)


def add_mask(tree: bpy.types.NodeTree, element, name: str, generator: str) -> None:
    """Feed a value of an element by a generator with its own values. Raises LaminaError for what takes none, or is linked already."""
    kind = kind_of(element)
    feature = next((f for f in kind.features if name in [p.name for p in f.parameters]), None)
    if feature is not None and not getattr(element, use_of(feature)):
        setattr(element, use_of(feature), True)
    mask = masks_of({name: {"generator": generator}}, kind.sockets, element.name)[name]
    socket = node_of(element).inputs[kind.parameter(name).label]
    if socket.is_linked:
        raise LaminaError("{element}: {socket} has a link already; remove it first, or choose another value", element=element.name, socket=socket.name)
    if name != COVERAGE.parameters[0].name:  # the value stays where the mask is not
        low = socket.default_value
        mask = replace(mask, values={**mask.values, "low": low, "high": min(low + _CONTRAST, 1.0)})
    _feed(tree, socket, mask)


def _feed(tree, socket: bpy.types.NodeSocket, mask: Mask) -> None:
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = mask_group(mask.generator)
    node.label, node.select, node.hide = mask.generator.label, False, True
    for parameter in mask.generator.parameters:
        node.inputs[parameter.label].default_value = mask.values[parameter.name]
    tree.links.new(node.outputs[OUTPUT], socket)


def mask_node(socket: bpy.types.NodeSocket) -> bpy.types.Node | None:
    """The generator's node that feeds a value; None where none does."""
    source = source_of_socket(socket)
    return source.node if source is not None and is_mask(source.node) else None


def is_mask(node: bpy.types.Node) -> bool:
    """Whether a node is one of a generator's group."""
    return node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None and node.node_tree.get(MASK_KEY) in GENERATORS


def read_with_masks(element) -> dict:
    """An element as JSON, see `read_element`, with the masks that its nodes hold now."""
    kind, data, found = kind_of(element), read_element(element, kind_of(element)), {}
    for parameter in kind.sockets:
        node = mask_node(node_of(element).inputs[parameter.label]) if parameter.name in data and can_be_masked(parameter) else None
        if node is not None:
            found[parameter.name] = {"generator": node.node_tree[MASK_KEY], **_values(node)}
    return {**data, KEY: found} if found else data


def _values(node) -> Mapping[str, float]:
    parameters = generator_of(node.node_tree[MASK_KEY], node.name).parameters
    held = ((p, node.inputs[p.label].default_value) for p in parameters if p.label in node.inputs)
    return {p.name: float(f"{min(max(value, p.minimum), p.maximum):.7g}") for p, value in held}


def masks_in(material: bpy.types.Material) -> list[tuple[bpy.types.PropertyGroup, bpy.types.NodeSocket, bpy.types.Node]]:
    """(element, value's socket, generator's node) of all masks of a material's layers and base."""
    lamina = material.lamina
    sockets = [(e, s) for e in (*lamina.layers, lamina.base) for s in node_of(e).inputs]
    return [(e, s, node) for e, s in sockets if (node := mask_node(s)) is not None]


def remove_with_masks(tree: bpy.types.NodeTree, names: Iterable[str]) -> None:
    """Remove nodes of values, and of their masks those that feed nothing else, with the nodes of what was baked for these."""
    nodes = [tree.nodes[name] for name in names if name in tree.nodes]
    masks = {node.name for value in nodes for socket in value.inputs if (node := mask_node(socket)) is not None}
    for node in nodes:
        tree.nodes.remove(node)
    for mask in [tree.nodes[name] for name in masks if not _feeds(tree.nodes[name])]:
        remove_baked(mask)
        tree.nodes.remove(mask)


def remove_baked(mask: bpy.types.Node) -> None:
    """Remove the nodes that give a generator what was baked for it, as far as they feed nothing else."""
    tree, left = mask.id_data, [link.from_node for link in mask.inputs[BAKED].links]
    for link in mask.inputs[BAKED].links:
        tree.links.remove(link)
    while left:
        node = left.pop()
        if not _feeds(node):
            left += [link.from_node for socket in node.inputs for link in socket.links]
            tree.nodes.remove(node)


def _feeds(node) -> bool:
    return any(socket.is_linked for socket in node.outputs)


def place_masks(node: bpy.types.Node) -> list[bpy.types.Node]:
    """Put the new masks of a value node, which lie at the origin, to its left; these masks."""
    masks = [mask for socket in node.inputs if (mask := mask_node(socket)) is not None and tuple(mask.location_absolute) == (0.0, 0.0)]
    for row, mask in enumerate(masks):
        mask.location_absolute = (node.location_absolute.x - _LEFT, node.location_absolute.y - row * _ROW)
    return masks


def show_baked(node: bpy.types.Node, is_baked: bool) -> None:
    """Let a generator show what was baked for it, or draw live."""
    node.inputs[USE_BAKED].default_value = float(is_baked)
