# SPDX-License-Identifier: GPL-3.0-or-later
"""Which node of a material is what: a custom property says it, which renaming and Blender's Copy and Paste leave alone."""

import bpy

from .backend import NODES, OSL

ROLE = "lamina_role"
# The Mix Shader over both branches; the branches themselves have the names of their backends.
SWITCH = "switch"
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
    """Schema 1 and 2 had one shader node and named it."""
    node = material.node_tree.nodes.get(material.lamina.shader_node)
    return node if node is not None and node.bl_idname == _TYPES.get(role) and ROLE not in node else None
