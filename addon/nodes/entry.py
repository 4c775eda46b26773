# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a first Lamina shader enters a material: the surface, or the branch of the user's own mix that was the body."""

import bpy

_MIXES = ("ShaderNodeMixShader", "ShaderNodeAddShader")
# What users mix with a body: the body is not among them.
_EFFECTS = ("ShaderNodeEmission", "ShaderNodeBsdfTransparent", "ShaderNodeHoldout", "ShaderNodeBackground", "ShaderNodeVolumeAbsorption", "ShaderNodeVolumeScatter", "ShaderNodeVolumePrincipled")
_PRINCIPLED = "ShaderNodeBsdfPrincipled"


def entry_of(tree: bpy.types.NodeTree) -> list[bpy.types.NodeSocket]:
    """The sockets that a first shader feeds, as a list of one. An untouched Principled node there, as in every new material, goes.

    Mix and Add Shader nodes of the user stay; in them the first Principled's place is taken, else that of the first
    other closure that is no effect (emission, transparency), else all that the surface shows.
    """
    output = surface_output(tree) or tree.nodes.new("ShaderNodeOutputMaterial")
    bodies = list(_bodies(output.inputs["Surface"], set()))
    principled = [socket for socket in bodies if socket.links[0].from_node.bl_idname == _PRINCIPLED]
    target = (principled or bodies or [output.inputs["Surface"]])[0]
    former = target.links[0].from_node if target.is_linked else None
    if former is not None and former.bl_idname == _PRINCIPLED and _is_alone(former, target):
        tree.nodes.remove(former)
    return [target]


def surface_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The output that every renderer sees unless it has one of its own; of several the active one."""
    outputs = [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial" and node.target == "ALL"]
    return next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)


def _bodies(socket, seen: set[str]):
    """Sockets at or before one that a closure feeds which may be a body, in order."""
    for link in socket.links:
        node = link.from_node
        if node.bl_idname not in _MIXES:
            if node.bl_idname not in _EFFECTS:
                yield socket
        elif node.name not in seen:
            seen.add(node.name)
            for each in node.inputs:
                if each.type == "SHADER":
                    yield from _bodies(each, seen)


def _is_alone(node, target) -> bool:
    links = [link for socket in (*node.inputs, *node.outputs) for link in socket.links]
    return all(link.to_socket == target for link in links)
