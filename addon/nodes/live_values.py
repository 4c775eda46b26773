# SPDX-License-Identifier: GPL-3.0-or-later
"""Which values of a material change from point to point or in time: those are linked, driven or keyframed."""

import re

import bpy

from ...reference_py.network.memory import ALWAYS_LIVE
from .elements import kind_of, node_of, used_features

_PATH = re.compile(r'nodes\["(.*)"\]\.inputs\[(\d+)\]\.default_value')


def live_values(material: bpy.types.Material) -> tuple[tuple[int, str], ...]:
    """Live values of the shown layers and the base, as (index of the layer or -1, parameter).

    Without those that no shader holds, and those of features that an element does not have.
    """
    lamina = material.lamina
    animated = _animated(material.node_tree)
    result = []
    for index, element in [*enumerate(lamina.shown_layers), (-1, lamina.base)]:
        node = node_of(element)
        unused = [p for f in kind_of(element).features if f not in used_features(element) for p in f.parameters]
        for parameter in kind_of(element).sockets:
            if parameter in unused or parameter.name in ALWAYS_LIVE:
                continue
            socket = node.inputs[parameter.label]
            if socket.is_linked or animated and (node.name, list(node.inputs).index(socket)) in animated:
                result.append((index, parameter.name))
    return tuple(result)


def _animated(tree: bpy.types.NodeTree) -> set[tuple[str, int]]:
    """(node, input) pairs that drivers and keyframes move."""
    data = tree.animation_data
    if data is None:
        return set()
    curves = list(data.drivers)
    actions = [data.action] + [strip.action for track in data.nla_tracks for strip in track.strips]
    for action in filter(None, actions):
        curves += [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves]
    found = (_PATH.fullmatch(curve.data_path) for curve in curves)
    return {(bpy.utils.unescape_identifier(match[1]), int(match[2])) for match in found if match}
