# SPDX-License-Identifier: GPL-3.0-or-later
"""A base that becomes one of another kind: what both kinds have stays, and what does not is named."""

import json

import bpy

from ...reference_py.material.schema import Kind
from ...reference_py.material.stack import Stack
from .elements import element_parameters, fill_element, find_node, kind_of, node_of, used_features
from .live_values import what_moves
from .node_copy import copy_inputs


def change_kind(tree: bpy.types.NodeTree, base, kind: Kind) -> None:
    """Give the base a node of another kind, with values, textures and animation of all that both kinds have.

    The former node stays in the tree; where somebody deleted it, values are the schema's defaults.
    """
    former, former_kind = find_node(base), kind_of(base)
    known = {p.name for p in kind.all_parameters}
    data = {key: value for key, value in json.loads(base.unknown or "{}").items() if key not in known}
    if base.name != former_kind.label:
        data["name"] = base.name
    if former is not None:
        data |= {p.name: getattr(base, p.name) for p in former_kind.structure if p in kind.structure}
        data |= {p.name: p.default for f in used_features(base) if f in kind.features for p in f.parameters}
    fill_element(tree, base, Stack.from_dict({"base": {**data, "kind": kind.name}}).base, kind)
    if former is not None:
        copy_inputs(former, node_of(base))


def lost_by_change(base, kind: Kind) -> list[tuple[str, str]]:
    """What the base has and one of another kind has not, as (label, what moves it): "texture", "animation" or ""."""
    moving = what_moves(base)
    shown = element_parameters(base, kind_of(base), base.given)
    had = [p for p in kind_of(base).all_parameters if p in shown or p.name in moving]
    return [(p.label, moving.get(p.name, "")) for p in had if p not in kind.all_parameters]
