# SPDX-License-Identifier: GPL-3.0-or-later
"""The output at which EEVEE alone finds stock nodes with weights of its own; all else, exporters too, finds the output for all renderers.

There is one only where Lamina's surface is all that an output shows: what a user mixes in has to show in EEVEE too.
"""

import bpy

from ..shader.nodes.node_groups import drop_group
from .roles import EEVEE, EEVEE_OUTPUT, ROLE, node_with

_OUTPUT = "ShaderNodeOutputMaterial"
_BELOW = 200


def follow_eevee_output(material: bpy.types.Material, surface: bpy.types.NodeSocket) -> None:
    """Make EEVEE's output, or bring it up to the output that `surface` feeds; without such an output it goes, and its stock nodes too."""
    tree, group, own = material.node_tree, node_with(material, EEVEE), node_with(material, EEVEE_OUTPUT)
    shown = _output_of(tree, surface)
    if group is None or shown is None:
        for node in filter(None, (group, own)):
            tree_of_group = getattr(node, "node_tree", None)
            tree.nodes.remove(node)
            drop_group(tree_of_group)
        return
    if own is None:
        active = [node for node in tree.nodes if node.bl_idname == _OUTPUT and node.is_active_output]
        own = tree.nodes.new(_OUTPUT)
        own[ROLE], own.target, own.name, own.hide, own.select = EEVEE_OUTPUT, "EEVEE", "Lamina EEVEE Output", True, False
        own.label, own.location = "Lamina EEVEE", (shown.location_absolute.x, shown.location_absolute.y - _BELOW)
        for node in active:
            node.is_active_output = True
    for name, source in _wanted(shown, group).items():
        socket = own.inputs[name]
        if source is not None and _source(socket) != source:
            tree.links.new(source, socket)
        elif source is None and socket.is_linked:
            tree.links.remove(socket.links[0])


def is_off(material: bpy.types.Material, surface: bpy.types.NodeSocket | None) -> bool:
    """Whether EEVEE's output shows what the output for all renderers does not, as a user changed that one since."""
    own, group = node_with(material, EEVEE_OUTPUT), node_with(material, EEVEE)
    if own is None or surface is None:
        return False
    shown = _output_of(material.node_tree, surface)
    return group is None or shown is None or any(_source(own.inputs[name]) != source for name, source in _wanted(shown, group).items())


def _output_of(tree: bpy.types.NodeTree, surface: bpy.types.NodeSocket) -> bpy.types.Node | None:
    """The output for all renderers that shows a surface and nothing else, where it is the one that EEVEE would show."""
    targets = [link.to_socket for link in surface.links]
    outputs = [node for node in tree.nodes if node.bl_idname == _OUTPUT and node.get(ROLE) != EEVEE_OUTPUT]
    if len(targets) != 1 or targets[0].node not in outputs or targets[0].name != "Surface" or targets[0].links[0].is_muted:
        return None
    others = [node for node in outputs if node.target == "EEVEE" or node.target == "ALL" and node.is_active_output]
    return targets[0].node if others in ([], [targets[0].node]) and targets[0].node.target == "ALL" else None


def _wanted(shown: bpy.types.Node, group: bpy.types.Node) -> dict[str, bpy.types.NodeSocket | None]:
    return {socket.name: group.outputs["BSDF"] if socket.name == "Surface" else _source(socket) for socket in shown.inputs}


def _source(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    return socket.links[0].from_socket if socket.is_linked else None
