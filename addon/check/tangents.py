# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the direction of brushing is known: the Tangent node takes it from a UV map, and without one rings lie around a pole."""

import bpy

from ...reference_py.material.schema import ANISOTROPY
from ..material.elements import find_node, kind_of, used_features
from ..material.roles import node_with
from ..shader.inputs import TANGENT


def without_uv_map(material: bpy.types.Material, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """A mesh object of the scene that shows a brushed material and lacks the UV map of its Tangent node; None where there is none."""
    tangent = node_with(material, TANGENT)
    if tangent is None or getattr(tangent, "direction_type", "") != "UV_MAP" or not tangent.outputs[0].is_linked or not _is_brushed(material):
        return None
    shown = (o for o in scene.objects if o.type == "MESH" and any(slot.material == material for slot in o.material_slots))
    return next((item for item in shown if not _has_map(item, tangent.uv_map)), None)


def _is_brushed(material) -> bool:
    """Whether a shown layer or the base has an anisotropy that is not 0."""
    strength, lamina = ANISOTROPY.parameters[0].label, material.lamina
    nodes = [find_node(e) for e in (*lamina.shown_layers, lamina.base) if ANISOTROPY in kind_of(e).features and ANISOTROPY in used_features(e)]
    sockets = [node.inputs[strength] for node in nodes if node is not None and strength in node.inputs]
    return any(socket.is_linked or socket.default_value != 0.0 for socket in sockets)


def _has_map(item, name: str) -> bool:
    """Of a mesh with modifiers, which may give it one, what Blender has evaluated counts."""
    mesh = item.data
    graph = bpy.context.view_layer.depsgraph if item.modifiers else None
    if graph is not None and isinstance(item.evaluated_get(graph).data, bpy.types.Mesh):
        mesh = item.evaluated_get(graph).data
    return name in mesh.uv_layers if name else bool(mesh.uv_layers)
