# SPDX-License-Identifier: GPL-3.0-or-later
"""Which materials concern Lamina: cheap to ask of every material of a file after each change, and without the rest of Lamina."""

import bpy

# Of a node tree and of the material's properties: a hash of the record (`record`), the same unless the tree was pasted.
STAMP = "lamina_stamp"


def is_of_another(material: bpy.types.Material) -> bool:
    """Whether the node tree is not the one that the properties were made with."""
    tree = material.node_tree
    return tree is not None and tree.get(STAMP, "") != material.lamina.stamp


def concern_us() -> bool:
    """Whether the file has a material with a stack, or one that was pasted."""
    return any(material.lamina.is_layered or is_of_another(material) for material in bpy.data.materials)
