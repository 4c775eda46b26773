# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Paste Material, which replaces a node tree and no properties, and clears what the tree uses and this file has not."""

import bpy

from ...reference_py.errors import LaminaError
from .backend import NODES, OSL
from .elements import find_node, kind_of
from .kind_groups import KIND_KEY, group_key, group_of
from .marks import is_of_another
from .material import refresh
from .reading import is_own
from .record import give_recorded, take_structure
from .roles import node_with


def adopt_pasted(material: bpy.types.Material) -> None:
    """Make a material that Blender pasted onto another what it was, or a plain one plain. Others are left alone."""
    if not is_of_another(material) or not is_own(material):
        return
    lamina = material.lamina
    if not take_structure(material):
        # where the nodes are there, somebody deleted the copy alone, which the next change makes anew
        if not any(find_node(element) for element in (*lamina.layers, lamina.base)):
            material.property_unset("lamina")
        return
    lamina.keep_problem(None)
    try:
        _bring_back_groups(material)
    except LaminaError as error:
        lamina.keep_problem(error)
        print(f"Lamina: {error}")


def _bring_back_groups(material) -> None:
    """Groups and texts that this file has not, or has others by their names: Blender looks for names. Values are the recorded ones."""
    lamina = material.lamina
    nodes = [(element, find_node(element)) for element in (*lamina.layers, lamina.base)]
    emptied = [(e, n) for e, n in nodes if n is not None and (n.node_tree is None or n.node_tree.get(KIND_KEY) != group_key(kind_of(e)))]
    for element, node in emptied:
        node.node_tree = group_of(kind_of(element))
        give_recorded(element, node)
    script, stock = node_with(material, OSL), node_with(material, NODES)
    if emptied or (script is not None and script.script is None) or (stock is not None and stock.node_tree is None):
        refresh(material)
