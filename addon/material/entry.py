# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a first Lamina shader enters a material: the surface, or the branch of the user's own mix that was the body."""

from collections.abc import Iterator
from dataclasses import dataclass

import bpy

from .roles import ROLE

_MIXES = ("ShaderNodeMixShader", "ShaderNodeAddShader")
# What users mix with a body: the body is not among them.
_EFFECTS = (
    "ShaderNodeEmission", "ShaderNodeBsdfTransparent", "ShaderNodeHoldout", "ShaderNodeBackground", "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumeScatter", "ShaderNodeVolumePrincipled",
)  # fmt: skip
_PRINCIPLED = "ShaderNodeBsdfPrincipled"


@dataclass(frozen=True)
class Entry:
    """The sockets that a first shader feeds, all that one node feeds now, which gives way, and how many bodies the user mixes."""

    sockets: tuple[bpy.types.NodeSocket, ...] = ()
    former: bpy.types.Node | None = None
    bodies: int = 0

    @property
    def is_mixed(self) -> bool:
        """Whether a mix of the user's stays around what enters."""
        return any(socket.node.bl_idname != "ShaderNodeOutputMaterial" for socket in self.sockets)


def find_entry(output: bpy.types.Node | None) -> Entry:
    """Where a first shader would enter before an output; no sockets where there is none.

    Mix and Add Shader nodes of the user stay; in them the first Principled gives way, else the first other closure that is
    no effect (emission, transparency); an input that is free is taken where there are only effects, else the whole surface.
    """
    if output is None:
        return Entry()
    surface = output.inputs["Surface"]
    found = list(_leaves(surface, set()))
    bodies = [(socket, node) for socket, node in found if node is not None and node.bl_idname not in _EFFECTS]
    if bodies:
        former = next((node for _, node in bodies if node.bl_idname == _PRINCIPLED), bodies[0][1])
        return Entry(tuple(socket for socket, node in bodies if node == former), former, len({node.name for _, node in bodies}))
    free = next((socket for socket, node in found if node is None), None)
    if free is not None:
        return Entry((free,))
    return Entry((surface,), surface.links[0].from_node if surface.is_linked else None)


def entry_of(tree: bpy.types.NodeTree) -> tuple[bpy.types.NodeSocket, ...]:
    """The sockets that a first shader feeds; an output is made if there is none. A Principled node that fed nothing else, as in every new material, goes."""
    found = find_entry(surface_output(tree))
    sockets = found.sockets or (tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"],)
    if found.former is not None and found.former.bl_idname == _PRINCIPLED and _is_alone(found.former, sockets):
        tree.nodes.remove(found.former)
    return sockets


def surface_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The output that every renderer sees unless it has one of its own; of several the active one."""
    outputs = _outputs(tree)
    return next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)


def output_after(node: bpy.types.Node) -> bpy.types.Node | None:
    """The output for all renderers that a node feeds, the last one of several."""
    return next((output for output in reversed(_outputs(node.id_data)) if feeds(node, output)), None)


def feeds(node: bpy.types.Node, follower: bpy.types.Node) -> bool:
    """Whether a node feeds another, over any number of nodes."""
    return _is_before(node, follower, set())


def _is_before(node, follower, seen: set[str]) -> bool:
    seen.add(node.name)
    after = [link.to_node for socket in node.outputs for link in socket.links]
    return any(n == follower or (n.name not in seen and _is_before(n, follower, seen)) for n in after)


def _outputs(tree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial" and node.target == "ALL"]


def _leaves(socket, seen: set[str]) -> Iterator[tuple[bpy.types.NodeSocket, bpy.types.Node | None]]:
    """The sockets at or before one where the user's mixes end, in order, each with the node that feeds it; None for a free one."""
    link = next((link for link in socket.links if not link.is_muted), None)
    node = link.from_node if link is not None else None
    passes = node is not None and ROLE not in node and node.bl_idname in (*_MIXES, "NodeReroute")
    if not passes:
        yield socket, node
    elif node.name not in seen:
        seen.add(node.name)
        before = [way.from_socket for way in node.internal_links] if node.mute else node.inputs
        for each in before:
            if each.type == "SHADER":
                yield from _leaves(each, seen)


def _is_alone(node, sockets) -> bool:
    links = [link for socket in (*node.inputs, *node.outputs) for link in socket.links]
    return all(link.to_socket in sockets for link in links)
