# SPDX-License-Identifier: GPL-3.0-or-later
"""What EEVEE, and so the material preview, shows of a material whose shader is an OSL script: the same network in stock nodes.

EEVEE runs no scripts. So the stock nodes hang on a material output of their own, which is EEVEE's alone; Cycles takes the other.
It follows in a window, when the values rest; renders in Cycles do not change by it.
"""

import bpy

from ...reference_py.network import HOLD_VALUES, PROVISIONAL_TIER, make_network
from ..network.inputs import BASE, layer_owner
from ..network.node_groups import drop_group, network_group
from ..network.stock_nodes import group_inputs, stock_tables
from .backend import OSL
from .elements import node_of
from .material import wanted_network
from .shader_node import backend_of, tangent_owner

NODE, OUTPUT = "Lamina Preview", "Lamina Preview Output"
_KEY = "lamina_settled"
_BELOW = 300


def follow_preview(material: bpy.types.Material) -> None:
    """Make what EEVEE shows of a settled material follow its shader; none for tiers that are live, nor beside stock nodes."""
    lamina, nodes = material.lamina, material.node_tree.nodes
    wanted = lamina.settled if backend_of(material) == OSL and lamina.tier in HOLD_VALUES else ""
    node = nodes.get(NODE)
    if wanted == (node.get(_KEY, "") if node is not None else ""):
        return
    _remove(material)
    if wanted:
        _add(material, wanted)


def _add(material: bpy.types.Material, key: str) -> None:
    tree, lamina = material.node_tree, material.lamina
    wanted = wanted_network(material)
    # stock nodes follow no texture, and the tables over live values are none that they have
    network = make_network(wanted.stack, PROVISIONAL_TIER) if wanted.live else wanted.make()
    tables = stock_tables(network)
    node, output = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.node_tree, output.target = network_group(tables), "EEVEE"
    node.name = node.label = NODE
    output.name = output.label = OUTPUT
    node[_KEY] = key
    shader = tree.nodes[lamina.shader_node]
    node.location = shader.location.x, shader.location.y - _BELOW
    output.location = node.location.x + _BELOW, node.location.y
    inputs = group_inputs(tables)
    owners = {layer_owner(i): node_of(layer) for i, layer in enumerate(lamina.shown_layers)} | {BASE: node_of(lamina.base)}
    owners |= tangent_owner(material, inputs)
    for given in inputs:
        tree.links.new(owners[given.owner].outputs[given.parameter.label], node.inputs[given.osl_name])
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])


def _remove(material: bpy.types.Material) -> None:
    nodes = material.node_tree.nodes
    group = nodes[NODE].node_tree if NODE in nodes else None
    for name in (NODE, OUTPUT):
        if name in nodes:
            nodes.remove(nodes[name])
    drop_group(group)
