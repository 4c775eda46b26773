# SPDX-License-Identifier: GPL-3.0-or-later
"""The node that is a material's shader: a Script node, or a group of stock nodes. It is replaced, never changed."""

from collections.abc import Callable, Sequence

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.network.mixture import PatchNetwork
from ...reference_py.network.table import TableNetwork
from ..network.inputs import TANGENT, ShaderInput
from ..network.node_groups import drop_group, network_group
from ..network.osl import Shader
from ..network.stock_nodes import group_inputs
from .backend import NODES, OSL
from .script_node import drop_text, holds, set_script

_DISTANCE = 320
_SCRIPT, _GROUP = "ShaderNodeScript", "ShaderNodeGroup"
_TANGENT_NODE = "Lamina Tangent"


def backend_of(material: bpy.types.Material) -> str:
    """What a material's shader is made of now, "osl" or "nodes"; "osl" when it has none yet."""
    tree = material.node_tree
    node = tree.nodes.get(material.lamina.shader_node) if tree is not None else None
    return NODES if node is not None and node.bl_idname == _GROUP else OSL


def has_shader(material: bpy.types.Material) -> bool:
    """Whether the material's shader node is still there."""
    return material.node_tree is not None and material.lamina.shader_node in material.node_tree.nodes


def script_with(material: bpy.types.Material, shader: Shader, owners: dict[str, bpy.types.Node]) -> bpy.types.ShaderNodeScript:
    """The material's Script node with this shader, wired to the nodes of the values by owner."""
    script = _shader_node(material, _SCRIPT, lambda node: holds(node, shader), lambda node: set_script(node, shader))
    links, kept = material.node_tree.links, set()
    wanted = {i.osl_name: owners[i.owner].outputs[i.parameter.label] for i in shader.inputs}
    # each change makes Blender look through the whole tree
    for link in [link for link in links if link.to_node == script]:
        if link.from_socket == wanted.get(link.to_socket.identifier):
            kept.add(link.to_socket.identifier)
        else:
            links.remove(link)
    for socket in script.inputs:
        if socket.identifier in wanted and socket.identifier not in kept:
            links.new(wanted[socket.identifier], socket)
    return script


def tangent_owner(material: bpy.types.Material, inputs: Sequence[ShaderInput]) -> dict[str, bpy.types.Node]:
    """The Tangent node of a material whose shader has such an input, made if there is none. The user may set it otherwise.

    Its default is the unwrapped U of the active UV map.
    """
    if not any(i.owner == TANGENT for i in inputs):
        return {}
    tree = material.node_tree
    node = tree.nodes.get(_TANGENT_NODE)
    if node is None:
        node = tree.nodes.new("ShaderNodeTangent")
        node.name = node.label = _TANGENT_NODE
        node.direction_type = "UV_MAP"
    return {TANGENT: node}


def group_with(
    material: bpy.types.Material, network: TableNetwork | PatchNetwork, owners: dict[str, bpy.types.Node]
) -> bpy.types.ShaderNodeGroup:
    """The material's group node of this network, wired to the nodes of the values that it reads live."""
    group = network_group(network)

    def give(node) -> None:
        node.node_tree = group

    node = _shader_node(material, _GROUP, lambda node: node.node_tree == group, give)
    inputs = group_inputs(network)
    owners = owners | tangent_owner(material, inputs)
    for given in inputs:
        material.node_tree.links.new(owners[given.owner].outputs[given.parameter.label], node.inputs[given.osl_name])
    return node


def _shader_node(material, kind: str, holds_it: Callable[[bpy.types.Node], bool], give: Callable[[bpy.types.Node], None]):
    """The material's shader node if it is of this kind and holds the shader already, else a new one in its place."""
    lamina, tree = material.lamina, material.node_tree
    old = tree.nodes.get(lamina.shader_node)
    if old is not None and old.bl_idname == kind and holds_it(old):
        return old
    node = tree.nodes.new(kind)
    try:
        give(node)
    except LaminaError:
        _remove_shader(tree, node)
        raise
    closure = node.outputs["BSDF"]
    if old is None:
        _connect(tree, node, closure)
    else:
        for target in [link.to_socket for socket in old.outputs for link in socket.links]:
            tree.links.new(closure, target)
        node.location = old.location
        _remove_shader(tree, old)
    node.name = node.label = "Lamina Shader"
    lamina.shader_node = node.name
    return node


def _remove_shader(tree, node) -> None:
    """Remove a shader node, and its text or group if nothing else uses it."""
    text, group = getattr(node, "script", None), getattr(node, "node_tree", None)
    tree.nodes.remove(node)
    drop_text(text)
    drop_group(group)


def _connect(tree, shader, closure) -> None:
    """Let a first shader feed the surface. An untouched Principled node there, as in every new material, goes."""
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    surface = output.inputs["Surface"]
    former = surface.links[0].from_node if surface.is_linked else None
    tree.links.new(closure, surface)
    if former is not None and former.bl_idname == "ShaderNodeBsdfPrincipled" and _is_alone(former):
        tree.nodes.remove(former)
    shader.location = (output.location.x - _DISTANCE, output.location.y)


def _is_alone(node) -> bool:
    return not any(socket.is_linked for socket in (*node.inputs, *node.outputs))
