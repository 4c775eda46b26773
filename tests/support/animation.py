# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyframes, drivers and NLA strips on sockets, and what a tree has of them."""

from collections.abc import Callable, Mapping

import bpy


def keyed(socket, values: Mapping[int, float], index: int = -1) -> None:
    """Linear keyframes of a socket's value, or of one of its components, by frame."""
    for frame, value in values.items():
        if index < 0:
            socket.default_value = value
        else:
            socket.default_value[index] = value
        socket.keyframe_insert("default_value", frame=frame, index=index)
    for bag in _bags(socket.id_data.animation_data.action):
        for curve in bag.fcurves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"


def driven(socket, expression: str, index: int = -1) -> None:
    """A driver on a socket's value, or on one of its components or all."""
    made = socket.driver_add("default_value", index)
    for curve in made if isinstance(made, list) else [made]:
        curve.driver.expression = expression


def strip(tree, animate: Callable[[], None]) -> None:
    """What `animate` keys, pushed down into an NLA strip of its own; the tree has no action afterwards."""
    data = tree.animation_data_create()
    data.action = None
    animate()
    action = data.action
    data.action = None
    data.nla_tracks.new().strips.new(action.name, 1, action)


def at_frame(frame: int, socket, index: int = -1) -> float:
    """A socket's value, or a component of it, at a frame."""
    bpy.context.scene.frame_set(frame)
    return socket.default_value if index < 0 else socket.default_value[index]


def curves_of(tree) -> list[tuple[str, int]]:
    """(path, component) of everything that animates a tree."""
    data = tree.animation_data
    if data is None:
        return []
    actions = [data.action, *(s.action for track in data.nla_tracks for s in track.strips)]
    curves = [*data.drivers, *(curve for action in filter(None, actions) for bag in _bags(action) for curve in bag.fcurves)]
    return sorted((curve.data_path, curve.array_index) for curve in curves)


def _bags(action) -> list:
    return [bag for layer in action.layers for s in layer.strips for bag in s.channelbags]
