# SPDX-License-Identifier: GPL-3.0-or-later
"""A Principled node that shows a stack: its values, and links from what feeds the layers.

A texture of the base color goes through nodes that keep the mean albedo. The last of them is a factor, which glTF takes
along with the bare picture, whatever nodes are between; it is exact at the picture's mean, unless that is too dark for a factor of 1.
"""

from collections.abc import Callable, Iterator

import bpy
import numpy as np

from ...reference_py.errors import Sentence
from ...reference_py.exchange.matching import ColorMap
from ...reference_py.exchange.principled import OUT_OF_COLOR, PLACES, WRITTEN
from ...reference_py.exchange.report import KEPT, LOST, noted
from ...reference_py.material.schema import Parameter
from .elements import kind_of, node_of, used_features, value_of
from .kind_groups import KIND_KEY
from .means import kept_picture
from .properties import LaminaElement
from .roles import Roles, give

PRINCIPLED = "ShaderNodeBsdfPrincipled"
COLOR, NORMALS = "Base Color", ("Normal", "Coat Normal")
_COLOR_ROLES = tuple(f"principled color {n}" for n in range(6))
_TINT_ROLE = "principled tint"
_APART = 200
_LEAST = 1e-6


def parameter_of(element, parameter: str) -> str:
    """`parameter` as the element's kind calls it: a metal's color is its reflectance."""
    return "reflectance" if parameter == "color" and kind_of(element).alternatives else parameter


def linked_places(material: bpy.types.Material, owners: dict[str, int]) -> Iterator[tuple[str, LaminaElement, Parameter, bpy.types.NodeSocket]]:
    """(socket of Principled, element, schema's parameter, source) of every link that Principled has a place for."""
    elements = [*material.lamina.shown_layers, material.lamina.base]
    for socket, roles, name in PLACES:
        for role in [r for r in roles if r in owners][:1] if name != "normal" else [r for r in roles if r in owners]:
            element = elements[owners[role]]
            source = source_of(element, parameter_of(element, name))
            if source is not None:
                yield socket, element, kind_of(element).parameter(parameter_of(element, name)), source
                break


def source_of(element, name: str) -> bpy.types.NodeSocket | None:
    """What is linked to an element's parameter, if it takes part."""
    kind = kind_of(element)
    unused = {p.name for f in kind.features if f not in used_features(element) for p in f.parameters}
    if name in unused or name not in {p.name for p in kind.sockets}:
        return None
    if name == "reflectance" and name not in element.given:
        return None
    socket = node_of(element).inputs[kind.parameter(name).label]
    return socket.links[0].from_socket if socket.is_linked else None


def picture_of(element: LaminaElement, parameter: Parameter) -> np.ndarray:
    """The mean color of the picture that glTF takes for what is linked to a parameter; without a link its own color."""
    found = kept_picture(node_of(element).inputs[parameter.label])
    return np.asarray(value_of(element, parameter) if found is None else found)


def has_linked_color(material: bpy.types.Material) -> bool:
    """Whether something feeds the color of the base."""
    return source_of(material.lamina.base, parameter_of(material.lamina.base, "color")) is not None


def is_layer(node: bpy.types.Node) -> bool:
    """Whether a node holds the values of a layer or base."""
    return node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None and KIND_KEY in node.node_tree


def show_stack(principled: bpy.types.Node, material: bpy.types.Material, values: dict, owners: dict[str, int], colors: ColorMap | None) -> list[Sentence]:
    """Give a Principled node, in the tree of `material`, the values and the links of its layers; only what differs is set.

    Arguments as in Converted. Without `colors` a texture of the base color keeps the nodes that it goes through, if any.
    Returns one sentence for each link. Sockets that a stack says nothing about, such as Alpha, are left alone, and a tint of the coat or
    a film that the values leave out, as the base color has them, is not linked.
    """
    roles, lamina, notes, fed = Roles(principled.id_data), material.lamina, [], set()
    for name, default in WRITTEN.items():
        give(principled.inputs[name], values.get(name, default))
    several = len(lamina.shown_layers) > 1
    kept_roles = set()
    for name, element, parameter, source in linked_places(material, owners):
        if name in OUT_OF_COLOR and name not in values:
            continue
        target = principled.inputs[name]
        if parameter.name == "tint" and several:
            told = Sentence(
                "{element} {parameter} texture: the media of several layers share one tint", element=element.name, parameter=Sentence(parameter.label)
            )
            notes.append(noted(LOST, told))
            continue
        fed.add(name)
        if name == COLOR and (colors is not None or roles.get(_COLOR_ROLES[0])):
            own = np.asarray(value_of(element, parameter))
            source = _through_color(roles, source, target, colors, own, picture_of(element, parameter))
            kept_roles |= set(_COLOR_ROLES)
            notes.append(noted(KEPT, Sentence("{socket} texture: through nodes that keep the mean color", socket=COLOR)))
        else:
            if parameter.name == "tint":
                gamma = roles.make(
                    _TINT_ROLE, "ShaderNodeGamma", "Lamina round trip", (principled.location_absolute.x - _APART, principled.location_absolute.y - 2 * _APART)
                )
                give(gamma.inputs["Gamma"], 2.0 * value_of(element, kind_of(element).parameter("thickness")))
                roles.link(source, gamma.inputs["Color"])
                source = gamma.outputs["Color"]
                kept_roles.add(_TINT_ROLE)
            notes.append(noted(KEPT, Sentence("{socket} texture: linked", socket=name)))
        roles.link(source, target)
    for name in {socket for socket, *_ in PLACES} - fed:
        roles.link(None, principled.inputs[name])
    roles.remove({*_COLOR_ROLES, _TINT_ROLE} - kept_roles)
    return notes


def _through_color(roles: Roles, source, target, colors: ColorMap | None, own: np.ndarray, picture: np.ndarray) -> bpy.types.NodeSocket:
    """Output of the map's nodes, a factor last that makes a picture's mean what the map makes of `own`: what goes before it is divided by it."""
    place = target.node.location_absolute
    if colors is None:
        nodes = [roles.get(role) for role in _COLOR_ROLES]
    else:
        factor = np.where(picture > _LEAST, colors(own) / np.maximum(picture, _LEAST), 1.0)
        factor = np.where(factor > _LEAST, np.minimum(factor, 1.0), 1.0)
        steps = ColorMap(colors.p0 / factor, colors.p1 / factor, colors.p2)
        kinds = (*("ShaderNodeVectorMath",) * 5, "ShaderNodeMix")
        nodes = [roles.make(role, kind, "Lamina color", (place.x - _APART * (6 - n), place.y)) for n, (role, kind) in enumerate(zip(_COLOR_ROLES, kinds))]
        _set_map(nodes[:5], steps, colors.most / factor, roles.link)
        _set_factor(nodes[5], factor)
    roles.link(source, nodes[0].inputs[0])
    roles.link(source, nodes[1].inputs[0])
    multiplied, by = [socket for socket in nodes[5].inputs if socket.type == "RGBA"]
    roles.link(nodes[4].outputs[0], multiplied)
    return next(socket for socket in nodes[5].outputs if socket.type == "RGBA")


def _set_factor(mix: bpy.types.Node, factor: np.ndarray) -> None:
    for name, value in (("data_type", "RGBA"), ("blend_type", "MULTIPLY")):
        if getattr(mix, name) != value:
            setattr(mix, name, value)
    give(mix.inputs[0], 1.0)
    give([socket for socket in mix.inputs if socket.type == "RGBA"][1], (*factor, 1.0))


def _set_map(nodes, colors: ColorMap, most, link: Callable) -> None:
    """Vector Math nodes as a color map: above and below the line, their quotient, its limits."""
    above, below, divided, positive, bounded = nodes
    steps = (
        ("MULTIPLY_ADD", colors.p1, colors.p0), ("MULTIPLY_ADD", colors.p2, np.ones(3)), ("DIVIDE", None, None),
        ("MAXIMUM", np.zeros(3), None), ("MINIMUM", np.broadcast_to(most, 3), None),
    )  # fmt: skip
    for node, (operation, first, second) in zip(nodes, steps):
        if node.operation != operation:
            node.operation = operation
        for socket, value in zip(list(node.inputs)[1:], (first, second)):
            if value is not None:
                give(socket, tuple(float(v) for v in value))
    for source, target in ((above, divided.inputs[0]), (below, divided.inputs[1]), (divided, positive.inputs[0]), (positive, bounded.inputs[0])):
        link(source.outputs[0], target)


def link_through(source: bpy.types.NodeSocket, target: bpy.types.NodeSocket, colors: ColorMap) -> None:
    """Link a color to a socket by way of a color map, made of new Vector Math nodes."""
    tree, nodes = target.id_data, []
    for place in range(5):
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.label, node.hide = "Lamina color", True
        node.location = (target.node.location_absolute.x - _APART * (5 - place), target.node.location_absolute.y)
        nodes.append(node)
    _set_map(nodes, colors, colors.most, tree.links.new)
    for node in nodes[:2]:
        tree.links.new(source, node.inputs[0])
    tree.links.new(nodes[-1].outputs[0], target)
