# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as textures for game engines: Principled's inputs, baked over an object's UV map where they have textures.

All happens in a scene and on copies of its own, which are gone afterwards, so the user's file is left alone. The base
color is corrected per texel, by the map that keeps the mean albedo, and has a coat's tint and the color of films too: no picture holds those.
"""

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.matching import ColorMap
from ...reference_py.exchange.principled import DEFAULTS, to_principled
from ...reference_py.optics.colour import srgb_encoded
from ..blender.images import require_pictures, write_png
from ..blender.versions import node_tree
from ..material import material as materials
from ..material.principled_node import linked_places
from ..material.reading import measured_stack
from ..rendering.settings import remove_scene
from ..shader.working_space import out_of_working

_MARGIN, _SAMPLES = 8, 4
_FLAT_NORMAL = 0.5, 0.5, 1.0
# Files, by the socket that each holds. The last four are written only where the material has them.
CHANNELS = {
    "Base Color": "base_color", "Roughness": "roughness", "Metallic": "metallic", "Normal": "normal",
    "Coat Weight": "coat", "Coat Roughness": "coat_roughness", "Coat Normal": "coat_normal",
}  # fmt: skip
_ALWAYS = ("Base Color", "Roughness", "Metallic")
NORMALS = ("Normal", "Coat Normal")


class TextureBake:
    """One bake. `steps` does it, yielding the share done; closing it cancels, and leaves nothing behind."""

    def __init__(self, material: bpy.types.Material, item: bpy.types.Object, folder: str | os.PathLike, size: int):
        """Raises LaminaError for an object without the material or without UVs, before any work."""
        self.material, self.item, self.size = material, item, size
        self.folder, self.files, self.report = Path(folder), [], None
        can_be_baked(material, item)
        materials.require_layered(material)

    def steps(self) -> Iterator[float]:
        """Bake; yields the share done. Raises LaminaError."""
        require_pictures()
        folder = output_folder(self.folder)
        yield 0.0
        places = {socket: source for socket, _, _, source in linked_places(self.material, {"base": -1})}
        converted = to_principled(measured_stack(self.material), textured="Base Color" in places, exported=True)
        self.report = converted.report
        linked = {socket: source for socket, _, _, source in linked_places(self.material, converted.owners)}
        values = DEFAULTS | converted.values
        wanted = [c for c in CHANNELS if c in _ALWAYS or c in linked or (c.startswith("Coat") and c not in NORMALS and values["Coat Weight"] > 0.0)]
        yield 0.1
        with tempfile.TemporaryDirectory(dir=folder, prefix=".bake.") as scratch, bake_studio(self.material, self.item, self.size) as studio:
            for number, channel in enumerate(wanted):
                if channel in linked:
                    pixels = corrected(studio.baked(linked[channel], channel in NORMALS), channel, converted.colors)
                else:
                    value = _FLAT_NORMAL if channel in NORMALS else values[channel]
                    pixels = np.broadcast_to(np.asarray(value, float), (self.size, self.size, 3))
                write_png(Path(scratch, self._name(channel)), stored(pixels, channel == "Base Color"))
                yield 0.1 + 0.9 * (number + 1) / len(wanted)
            text = json.dumps({"material": self.material.name, "values": converted.values, "report": converted.report.lines()}, indent=2)
            Path(scratch, self._name("")).write_text(text + "\n", encoding="utf-8")
            for channel in (*wanted, ""):
                target = folder / self._name(channel)
                os.replace(Path(scratch, target.name), target)
                self.files.append(target)

    def _name(self, channel: str) -> str:
        stem = bpy.path.clean_name(self.material.name)
        return f"{stem}_{CHANNELS[channel]}.png" if channel else f"{stem}_principled.json"


def can_be_baked(material: bpy.types.Material, item: bpy.types.Object | None) -> None:
    """Raises LaminaError for an object without the material or without UVs."""
    if item is None or item.type != "MESH" or material.name_full not in [s.material.name_full for s in item.material_slots if s.material]:
        raise LaminaError("material {material}: select a mesh that has it", material=material.name)
    if item.mode != "OBJECT":
        raise LaminaError("object {object}: leave {mode} mode first", object=item.name, mode=item.mode.title())
    if not item.data.uv_layers:
        raise LaminaError("object {object} has no UV map; unwrap it first", object=item.name)


def corrected(pixels: np.ndarray, channel: str, colors: ColorMap | None) -> np.ndarray:
    """What was baked for one of CHANNELS; of a color, in linear Rec.709 and by the map that keeps the mean albedo, if there is one."""
    if channel != "Base Color":
        return pixels
    return out_of_working(pixels) if colors is None else colors(out_of_working(pixels))


def stored(pixels: np.ndarray, is_color: bool) -> np.ndarray:
    """8 bits: sRGB for colors, linear for data."""
    pixels = np.clip(pixels, 0.0, 1.0)
    if is_color:
        pixels = srgb_encoded(pixels)
    return (255.0 * pixels + 0.5).astype(np.uint8)


class BakeStudio:
    """A scene with a copy of the object, which has a copy of the material alone, and the image that is baked into."""

    def __init__(self, scene, item, material, image, size: int):
        self._scene, self._item, self.material, self._image, self._size = scene, item, material, image, size

    def baked(self, source: bpy.types.NodeSocket, is_normal: bool) -> np.ndarray:
        """What a socket of the original gives over the UVs, (size, size, 3), top row first; normals in tangent space, as colors."""
        self._bake(source, is_normal, "IMAGE_TEXTURES")
        pixels = np.empty(self._size * self._size * 4, np.float32)
        self._image.pixels.foreach_get(pixels)
        return pixels.reshape(self._size, self._size, 4)[::-1, :, :3].astype(float)

    def baked_at_vertices(self, source: bpy.types.NodeSocket) -> np.ndarray:
        """What a socket of the original gives at the vertices of a studio's whole mesh, (n, 3)."""
        mesh = self._item.data
        colors = mesh.color_attributes.new("Lamina", "FLOAT_COLOR", "POINT")
        mesh.color_attributes.active_color = colors
        self._bake(source, False, "VERTEX_COLORS")
        values = np.empty(4 * len(mesh.vertices), np.float32)
        # a bake may leave what was taken before it behind
        mesh.color_attributes["Lamina"].data.foreach_get("color", values)
        mesh.color_attributes.remove(mesh.color_attributes["Lamina"])
        return values.reshape(-1, 4)[:, :3].astype(float)

    def _bake(self, source: bpy.types.NodeSocket, is_normal: bool, into: str) -> None:
        tree = self.material.node_tree
        twin = tree.nodes[source.node.name].outputs[list(source.node.outputs).index(source)]
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse" if is_normal else "ShaderNodeEmission")
        tree.links.new(twin, shader.inputs["Normal" if is_normal else "Color"])
        output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        layer = self._scene.view_layers[0]
        target = {"object": self._item, "active_object": self._item, "selected_objects": [self._item], "selected_editable_objects": [self._item]}
        try:
            with bpy.context.temp_override(scene=self._scene, view_layer=layer, **target):
                bpy.ops.object.bake(type="NORMAL" if is_normal else "EMIT", margin=_MARGIN, use_clear=True, target=into, save_mode="INTERNAL")
        except RuntimeError as error:
            raise LaminaError("material {material}: Blender cannot bake it: {reason}", material=self.material.name, reason=str(error).strip()) from None
        finally:
            tree.nodes.remove(shader)


@contextmanager
def bake_studio(material: bpy.types.Material, item: bpy.types.Object, size: int, samples: int = _SAMPLES, whole: bool = False) -> Iterator[BakeStudio]:
    """A scene to bake a material of an object in: of the mesh after its modifiers the faces that have it, or, `whole`, of the mesh before them all.

    Raises LaminaError for an object of which no face has the material.
    """
    scene = bpy.data.scenes.new("Lamina Textures")
    made: list[bpy.types.ID] = []
    try:
        copy = material.copy()
        made.append(copy)
        copy.property_unset("lamina")  # nothing that looks after stacks is to look after it
        image = bpy.data.images.new("Lamina Textures", size, size, alpha=False, float_buffer=True)
        made.append(image)
        image.colorspace_settings.name = "Non-Color"
        node = node_tree(copy).nodes.new("ShaderNodeTexImage")
        node.image, copy.node_tree.nodes.active = image, node
        mesh = item.data.copy() if whole else _mesh_of(item, material)
        mesh.materials.clear()
        mesh.materials.append(copy)
        twin = bpy.data.objects.new(item.name, mesh)
        twin.matrix_world = item.matrix_world
        scene.collection.objects.link(twin)
        scene.render.engine = "CYCLES"
        scene.cycles.samples, scene.cycles.device, scene.cycles.use_adaptive_sampling = samples, "CPU", False
        scene.cycles.shading_system = bpy.context.scene.cycles.shading_system
        scene.frame_set(bpy.context.scene.frame_current)
        layer = scene.view_layers[0]
        layer.objects.active = twin
        twin.select_set(True, view_layer=layer)
        yield BakeStudio(scene, twin, copy, image, size)
    finally:
        remove_scene(scene)
        for block in made:
            bpy.data.batch_remove([block])


def _mesh_of(item: bpy.types.Object, material: bpy.types.Material) -> bpy.types.Mesh:
    """The object's mesh after its modifiers, with the faces of this material alone."""
    import bmesh

    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bpy.data.meshes.new_from_object(evaluated)
    mine = {i for i, slot in enumerate(item.material_slots) if slot.material is not None and slot.material.name_full == material.name_full}
    edit = bmesh.new()
    edit.from_mesh(mesh)
    bmesh.ops.delete(edit, geom=[face for face in edit.faces if face.material_index not in mine], context="FACES")
    for face in edit.faces:
        face.material_index = 0
    if not edit.faces:
        edit.free()
        bpy.data.meshes.remove(mesh)
        raise LaminaError("object {object}: no face has the material {material}", object=item.name, material=material.name)
    edit.to_mesh(mesh)
    edit.free()
    return mesh
