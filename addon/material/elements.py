# SPDX-License-Identifier: GPL-3.0-or-later
"""A layer or base in Blender: a property group for its structure and a group node for its values."""

import itertools
import json
import math
import re
import uuid

import bpy
import numpy as np

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material.schema import COLOR, FLOAT, SCHEMA, Feature, Kind, Parameter
from ...reference_py.material.stack import Base, Layer
from ...reference_py.optics.colour import artist_color, artist_index, conductor_rgb
from ..shader.inputs import BASE, layer_owner
from ..shader.working_space import REC709, out_of_working, working_space
from .backend import OSL
from .kind_groups import KIND_KEY, declare_missing, give_value, group_key, group_of
from .means import kept_mean
from .roles import node_with

# The immutable id of a value node, which is the name that it was made with; users may rename nodes.
ID_KEY = "lamina_id"
_FLOAT32_DIGITS = 7
_VISIBLE = 1e-3
# Blender converts files by matrices of 5 decimals, so further digits of a color, counted from its largest component's, are nobody's.
_CONVERTED_DIGITS = 4


def kind_of(element) -> Kind:
    """The schema's kind of a layer's or base's property group."""
    return (SCHEMA.bases if element == element.id_data.lamina.base else SCHEMA.layers)[element.kind]


def find_node(element) -> bpy.types.ShaderNodeGroup | None:
    """The group node that holds an element's values, also after somebody renamed it; None where it was deleted."""
    tree = element.id_data.node_tree
    if tree is None or not element.node:
        return None
    node = tree.nodes.get(element.node)
    return node or next((n for n in tree.nodes if n.get(ID_KEY) == element.node), None) or _node_by_links(element)


def _node_by_links(element) -> bpy.types.ShaderNodeGroup | None:
    """The node that feeds the shader's sockets of an element, or has the label of a hidden one: files of schema 1 and 2 have no ids."""
    material = element.id_data
    lamina, script = material.lamina, node_with(material, OSL)
    owners = {BASE: lamina.base} | {layer_owner(i): layer for i, layer in enumerate(lamina.shown_layers)}
    owner = next((name for name, one in owners.items() if one == element), None)
    if owner is None:
        nodes = [node for node in material.node_tree.nodes if node.label == element.name and not any(s.is_linked for s in node.outputs)]
    elif script is None:
        return None
    else:
        wanted = {owner + p.osl_name for p in kind_of(element).sockets}
        nodes = [link.from_node for s in script.inputs if s.identifier in wanted for link in s.links]
    return next(
        (
            n
            for n in nodes
            if n.bl_idname == "ShaderNodeGroup" and n.node_tree is not None and n.node_tree.get(KIND_KEY) == group_key(kind_of(element)) and ID_KEY not in n
        ),
        None,
    )


def node_of(element) -> bpy.types.ShaderNodeGroup:
    """The group node that holds an element's values. Raises LaminaError when somebody deleted it."""
    node = find_node(element)
    if node is None:
        raise LaminaError(
            "material {material}: the node of {element!r} was deleted; undo, remove the layer, or pick a preset anew",
            material=element.id_data.name,
            element=element.name,
        )
    return node


def socket_of(element, parameter: Parameter) -> bpy.types.NodeSocket:
    """The socket that holds a value. Raises LaminaError when somebody took it out of the node's group."""
    socket = node_of(element).inputs.get(parameter.label)
    if socket is None:
        raise LaminaError(
            "material {material}: the node of {element!r} has no socket {label}; Check replaces its group",
            material=element.id_data.name,
            element=element.name,
            label=Sentence(parameter.label),
        )
    return socket


def bring_up_to_date(element) -> None:
    """Give an element's node the sockets that came after the version which made it, and its id."""
    node = node_of(element)
    tree = node.node_tree
    if ID_KEY not in node:
        node[ID_KEY] = element.node
    if tree is not None and tree.library is None:
        declare_missing(tree, kind_of(element))


def show_name(element) -> None:
    """Write the element's name on its node, if it has one."""
    node = find_node(element)
    if node is not None and node.label != element.name:
        node.label = element.name


def use_of(feature: Feature) -> str:
    """The property that says whether an element has a feature."""
    return f"use_{feature.name}"


def used_features(element) -> tuple[Feature, ...]:
    """The optional features that a layer or base has."""
    return tuple(feature for feature in kind_of(element).features if getattr(element, use_of(feature)))


def given_of(feature: Feature) -> str:
    """The property that says by which of its alternatives an element's feature is given."""
    return f"given_{feature.name}"


def feature_parameters(element, feature: Feature) -> tuple[Parameter, ...]:
    """The parameters that describe a feature of an element."""
    return feature.given_by(getattr(element, given_of(feature))) if feature.alternatives else feature.parameters


def element_parameters(element, kind: Kind, given: str) -> tuple[Parameter, ...]:
    """The parameters that describe an element, those of its features last."""
    return (*kind.given_by(given), *(p for feature in used_features(element) for p in feature_parameters(element, feature)))


def unread_parameters(element) -> tuple[Parameter, ...]:
    """The sockets of the alternatives that do not describe an element now. A named metal is read from its index."""
    kind, given = kind_of(element), "eta+k" if element.given == "metal" else element.given
    unread = [*kind.not_given_by(given)]
    for feature in used_features(element):
        unread += [p for p in feature.parameters if p not in feature_parameters(element, feature)]
    return tuple(p for p in kind.sockets if p in unread)


def structure_dict(element, kind: Kind) -> dict:
    """An element as JSON without values: the schema's defaults stand in, since only structure is asked for."""
    values = {p.name: getattr(element, p.name) if p.is_structural else p.default for p in element_parameters(element, kind, element.given)}
    return {"kind": element.kind, **values}


def new_node(tree: bpy.types.NodeTree, kind: Kind, former: str = "") -> bpy.types.ShaderNodeGroup:
    """A node for the values of a kind, with the schema's defaults; under the id of a former one that is gone, or a new id."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.name = node[ID_KEY] = former or f"Lamina {uuid.uuid4().hex[:12]}"
    node.node_tree = group_of(kind)
    return node


def fill_element(tree: bpy.types.NodeTree, element, source: Layer | Base, kind: Kind) -> None:
    """Set a property group, and make the node of its values, from an element of a stack."""
    node = new_node(tree, kind)
    element.node, element.kind = node.name, source.kind
    name = source.unknown.get("name")
    element.name = name if isinstance(name, str) else free_name(element, kind.label)
    element.visible, element.unknown = True, json.dumps(dict(source.unknown))
    for group, choice in zip(kind.alternatives, kind.given_choices):
        if group[0] in source:
            element.given = choice
    for feature in kind.features:
        setattr(element, use_of(feature), source.has(feature))
        for group, choice in zip(feature.alternatives, feature.given_choices):
            if group[0] in source:
                setattr(element, given_of(feature), choice)
    for parameter in kind.all_parameters:
        if parameter.name not in source:
            continue
        value = source[parameter.name]
        if parameter.is_structural:
            setattr(element, parameter.name, value)
        else:
            give_value(node.inputs[parameter.label], parameter, value)
    if "metal" in source:
        set_metal(element, kind)
    element.was_given = element.given


def read_element(element, kind: Kind) -> dict:
    """An element as JSON, values from its node's sockets. A linked one counts with the mean that is kept of what is linked."""
    given = "eta+k" if element.given == "metal" and _index_differs(element, kind) else element.given
    data = {"kind": element.kind}
    for parameter in element_parameters(element, kind, given):
        if parameter.is_structural:
            data[parameter.name] = getattr(element, parameter.name)
        else:
            data[parameter.name] = _value_of(socket_of(element, parameter), parameter)
    unknown = json.loads(element.unknown or "{}")
    if "name" in unknown or not _is_default_name(element.name, kind):
        unknown["name"] = element.name
    return {**unknown, **data}


def value_of(element, parameter: Parameter) -> float | list[float]:
    """A value as the model has it, of a linked socket the mean that is kept. Raises LaminaError when there is no socket."""
    return _value_of(socket_of(element, parameter), parameter)


def free_name(element, wanted: str) -> str:
    """A name for a layer, with a number where another layer of the stack has the wanted one; the base's as it is."""
    lamina = element.id_data.lamina
    if element == lamina.base:
        return wanted
    taken = {layer.name for layer in lamina.layers if layer != element}
    stem = re.sub(r" \d+$", "", wanted) or wanted
    names = itertools.chain((wanted,), (f"{stem} {number}" for number in itertools.count(2)))
    return next(name for name in names if name not in taken)


def _is_default_name(name: str, kind: Kind) -> bool:
    return re.fullmatch(rf"{re.escape(kind.label)}( \d+)?", name) is not None


def set_metal(element, kind: Kind) -> None:
    """Write the complex index of the element's named metal into its sockets."""
    for socket, value in zip(_index_sockets(element, kind), conductor_rgb(element.metal)):
        socket.default_value = value


def carry_metal(element, kind: Kind) -> None:
    """After a choice: a named metal's index goes into its sockets, and a new way to give a metal starts from the old."""
    index = [kind.parameter(name) for name in ("eta", "k")]
    colors = [kind.parameter(name) for name in ("reflectance", "edge_color")]
    was_colors = colors[0].name in element.was_given
    is_colors = colors[0].name in element.given
    if element.given == "metal":
        set_metal(element, kind)
    elif is_colors != was_colors:
        sources, targets, convert = (index, colors, artist_color) if is_colors else (colors, index, artist_index)
        old = [np.clip(_value_of(socket_of(element, p), p), p.minimum, p.maximum) for p in sources]
        for parameter, value in zip(targets, convert(*old)):
            value = np.clip(value, parameter.minimum, parameter.maximum)
            give_value(socket_of(element, parameter), parameter, value)
    element.was_given = element.given


def _index_differs(element, kind: Kind) -> bool:
    """Whether somebody changed the index of a named metal in its node: then it is that metal no more."""
    if not any("metal" in group for group in kind.alternatives):
        return False
    pairs = zip(_index_sockets(element, kind), conductor_rgb(element.metal))
    return not all(np.allclose(socket.default_value, value, rtol=1e-6) for socket, value in pairs)


def _index_sockets(element, kind: Kind) -> list[bpy.types.NodeSocket]:
    return [socket_of(element, kind.parameter(name)) for name in ("eta", "k")]


def _value_of(socket: bpy.types.NodeSocket, parameter: Parameter) -> float | list[float]:
    """A socket's value as the model has it, of a linked one the mean. A color in range that lies outside Rec.709 is limited, which Check tells."""
    mean = kept_mean(socket)
    if mean is not None:
        return mean
    if parameter.type == FLOAT:
        return _decimal(socket.default_value)
    value = list(socket.default_value)[:3]
    if parameter.type != COLOR or working_space() == REC709:
        return [_decimal(v) for v in value]
    inside = all(parameter.minimum <= v <= parameter.maximum for v in value)
    value = out_of_working(value)
    digits = _CONVERTED_DIGITS - math.ceil(math.log10(max(*np.abs(value), 1e-6)))
    return [round(float(v), digits) for v in (np.clip(value, parameter.minimum, parameter.maximum) if inside else value)]


def outside_rec709(socket: bpy.types.NodeSocket) -> bool:
    """Whether a color of another working space lies visibly outside of what the model's linear Rec.709 holds."""
    if working_space() == REC709:
        return False
    value = out_of_working(list(socket.default_value)[:3])
    return bool(np.any(value < -_VISIBLE) or np.any(value > 1.0 + _VISIBLE))


def _decimal(value: float) -> float:
    """A float32 as the shortest decimal that names it: .2 and not .200000003."""
    return float(f"{value:.{_FLOAT32_DIGITS}g}")
