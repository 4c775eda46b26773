# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in a material: group nodes that hold its values, and the generated shader that reads them.

The layer nodes feed one Script node. It is generated again only when structure or tier changes. Every function
changes the material wholly or, when it raises LaminaError, not at all.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..reference_py.errors import LaminaError
from ..reference_py.network import DEFAULT_TIER, make_network
from ..reference_py.schema import CONDUCTOR, SCHEMA, SCHEMA_VERSION
from ..reference_py.stack import MAX_LAYERS, Stack
from .elements import carry_metal, fill_element, kind_of, node_of, read_element, shown_parameters, structure_dict
from .network.osl import BASE, Shader, generate, layer_owner
from .properties import quietly
from .rendering.settings import node_tree
from .script_node import drop_text, holds, require_osl, set_script
from .snapshot import restore, snapshot

_COLUMN, _ROW = 320, 240


def require_editable(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material whose structure belongs to another file."""
    if material.library is not None:
        raise LaminaError(
            f"material {material.name} is linked from {material.library.filepath}; make it local to edit it, "
            "or a library override to edit its values"
        )
    if material.override_library is not None:
        raise LaminaError(
            f"material {material.name} is a library override: its values can be edited, its layers only after it is made local"
        )


def require_layered(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material without a Lamina stack."""
    if not material.lamina.is_layered:
        raise LaminaError(f"material {material.name} has no Lamina stack; pick a preset first")


def apply_stack(material: bpy.types.Material, stack: Stack, tier: str = DEFAULT_TIER) -> None:
    """Make `material` show `stack`, in place of what it showed."""
    make_network(stack, tier)  # an unknown tier raises before anything is changed
    with _changing(material) as tree:
        lamina = material.lamina
        lamina.stack_name, lamina.source, lamina.unknown = stack.name, stack.source, json.dumps(dict(stack.unknown))
        lamina.tier, lamina.schema_version = tier, SCHEMA_VERSION
        lamina.layers.clear()
        lamina.active_layer = 0
        for layer in stack.layers:
            fill_element(tree, lamina.layers.add(), layer, SCHEMA.layers[layer.kind])
        fill_element(tree, lamina.base, stack.base, SCHEMA.bases[stack.base.kind])


def stack_of(material: bpy.types.Material, hidden: bool = False) -> Stack:
    """The stack that the sockets hold; hidden layers only if asked for. A linked socket counts with its own value.

    Raises LaminaError when a socket holds what the schema does not allow.
    """
    require_layered(material)
    lamina = material.lamina
    return Stack.from_dict(
        {
            **json.loads(lamina.unknown or "{}"),
            "schema_version": lamina.schema_version,
            "name": lamina.stack_name,
            "source": lamina.source,
            "layers": [read_element(e, kind_of(e)) for e in lamina.layers if e.visible or hidden],
            "base": read_element(lamina.base, kind_of(lamina.base)),
        },
        f"material {material.name}",
    )


def add_layer(material: bpy.types.Material, kind: str, index: int) -> None:
    """Insert a layer of the schema's defaults before position `index` (0 is the top)."""
    require_layered(material)
    lamina = material.lamina
    if len(lamina.layers) >= MAX_LAYERS:
        raise LaminaError(f"material {material.name} has {MAX_LAYERS} layers already, more are not allowed")
    default = Stack.from_dict({"layers": [{"kind": kind}], "base": {"kind": lamina.base.kind}}).layers[0]
    with _changing(material) as tree:
        fill_element(tree, lamina.layers.add(), default, SCHEMA.layers[kind])
        lamina.layers.move(len(lamina.layers) - 1, index)
        lamina.active_layer = index


def remove_layer(material: bpy.types.Material, index: int) -> None:
    """Remove a layer and its node, with what animates it."""
    require_layered(material)
    with _changing(material):
        lamina = material.lamina
        lamina.layers.remove(index)
        lamina.active_layer = max(min(index, len(lamina.layers) - 1), 0)


def move_layer(material: bpy.types.Material, index: int, to: int) -> None:
    """Move a layer to another position. Its node, and what animates it, stay as they are."""
    require_layered(material)
    with _changing(material):
        material.lamina.layers.move(index, to)
        material.lamina.active_layer = to


def set_base(material: bpy.types.Material, kind: str) -> None:
    """Replace the base by one of another kind. Parameters that both have keep value and link; others take defaults."""
    require_layered(material)
    lamina = material.lamina
    new_kind, old_kind = SCHEMA.base(kind, f"material {material.name}"), kind_of(lamina.base)
    old = material.node_tree.nodes.get(lamina.base.node)  # gone if somebody deleted it; then this is the way back
    old_values = read_element(lamina.base, old_kind) if old else {}
    kept = [p for p in shown_parameters(new_kind, "") if p.name in old_values]
    base = Stack.from_dict({"base": {"kind": kind, **{p.name: old_values[p.name] for p in kept}}}).base
    with _changing(material) as tree:
        fill_element(tree, lamina.base, base, new_kind)
        for parameter in kept:
            if not parameter.is_structural and old.inputs[parameter.label].is_linked:
                source = old.inputs[parameter.label].links[0].from_socket
                tree.links.new(source, node_of(lamina.base).inputs[parameter.label])


def regenerate(material: bpy.types.Material) -> None:
    """Make the shader anew, for instance after somebody deleted its node."""
    require_layered(material)
    with _changing(material):
        material.lamina.problem = ""


def structure_changed(material: bpy.types.Material, name: str) -> None:
    """What setting the property `name` calls: a metal's sockets, if it concerns them, and the shader follow.

    Update functions cannot report to the user, so an error is kept for the panel to show.
    """
    lamina = material.lamina
    if not lamina.is_layered:
        return
    try:
        if name in ("given", "metal") and lamina.base.kind == CONDUCTOR.name:
            carry_metal(lamina.base, CONDUCTOR)
        regenerate(material)
    except LaminaError as error:
        lamina.problem = str(error)
        print(f"Lamina: {error}")


@contextmanager
def _changing(material: bpy.types.Material) -> Iterator[bpy.types.NodeTree]:
    """Change the structure in the block; then the shader follows, or, on an error, all is as before."""
    require_editable(material)
    require_osl()
    lamina, tree = material.lamina, node_tree(material)
    before, nodes_before = snapshot(lamina), _value_nodes(lamina)
    try:
        with quietly():
            yield tree
            lamina.problem = ""
            _rebuild(material)
    except Exception:
        _remove_nodes(tree, _value_nodes(lamina) - nodes_before)
        with quietly():
            restore(lamina, before)
        raise
    _remove_nodes(tree, nodes_before - _value_nodes(lamina))


def _value_nodes(lamina) -> set[str]:
    return {element.node for element in (*lamina.layers, lamina.base)}


def _remove_nodes(tree, names: set[str]) -> None:
    for node in [tree.nodes[name] for name in names if name in tree.nodes]:
        tree.nodes.remove(node)


def _rebuild(material) -> None:
    """Generate the shader for the present structure and wire the visible layers to it."""
    lamina = material.lamina
    layers = [element for element in lamina.layers if element.visible]
    owners = {layer_owner(i): node_of(e) for i, e in enumerate(layers)} | {BASE: node_of(lamina.base)}
    elements = [structure_dict(e, kind_of(e)) for e in (*layers, lamina.base)]
    structure = Stack.from_dict({"layers": elements[:-1], "base": elements[-1]}, f"material {material.name}")
    shader = generate(structure, lamina.tier)
    script = _script_with(material, shader)
    for link in [link for link in material.node_tree.links if link.to_node == script]:
        material.node_tree.links.remove(link)
    inputs = {socket.identifier: socket for socket in script.inputs}
    for shader_input in shader.inputs:
        source = owners[shader_input.owner].outputs[shader_input.parameter.label]
        material.node_tree.links.new(source, inputs[shader_input.osl_name])
    lamina.lobe_count = make_network(structure, lamina.tier).lobe_count
    _arrange(lamina, script)


def _script_with(material, shader: Shader) -> bpy.types.ShaderNodeScript:
    """The material's Script node if it holds the shader already, else a new one in its place."""
    lamina, tree = material.lamina, material.node_tree
    old = tree.nodes.get(lamina.shader_node)
    if old is not None and holds(old, shader):
        return old
    script = tree.nodes.new("ShaderNodeScript")
    try:
        set_script(script, shader)
    except LaminaError:
        text = script.script
        tree.nodes.remove(script)
        drop_text(text)
        raise
    closure = next(socket for socket in script.outputs if socket.identifier == "BSDF")
    if old is None:
        _connect(tree, script, closure)
    else:
        for target in [link.to_socket for socket in old.outputs for link in socket.links]:
            tree.links.new(closure, target)
        script.location, text = old.location, old.script
        tree.nodes.remove(old)
        drop_text(text)
    script.name = script.label = "Lamina Shader"
    lamina.shader_node = script.name
    return script


def _connect(tree, script, closure) -> None:
    """Let a first shader feed the surface. An untouched Principled node there, as in every new material, goes."""
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    surface = output.inputs["Surface"]
    former = surface.links[0].from_node if surface.is_linked else None
    tree.links.new(closure, surface)
    if former is not None and former.bl_idname == "ShaderNodeBsdfPrincipled" and _is_alone(former):
        tree.nodes.remove(former)
    script.location = (output.location.x - _COLUMN, output.location.y)


def _is_alone(node) -> bool:
    return not any(socket.is_linked for socket in (*node.inputs, *node.outputs))


def _arrange(lamina, script) -> None:
    """Layers in a column from the top, to the left of the shader."""
    for row, element in enumerate([*lamina.layers, lamina.base]):
        node = node_of(element)
        node.location = (script.location.x - _COLUMN, script.location.y - row * _ROW)
        node.mute = not element.visible
        node.label = element.name
