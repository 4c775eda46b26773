# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks as pictures or attributes of meshes, for EEVEE and OptiX, which know no bevel. The generators stay, and draw live again by a click."""

from collections.abc import Sequence

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ..material.mask_groups import BAKED, OUTPUT
from ..material.masks import masks_in, remove_baked, show_baked
from .textures import BakeStudio, bake_studio

IMAGE, ATTRIBUTE = "IMAGE", "ATTRIBUTE"
_SAMPLES = 16
_GAP, _FALL = 220, 120


def bake_masks(material: bpy.types.Material, items: Sequence[bpy.types.Object], into: str, size: int = 1024) -> int:
    """Bake all masks of a material and let it show them; how many. `into` is IMAGE, of `size` pixels over the first item's UVs, or ATTRIBUTE, of all items.

    Raises LaminaError for what cannot be baked, before anything is changed.
    """
    masks = masks_in(material)
    if not masks:
        raise LaminaError("material {material} has no masks to bake; choose Add Mask first", material=material.name)
    for item in items:
        _require_bakeable(item, material, into)
    if into == ATTRIBUTE:
        names = [f"{material.name} {element.name} {socket.name}" for element, socket, _ in masks]
        baked = {item.name: _at_vertices(material, item, masks) for item in items}
        for item in items:
            for name, values in zip(names, baked[item.name]):
                _keep_attribute(item.data, name, values)
        for (_, _, node), name in zip(masks, names):
            _show_attribute(node, name)
    else:
        pictures = _pictures(material, items[0], masks, size)
        for (element, socket, node), pixels in zip(masks, pictures):
            _show_image(node, f"{material.name} {element.name} {socket.name}", pixels, items[0].data.uv_layers.active.name)
    return len(masks)


def draw_live(material: bpy.types.Material) -> int:
    """Let all masks draw live again, and drop the nodes of what was baked; how many were baked."""
    baked = [node for _, _, node in masks_in(material) if node.inputs[BAKED].is_linked]
    for node in baked:
        show_baked(node, False)
        remove_baked(node)
    return len(baked)


def _require_bakeable(item, material, into: str) -> None:
    if item is None or item.type != "MESH" or material.name_full not in [s.material.name_full for s in item.material_slots if s.material]:
        raise LaminaError("material {material}: select a mesh that has it", material=material.name)
    if item.mode != "OBJECT":
        raise LaminaError("object {object}: leave {mode} mode first", object=item.name, mode=item.mode.title())
    if into == IMAGE and not item.data.uv_layers:
        raise LaminaError("object {object} has no UV map; unwrap it first, or bake to an attribute", object=item.name)
    if into == ATTRIBUTE and not item.data.is_editable:
        raise LaminaError("object {object}: its mesh is linked from another file; make it local, or bake to an image", object=item.name)


def _drawn(studio: BakeStudio, node: bpy.types.Node) -> bpy.types.NodeSocket:
    """A generator's output, its twin in the studio made to draw live, from 0 to 1."""
    twin = studio.material.node_tree.nodes[node.name]
    show_baked(twin, False)
    for name, value in (("Low", 0.0), ("High", 1.0)):
        for link in twin.inputs[name].links:
            studio.material.node_tree.links.remove(link)
        twin.inputs[name].default_value = value
    return node.outputs[OUTPUT]


def _pictures(material, item, masks, size: int) -> list[np.ndarray]:
    with bake_studio(material, item, size, _SAMPLES) as studio:
        return [studio.baked(_drawn(studio, node), False)[..., 0] for _, _, node in masks]


def _at_vertices(material, item, masks) -> list[np.ndarray]:
    with bake_studio(material, item, 1, _SAMPLES, whole=True) as studio:
        return [studio.baked_at_vertices(_drawn(studio, node))[:, 0] for _, _, node in masks]


def _keep_attribute(mesh: bpy.types.Mesh, name: str, values: np.ndarray) -> None:
    found = mesh.attributes.get(name)
    if found is not None and (found.data_type, found.domain) != ("FLOAT", "POINT"):
        mesh.attributes.remove(found)
        found = None
    attribute = found or mesh.attributes.new(name, "FLOAT", "POINT")
    attribute.data.foreach_set("value", np.clip(values, 0.0, 1.0).astype(np.float32))
    mesh.update()


def _show_attribute(node: bpy.types.Node, name: str) -> None:
    remove_baked(node)
    source = _beside(node, "ShaderNodeAttribute", 1)
    source.attribute_type, source.attribute_name = "GEOMETRY", name
    _show(node, source.outputs["Fac"])


def _show_image(node: bpy.types.Node, name: str, pixels: np.ndarray, uv_map: str) -> None:
    remove_baked(node)
    height, width = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=False)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = np.clip(pixels[::-1, :, None], 0.0, 1.0)
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    source, place = _beside(node, "ShaderNodeTexImage", 1), _beside(node, "ShaderNodeUVMap", 2)
    source.image, place.uv_map = image, uv_map
    node.id_data.links.new(place.outputs["UV"], source.inputs["Vector"])
    _show(node, source.outputs["Color"])


def _beside(node, kind: str, column: int) -> bpy.types.Node:
    made = node.id_data.nodes.new(kind)
    made.select, made.hide, made.location = False, True, (node.location_absolute.x - column * _GAP, node.location_absolute.y - _FALL)
    return made


def _show(node, source: bpy.types.NodeSocket) -> None:
    node.id_data.links.new(source, node.inputs[BAKED])
    show_baked(node, True)


def sharing(material: bpy.types.Material, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The meshes of a scene that have a material."""
    return [item for item in scene.objects if item.type == "MESH" and material.name_full in [s.material.name_full for s in item.material_slots if s.material]]
