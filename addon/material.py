# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in a material: group nodes that hold its values, and the generated shader that reads them.

The layer nodes feed one Script node. It is generated again only when structure or tier changes.
"""

import json
import uuid

import bpy

from ..reference_py.colour import conductor_rgb
from ..reference_py.errors import LaminaError
from ..reference_py.network import DEFAULT_TIER
from ..reference_py.schema import COLOR, FLOAT, SCHEMA, SCHEMA_VERSION, Kind
from ..reference_py.stack import Element, Stack
from .kind_groups import group_of
from .network.osl import BASE, generate, layer_owner
from .properties import given_choices, quietly
from .rendering.settings import node_tree
from .script_node import require_osl, set_script

_COLUMN, _ROW = 320, 240


def kind_of(element) -> Kind:
    """The schema's kind of a layer's or base's property group."""
    return SCHEMA.layers.get(element.kind) or SCHEMA.bases[element.kind]


def node_of(material: bpy.types.Material, element) -> bpy.types.ShaderNodeGroup:
    """The group node that holds an element's values. Raises LaminaError when somebody deleted it."""
    node = material.node_tree.nodes.get(element.node)
    if node is None:
        raise LaminaError(f"material {material.name}: the node {element.node} of layer {element.name!r} is gone; apply the stack anew")
    return node


def require_editable(material: bpy.types.Material) -> None:
    if material.library is not None:
        raise LaminaError(
            f"material {material.name} is linked from {material.library.filepath}; make it local or a library override to edit it"
        )


def apply_stack(material: bpy.types.Material, stack: Stack, tier: str = DEFAULT_TIER) -> None:
    """Make `material` show `stack`, in place of what it showed. Raises LaminaError before anything is changed."""
    require_editable(material)
    require_osl()
    tree = node_tree(material)
    lamina = material.lamina
    with quietly():
        _clear(material)
        lamina.stack_name, lamina.source, lamina.unknown = stack.name, stack.source, json.dumps(dict(stack.unknown))
        lamina.tier, lamina.schema_version = tier, SCHEMA_VERSION
        for index, layer in enumerate(stack.layers):
            _fill_element(tree, lamina.layers.add(), layer, f"Layer {index + 1}")
        _fill_element(tree, lamina.base, stack.base, "Base")
    rebuild(material)


def stack_of(material: bpy.types.Material, hidden: bool = False) -> Stack:
    """The stack that the sockets hold; hidden layers only if asked for. A linked socket counts with its own value.

    Raises LaminaError when a socket holds what the schema does not allow.
    """
    lamina = material.lamina
    require_layered(material)
    return Stack.from_dict(
        {
            **json.loads(lamina.unknown or "{}"),
            "schema_version": lamina.schema_version,
            "name": lamina.stack_name,
            "source": lamina.source,
            "layers": [_read_element(material, e) for e in lamina.layers if e.visible or hidden],
            "base": _read_element(material, lamina.base),
        },
        f"material {material.name}",
    )


def require_layered(material: bpy.types.Material) -> None:
    if not material.lamina.is_layered:
        raise LaminaError(f"material {material.name} has no Lamina stack; pick a preset first")


def add_layer(material: bpy.types.Material, kind: str, index: int) -> None:
    """Insert a layer of the schema's defaults before position `index` (0 is the top)."""
    require_editable(material)
    require_layered(material)
    lamina = material.lamina
    default = Stack.from_dict({"layers": [{"kind": kind}], "base": {"kind": "lambert"}}).layers[0]
    with quietly():
        _fill_element(material.node_tree, lamina.layers.add(), default, f"Layer {len(lamina.layers)}")
        lamina.layers.move(len(lamina.layers) - 1, index)
        lamina.active_layer = index
    rebuild(material)


def remove_layer(material: bpy.types.Material, index: int) -> None:
    require_editable(material)
    lamina = material.lamina
    node = material.node_tree.nodes.get(lamina.layers[index].node)
    if node is not None:
        material.node_tree.nodes.remove(node)
    lamina.layers.remove(index)
    lamina.active_layer = max(min(index, len(lamina.layers) - 1), 0)
    rebuild(material)


def move_layer(material: bpy.types.Material, index: int, to: int) -> None:
    """Move a layer to another position. Its node, and what animates it, stay as they are."""
    require_editable(material)
    material.lamina.layers.move(index, to)
    material.lamina.active_layer = to
    rebuild(material)


def set_base(material: bpy.types.Material, kind: str) -> None:
    """Replace the base by one of another kind, with the schema's defaults."""
    require_editable(material)
    require_layered(material)
    lamina, tree = material.lamina, material.node_tree
    node = tree.nodes.get(lamina.base.node)
    if node is not None:
        tree.nodes.remove(node)
    with quietly():
        _fill_element(tree, lamina.base, Stack.from_dict({"base": {"kind": kind}}).base, "Base")
    rebuild(material)


def structure_changed(material: bpy.types.Material) -> None:
    """What a panel's choice calls: a metal's index goes into its sockets, then the shader follows."""
    lamina = material.lamina
    if not lamina.is_layered:
        return
    base = lamina.base
    if base.kind == "conductor" and base.given == "metal":
        _set_metal(node_of(material, base), base.metal)
    rebuild(material)


def rebuild(material: bpy.types.Material) -> None:
    """Generate the shader for the present structure and wire the visible layers to it."""
    lamina, tree = material.lamina, material.node_tree
    layers = [element for element in lamina.layers if element.visible]
    structure = Stack.from_dict(
        {"layers": [_structure(e) for e in layers], "base": _structure(lamina.base)}, f"material {material.name}"
    )
    shader = generate(structure, lamina.tier)
    script = tree.nodes.get(lamina.shader_node)
    if script is None:
        script = tree.nodes.new("ShaderNodeScript")
        script.name = script.label = "Lamina Shader"
        lamina.shader_node = script.name
    set_script(script, shader)
    owners = {layer_owner(i): node_of(material, e) for i, e in enumerate(layers)}
    owners[BASE] = node_of(material, lamina.base)
    for link in [link for link in tree.links if link.to_node == script]:
        tree.links.remove(link)
    sockets = {socket.identifier: socket for socket in script.inputs}
    for shader_input in shader.inputs:
        source = owners[shader_input.owner].outputs[shader_input.parameter.label]
        tree.links.new(source, sockets[shader_input.osl_name])
    _wire_output(tree, script)
    _arrange(material, script)


def _structure(element) -> dict:
    """An element as JSON without values: the schema's defaults stand in, since only structure is asked for."""
    kind = kind_of(element)
    chosen = {p.name: getattr(element, p.name) for p in kind.structure}
    for group, choice in zip(kind.alternatives, given_choices(kind)):
        for name in group:
            chosen.pop(name, None)
            if choice == element.given:
                parameter = kind.parameter(name)
                chosen[name] = getattr(element, name) if parameter.is_structural else list(parameter.default)
    return {"kind": element.kind, **chosen}


def _read_element(material, element) -> dict:
    node, kind, data = node_of(material, element), kind_of(element), _structure(element)
    unused = {name for group in kind.alternatives for name in group} - set(data)
    for parameter in kind.sockets:
        if parameter.name not in unused:
            value = node.inputs[parameter.label].default_value
            data[parameter.name] = _decimal(value) if parameter.type == FLOAT else [_decimal(v) for v in list(value)[:3]]
    return {**json.loads(element.unknown or "{}"), **data}


def _decimal(value: float) -> float:
    """A float32 as the shortest decimal that names it: .2 and not .200000003."""
    return float(f"{value:.7g}")


def _fill_element(tree, element, source: Element, label: str) -> None:
    """Set a property group and make its node from an element of a stack."""
    kind = SCHEMA.layers.get(source.kind) or SCHEMA.bases[source.kind]
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group_of(kind)
    node.name = f"Lamina {uuid.uuid4().hex[:12]}"
    node.label = f"{label}: {kind.label}"
    element.node, element.name, element.kind = node.name, source.unknown.get("name", label), source.kind
    element.visible, element.unknown = True, json.dumps(dict(source.unknown))
    for group, choice in zip(kind.alternatives, given_choices(kind)):
        if group[0] in source:
            element.given = choice
    for parameter in kind.parameters:
        if parameter.name not in source:
            continue
        if parameter.is_structural:
            setattr(element, parameter.name, source[parameter.name])
        elif parameter.type == COLOR:
            node.inputs[parameter.label].default_value = (*source[parameter.name], 1.0)
        else:
            node.inputs[parameter.label].default_value = source[parameter.name]
    if "metal" in source:
        _set_metal(node, source["metal"])


def _set_metal(node, metal: str) -> None:
    conductor = SCHEMA.bases["conductor"]
    for name, value in zip(("eta", "k"), conductor_rgb(metal)):
        node.inputs[conductor.parameter(name).label].default_value = value


def _clear(material) -> None:
    """Remove the nodes of the present stack and whatever else fed the surface."""
    lamina, tree = material.lamina, material.node_tree
    if lamina.is_layered:
        for name in [e.node for e in lamina.layers] + [lamina.base.node, lamina.shader_node]:
            node = tree.nodes.get(name)
            if node is not None:
                tree.nodes.remove(node)
        lamina.layers.clear()
        lamina.active_layer = 0
    for node in [n for n in tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled" and not _is_wired(n)]:
        tree.nodes.remove(node)


def _is_wired(node) -> bool:
    """Whether a Principled node has inputs of the user's own; the default one of a new material has none."""
    return any(socket.is_linked for socket in node.inputs)


def _wire_output(tree, script) -> None:
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(next(s for s in script.outputs if s.identifier == "BSDF"), output.inputs["Surface"])


def _arrange(material, script) -> None:
    """Layers in a column from the top, the shader to their right."""
    lamina, tree = material.lamina, material.node_tree
    for row, element in enumerate([*lamina.layers, lamina.base]):
        node = node_of(material, element)
        node.location = (-2 * _COLUMN, -row * _ROW)
        node.mute = not element.visible
    script.location = (-_COLUMN, 0)
    tree.get_output_node("CYCLES").location = (0, 0)
