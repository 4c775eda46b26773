# SPDX-License-Identifier: GPL-3.0-or-later
"""Which values of a material change from point to point or in time: those are linked, driven or keyframed."""

import re

import bpy

from ...reference_py.lobes.cache import ALWAYS_LIVE
from ...reference_py.lobes.methods import followed_by_nodes
from ...reference_py.material.place import Place
from ...reference_py.material.schema import Parameter
from ...reference_py.material.stack import Stack
from .elements import kind_of, node_of, unread_parameters, used_features
from .node_copy import channel_bags

_PATH = re.compile(r'nodes\["(.*)"\]\.inputs\[(\d+)\]\.default_value')


def live_values(material: bpy.types.Material) -> tuple[Place, ...]:
    """Live values of the shown layers and the base.

    Without those that no shader holds, and those of features and alternatives that an element does not have.
    """
    lamina = material.lamina
    animated = _animated(material.node_tree)
    result = []
    for layer, element in [*enumerate(lamina.shown_layers), (None, lamina.base)]:
        unused = [p for f in kind_of(element).features if f not in used_features(element) for p in f.parameters]
        unused += unread_parameters(element)
        result += [Place(layer, p.name) for p in kind_of(element).sockets if p not in unused and p.name not in ALWAYS_LIVE and _is_live(element, p, animated)]
    return tuple(result)


def live_in_nodes(material: bpy.types.Material, stack: Stack) -> tuple[Place, ...]:
    """Those of the live values that the stock nodes of a material follow."""
    return followed_by_nodes(stack, material.lamina.tier, live_values(material))


def resting_values(element) -> list[Parameter]:
    """Linked, driven or keyframed values of the alternative that does not describe an element now: they have no effect."""
    unread = unread_parameters(element)
    animated = _animated(element.id_data.node_tree) if unread else set()
    return [p for p in unread if _is_live(element, p, animated)]


def what_moves(element) -> dict[str, str]:
    """What gives an element's values, by parameter: "texture" or "animation"; without those that nothing gives."""
    node, animated = node_of(element), _animated(element.id_data.node_tree)
    live = [p for p in kind_of(element).sockets if _is_live(element, p, animated)]
    return {p.name: "texture" if node.inputs[p.label].is_linked else "animation" for p in live}


def _is_live(element, parameter: Parameter, animated: set[tuple[str, int]]) -> bool:
    node = node_of(element)
    socket = node.inputs.get(parameter.label)
    if socket is None:
        return False  # of a later version
    return socket.is_linked or bool(animated) and (node.name, list(node.inputs).index(socket)) in animated


def _animated(tree: bpy.types.NodeTree) -> set[tuple[str, int]]:
    """(node, input) pairs that drivers and keyframes move."""
    data = tree.animation_data
    if data is None:
        return set()
    curves = [*data.drivers, *(curve for bag in channel_bags(data) for curve in bag.fcurves)]
    found = (_PATH.fullmatch(curve.data_path) for curve in curves)
    return {(bpy.utils.unescape_identifier(match[1]), int(match[2])) for match in found if match}
