# SPDX-License-Identifier: GPL-3.0-or-later
"""The means of what is linked to a material's values, kept on the nodes of the values.

They count wherever a link cannot be followed: in stock nodes, for what exporters find, in reports. They are measured where the user waits
anyway, before a shader is made, a save, a check and a conversion; whatever else reads them, a panel for instance, reads what is kept.
"""

import json

import bpy

from ...reference_py.material.schema import COLOR, FLOAT, Parameter
from .mask_groups import MASK_KEY
from .source_mean import has_images, is_painted, mean_of, name_of, picture_mean, source_of_socket, state_of

MEANS = "lamina_means"


def kept_mean(socket: bpy.types.NodeSocket) -> float | list[float] | None:
    """The mean that is kept of what is linked to a value's socket; None where nothing is linked, or nothing was measured."""
    row = _row(socket)
    return row["mean"] if row is not None else None


def kept_picture(socket: bpy.types.NodeSocket) -> list[float] | None:
    """The mean that is kept of the bare picture before a color's socket, see `picture_mean`; None as for `kept_mean`."""
    row = _row(socket)
    return row.get("picture", row["mean"]) if row is not None else None


def mean_name(socket: bpy.types.NodeSocket) -> str:
    """What a value's socket shows the mean of; empty where it shows its own value."""
    return name_of(source_of_socket(socket)) if kept_mean(socket) is not None else ""


def measure_node(node: bpy.types.Node, parameters: tuple[Parameter, ...]) -> bool:
    """Keep the means of what is linked to a value node's sockets; whether one changed. Only what is not known is measured."""
    former, rows = _rows(node), {}
    for parameter in parameters:
        socket = node.inputs.get(parameter.label)
        source = source_of_socket(socket) if socket is not None and parameter.type in (FLOAT, COLOR) else None
        if source is None:
            continue
        row, state = former.get(parameter.label), state_of(source, parameter)
        if row is None or row["state"] != state or is_painted(source) or (parameter.type == COLOR and "picture" not in row):
            mean = _mean(source, parameter, state)
            row = {"of": _address(source), "state": state, "mean": mean}
            if parameter.type == COLOR:
                row["picture"] = picture_mean(source, parameter) or mean
        rows[parameter.label] = row
    if rows == former:
        return False
    if rows:
        node[MEANS] = json.dumps(rows)
    else:
        del node[MEANS]
    return _means(rows) != _means(former)


def _means(rows: dict) -> dict:
    return {label: (row["mean"], row.get("picture")) for label, row in rows.items()}


# By their state, the means of generated masks that this session measured: what they are made of is all in them, unlike images.
_MOST_MEASURED = 256
_measured: dict[str, float | list[float]] = {}


def _mean(source: bpy.types.NodeSocket, parameter: Parameter, state: str) -> float | list[float]:
    group = getattr(source.node, "node_tree", None)
    if group is None or MASK_KEY not in group or any(socket.is_linked for socket in source.node.inputs) or has_images(source):
        return mean_of(source, parameter)
    if state not in _measured:
        if len(_measured) >= _MOST_MEASURED:
            _measured.pop(next(iter(_measured)))
        _measured[state] = mean_of(source, parameter)
    return _measured[state]


def _row(socket: bpy.types.NodeSocket) -> dict | None:
    source = source_of_socket(socket)
    row = _rows(socket.node).get(socket.name) if source is not None else None
    return row if row is not None and row["of"] == _address(source) else None


def _address(source: bpy.types.NodeSocket) -> list[str]:
    return [source.node.name, source.identifier]


def _rows(node: bpy.types.Node) -> dict:
    try:
        return json.loads(node.get(MEANS, "{}"))
    except (ValueError, TypeError):
        return {}
