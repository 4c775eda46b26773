# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material shows: stock nodes and an OSL script under one Mix Shader, so that it is right on every device.

The Mix Shader's factor is 1 where an output of the script has a value that nothing else gives: where Cycles runs OSL it
shows the script, everywhere else (GPUs but OptiX, EEVEE, OSL switched off, a script that is muted or has no bytecode)
the stock nodes. OSL folds all of it. A backend that has one branch alone needs no Mix Shader. Branches are replaced, never changed.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import bpy

from ..blender import environment
from ..shader.inputs import PRIMARIES, TANGENT, ShaderInput
from ..shader.nodes.node_groups import drop_group, lobe_group
from ..shader.nodes.stock_nodes import Tables, group_inputs
from ..shader.osl.block import LIVE
from ..shader.osl.generate import Shader
from ..shader.working_space import primaries
from .backend import NODES, OSL
from .entry import entry_of
from .hand_over import MIX, tail
from .roles import EEVEE, ROLE, SWITCH, TEST, give, node_with
from .script_node import drop_text, holds, set_script

_LABELS = {OSL: "Lamina Shader", NODES: "Lamina Stock Nodes", EEVEE: "Lamina EEVEE", TEST: "Lamina OSL Runs", SWITCH: "Lamina OSL or Stock Nodes"}
_TYPES = {OSL: "ShaderNodeScript", NODES: "ShaderNodeGroup", EEVEE: "ShaderNodeGroup", TEST: "ShaderNodeMath", SWITCH: "ShaderNodeMixShader"}
# Places left of the output.
_PLACES = {OSL: (-900, 0), NODES: (-900, -320), EEVEE: (-900, -520), TEST: (-660, 120), SWITCH: (-460, 0)}
_TANGENT_NODE = "Lamina Tangent"
# Schema 2 showed EEVEE stock nodes at an output of its own.
_FORMER_PREVIEW = ("Lamina Preview", "Lamina Preview Output")


def backend_of(material: bpy.types.Material) -> str:
    """What Cycles with OSL shows of a material, "osl" or "nodes"; "osl" when it has no shader yet."""
    return NODES if node_with(material, OSL) is None and node_with(material, NODES) is not None else OSL


def lost_group(material: bpy.types.Material) -> bool:
    """Whether the node of the stock nodes is there without its group."""
    stock = node_with(material, NODES)
    return stock is not None and stock.node_tree is None


def shader_of(material: bpy.types.Material) -> bpy.types.Node | None:
    """The branch that this Blender renders: the script where it has OSL; None where somebody deleted both."""
    script, stock = node_with(material, OSL), node_with(material, NODES)
    return script or stock if environment.renders_osl() else stock or script


def surface_of(material: bpy.types.Material) -> bpy.types.NodeSocket | None:
    """The closure that Lamina gives to the surface, or to the user's own mix."""
    closure = shading_of(material)
    return tail(closure) if closure is not None else None


def shading_of(material: bpy.types.Material) -> bpy.types.NodeSocket | None:
    """The closure of the branches, below what exporters find."""
    switch, shader = node_with(material, SWITCH), shader_of(material)
    if switch is not None:
        return switch.outputs[0]
    return shader.outputs["BSDF"] if shader is not None else None


def tangent_owner(material: bpy.types.Material, inputs: Sequence[ShaderInput]) -> dict[str, bpy.types.Node]:
    """The Tangent node of a material whose shader has such an input, made if there is none. The user may set it otherwise.

    Its default is the unwrapped U of the active UV map.
    """
    if not any(i.owner == TANGENT for i in inputs):
        return {}
    tree = material.node_tree
    node = node_with(material, TANGENT) or tree.nodes.get(_TANGENT_NODE)
    if node is None:
        node = tree.nodes.new("ShaderNodeTangent")
        node.name = node.label = _TANGENT_NODE
        node.direction_type = "UV_MAP"
    if ROLE not in node:
        node[ROLE] = TANGENT
    return {TANGENT: node}


def remove_material(material: bpy.types.Material) -> None:
    """Remove a material that is used no more, with the text and the node group of its branches."""
    nodes = material.node_tree.nodes if material.node_tree is not None else ()
    texts, groups = ({getattr(node, name) for node in nodes if hasattr(node, name)} for name in ("script", "node_tree"))
    bpy.data.materials.remove(material)
    for text in texts:
        drop_text(text)
    for group in groups:
        drop_group(group)


class Surface:
    """The branches of one material while they are replaced: new ones are made beside the old, then take their place."""

    def __init__(self, material: bpy.types.Material):
        self._material, self._tree = material, material.node_tree
        self._old = {role: node_with(material, role) for role in _TYPES}
        self._new: dict[str, bpy.types.Node] = {}

    def script(self, shader: Shader, owners: dict[str, bpy.types.Node]) -> bpy.types.Node:
        """The Script node with this shader, wired to the nodes of the values by owner. Raises LaminaError."""
        node = self._branch(OSL, lambda node: holds(node, shader), lambda node: set_script(node, shader))
        for name, color in zip(PRIMARIES, primaries()):
            give(node.inputs[name], (*color, 1.0))
        self._wire(node, shader.inputs, owners)
        return node

    def stock(self, lobe_set: Tables, owners: dict[str, bpy.types.Node], role: str = NODES) -> bpy.types.Node:
        """The group node of this lobe set, wired to the nodes of the values that it reads live; of a role, NODES or EEVEE.

        EEVEE shows that of NODES too where it has no output of its own.
        """
        group = lobe_group(lobe_set, role == EEVEE or (self._old[NODES] is not None and self._old[EEVEE] is None))
        node = self._branch(role, lambda node: node.node_tree == group, lambda node: setattr(node, "node_tree", group))
        self._wire(node, group_inputs(lobe_set), owners)
        return node

    def keep(self, role: str) -> None:
        """Leave a branch as it is."""
        if self._old[role] is not None:
            self._new[role] = self._old[role]

    def _branch(self, role: str, holds_it, give) -> bpy.types.Node:
        old = self._old[role]
        if old is not None and holds_it(old):
            self._new[role] = old
        else:
            self._new[role] = self._made(role)
            give(self._new[role])
        return self._new[role]

    def _made(self, role: str) -> bpy.types.Node:
        node = self._tree.nodes.new(_TYPES[role])
        node.name = node.label = _LABELS[role]
        node[ROLE] = role
        return node

    def _wire(self, node, inputs: Sequence[ShaderInput], owners) -> None:
        owners = owners | tangent_owner(self._material, inputs)
        wanted = {i.osl_name: owners[i.owner].outputs[i.parameter.label] for i in inputs}
        # sockets of a group have identifiers of Blender's own, and no labels
        _link_exactly(self._tree, node, {s.identifier: wanted[name] for s in node.inputs for name in {s.identifier, s.name} if name in wanted})

    def finish(self) -> None:
        """Let the new branches feed what the old ones fed; at first the surface. What is not kept goes."""
        tree, old = self._tree, [node for node in self._old.values() if node is not None]
        targets = [link.to_socket for node in old for socket in node.outputs for link in socket.links if ROLE not in link.to_node]
        place = _place_of(tree, old)
        script, stock = self._new.get(OSL), self._new.get(NODES)
        if script is not None and stock is not None:
            closure = self._switched(script, stock)
        else:
            closure = (script or stock).outputs["BSDF"]
        mix = node_with(self._material, MIX)
        if mix is not None and mix.outputs[0].is_linked:  # it feeds what they fed
            targets = targets or [mix.inputs[1]]
        for target in targets or entry_of(tree):
            if not any(link.from_socket == closure for link in target.links):
                tree.links.new(closure, target)
        for role, node in self._new.items():
            if node not in old or ROLE not in node:  # new, or of an older file
                node[ROLE] = role
                node.location = place[0] + _PLACES[role][0], place[1] + _PLACES[role][1]
        self._remove([node for node in old if node not in self._new.values()])
        _remove_preview(tree)

    def _switched(self, script, stock) -> bpy.types.NodeSocket:
        """The closure that is the script's where it runs and the stock nodes' elsewhere."""
        test, switch = (self._new.setdefault(role, self._old[role] or self._made(role)) for role in (TEST, SWITCH))
        if test.operation != "COMPARE":
            test.operation, test.hide = "COMPARE", True
        for socket, value in ((test.inputs[0], 0.0), (test.inputs[1], LIVE), (test.inputs[2], 0.5), (switch.inputs[0], 0.0)):
            give(socket, value)
        _link_exactly(self._tree, test, {test.inputs[0].identifier: script.outputs["Live"]})
        closures = (test.outputs[0], stock.outputs["BSDF"], script.outputs["BSDF"])
        _link_exactly(self._tree, switch, {socket.identifier: closure for socket, closure in zip(switch.inputs, closures)})
        return switch.outputs[0]

    def abandon(self) -> None:
        """Remove what was made."""
        self._remove([node for role, node in self._new.items() if node != self._old[role]])

    def _remove(self, nodes) -> None:
        for node in nodes:
            text, group = getattr(node, "script", None), getattr(node, "node_tree", None)
            self._tree.nodes.remove(node)
            drop_text(text)
            drop_group(group)


@contextmanager
def replacing_branches(material: bpy.types.Material) -> Iterator[Surface]:
    """Make branches in the block. At its end they take their place; on an error the old ones stay."""
    surface = Surface(material)
    try:
        yield surface
    except Exception:
        surface.abandon()
        raise
    surface.finish()


def _link_exactly(tree, node, wanted: dict[str, bpy.types.NodeSocket]) -> None:
    """Give a node's sockets, by identifier, these links and no others. Each change makes Blender look through the whole tree."""
    kept = set()
    for link in [link for link in tree.links if link.to_node == node]:
        if link.from_socket == wanted.get(link.to_socket.identifier):
            kept.add(link.to_socket.identifier)
        else:
            tree.links.remove(link)
    for socket in node.inputs:
        if socket.identifier in wanted and socket.identifier not in kept:
            tree.links.new(wanted[socket.identifier], socket)


def _place_of(tree, old) -> tuple[float, float]:
    """Where the output is, seen from which branches have their places."""
    if old and ROLE in old[0]:
        dx, dy = _PLACES[old[0][ROLE]]
        return old[0].location_absolute.x - dx, old[0].location_absolute.y - dy
    output = tree.get_output_node("ALL")
    return (output.location_absolute.x, output.location_absolute.y) if output is not None else (0.0, 0.0)


def _remove_preview(tree) -> None:
    group = tree.nodes[_FORMER_PREVIEW[0]].node_tree if _FORMER_PREVIEW[0] in tree.nodes else None
    for name in _FORMER_PREVIEW:
        if name in tree.nodes:
            tree.nodes.remove(tree.nodes[name])
    drop_group(group)
