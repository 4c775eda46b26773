# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes read of the things that show a material: attributes of meshes, spread over points of their surfaces, and values of objects, view layer and scene.

Cycles gives 0 for what a thing does not have, and so does a mean where nothing shows the material.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np

ACTIVE = ""
"""The name under which the active color attribute is read."""
# By the type of an attribute: the property of its items, its type and its size.
_READ_AS = {
    "FLOAT": ("value", np.float32, 1), "INT": ("value", np.int32, 1), "INT8": ("value", np.int32, 1), "BOOLEAN": ("value", bool, 1),
    "FLOAT2": ("vector", np.float32, 2), "FLOAT_VECTOR": ("vector", np.float32, 3), "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
}  # fmt: skip


@dataclass
class ShownValues:
    """Values by name: of meshes (n, 4) as colors; of all else (m,), means over the objects; and the objects' mean color, where one is read."""

    surface: dict[str, np.ndarray] = field(default_factory=dict)
    objects: dict[str, np.ndarray] = field(default_factory=dict)
    scene: dict[str, np.ndarray] = field(default_factory=dict)
    object_color: np.ndarray | None = None

    def dress(self, scene: bpy.types.Scene, item: bpy.types.Object) -> None:
        """Give a scene and an object, whose mesh has a square for each point, what was read."""
        for name, values in self.surface.items():
            attribute = item.data.color_attributes.new(name or "Lamina Active", "FLOAT_COLOR", "CORNER")
            attribute.data.foreach_set("color", np.repeat(values, 4, axis=0).astype(np.float32).ravel())
            if name == ACTIVE:
                item.data.attributes.default_color_name = attribute.name
        for block, group in ((item, self.objects), (scene, self.scene)):
            for name, value in group.items():
                block[name] = value.tolist() if len(value) > 1 else float(value[0])
        if self.object_color is not None:
            item.color = self.object_color

    def words(self) -> Iterator[str]:
        """All of it, as text."""
        for group in (self.surface, self.objects, self.scene):
            for name, values in group.items():
                yield f"{name} {values.tobytes().hex()}"
        if self.object_color is not None:
            yield f"object color {self.object_color.tobytes().hex()}"


def shown_values(nodes: list[bpy.types.Node], tree: bpy.types.NodeTree, count: int) -> ShownValues:
    """What nodes of a material, whose tree this is, read of what shows it; of surfaces at `count` points, the more the larger a face is."""
    result = ShownValues()
    attributes = [(n.attribute_type, n.attribute_name) for n in nodes if n.bl_idname == "ShaderNodeAttribute" and n.attribute_name]
    on_surface = {name for kind, name in attributes if kind == "GEOMETRY"} | {n.layer_name for n in nodes if n.bl_idname == "ShaderNodeVertexColor"}
    on_objects = {name for kind, name in attributes if kind in ("OBJECT", "INSTANCER")}
    is_colored = any(n.bl_idname == "ShaderNodeObjectInfo" for n in nodes)
    for name in sorted({name for kind, name in attributes if kind == "VIEW_LAYER"}):
        scene = bpy.context.scene
        _keep(result.scene, name, [_value_of((bpy.context.view_layer, scene, scene.world), name)])
    if not (on_surface or on_objects or is_colored):
        return result
    owner = next((m for m in bpy.data.materials if m.node_tree == tree), None)
    things = sorted((o for o in bpy.data.objects if owner is not None and any(slot.material == owner for slot in o.material_slots)), key=lambda o: o.name_full)
    for name in sorted(on_objects):
        _keep(result.objects, name, [_value_of((thing, thing.data), name) for thing in things])
    if is_colored and things:
        result.object_color = np.mean([thing.color for thing in things], axis=0)
    for name in sorted(on_surface):
        if (spread := _spread(list(_on_faces(things, owner, name)), count)) is not None:
            result.surface[name] = spread
    return result


def _spread(parts: list[tuple[np.ndarray, np.ndarray]], count: int) -> np.ndarray | None:
    """Values (count, 4), of the more area the more often; None where there is no area."""
    values, areas = (np.concatenate(column) for column in zip(*parts, (np.zeros((1, 4)), np.zeros(1))))
    ends = np.cumsum(areas)
    return values[np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1])] if ends[-1] > 0.0 else None


def _keep(group: dict[str, np.ndarray], name: str, values: list[np.ndarray | None]) -> None:
    known = [value for value in values if value is not None]
    if known and len({len(value) for value in known}) == 1:
        group[name] = np.mean([np.zeros_like(known[0]) if value is None else value for value in values], axis=0)


def _value_of(blocks: tuple, name: str) -> np.ndarray | None:
    """The numbers of a name, as Cycles looks for them: properties of users first, then Blender's own."""
    for find in (lambda block: block[name], lambda block: block.path_resolve(name)):
        for block in blocks:
            try:
                return np.atleast_1d(np.array(find(block), float))
            except (KeyError, TypeError, ValueError, AttributeError):
                continue
    return None


def _on_faces(things: list[bpy.types.Object], owner: bpy.types.Material, name: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """An attribute's colors at the corners of the faces that show a material, (n, 4), and the area of each, a mesh at a time.

    What a mesh lacks its modifiers may give; what neither has is 0.
    """
    shared: dict[tuple[bpy.types.Mesh, tuple[int, ...]], int] = {}
    for thing in things:
        if thing.type != "MESH":
            continue
        mesh, slots = thing.data, tuple(i for i, slot in enumerate(thing.material_slots) if slot.material == owner)
        graph = bpy.context.view_layer.depsgraph
        if thing.modifiers and graph is not None and _attribute(mesh, name) is None and isinstance(thing.evaluated_get(graph).data, bpy.types.Mesh):
            yield _colors(thing.evaluated_get(graph).data, slots, name)
        else:
            shared[mesh, slots] = shared.get((mesh, slots), 0) + 1
    for (mesh, slots), users in shared.items():
        with _at_rest(mesh) as readable:
            colors, areas = _colors(readable, slots, name)
        yield colors, users * areas


@contextmanager
def _at_rest(mesh: bpy.types.Mesh) -> Iterator[bpy.types.Mesh]:
    """A mesh whose attributes can be read: of one that is being edited a copy, as it was before."""
    if not mesh.is_editmode:
        yield mesh
        return
    copy = mesh.copy()
    try:
        yield copy
    finally:
        bpy.data.meshes.remove(copy)


def _colors(mesh: bpy.types.Mesh, own: tuple[int, ...], name: str) -> tuple[np.ndarray, np.ndarray]:
    slots, totals, areas = (_read(mesh.polygons, key, dtype) for key, dtype in (("material_index", np.int32), ("loop_total", np.int32), ("area", np.float32)))
    face_of = np.repeat(np.arange(len(totals)), totals)
    shows = np.isin(np.minimum(slots, max(len(mesh.materials) - 1, 0)), own)[face_of]
    weights = (areas / np.maximum(totals, 1))[face_of][shows].astype(float)
    attribute = _attribute(mesh, name)
    if attribute is None:
        return np.zeros((len(weights), 4)), weights
    where = {"POINT": lambda: _read(mesh.loops, "vertex_index", np.int32), "FACE": lambda: face_of, "CORNER": lambda: slice(None)}[attribute.domain]()
    key, dtype, size = _READ_AS[attribute.data_type]
    values = _read(attribute.data, key, dtype, size)[where][shows].astype(float)
    rgb = np.repeat(values, 3, axis=1) if size == 1 else np.pad(values[:, :3], ((0, 0), (0, max(3 - size, 0))))
    return np.concatenate([rgb, values[:, 3:] if size == 4 else np.ones((len(rgb), 1))], axis=1), weights


def _read(rows, key: str, dtype: type, size: int = 0) -> np.ndarray:
    """One property of all rows, (n,), or (n, size)."""
    flat = np.zeros(len(rows) * max(size, 1), dtype)
    rows.foreach_get(key, flat)
    return flat.reshape(-1, size) if size else flat


def _attribute(mesh, name: str):
    """An attribute that Cycles reads and this does; None where there is none."""
    found = mesh.attributes.get(mesh.attributes.default_color_name if name == ACTIVE else name)
    return found if found is not None and found.data_type in _READ_AS and found.domain in ("POINT", "FACE", "CORNER") else None
