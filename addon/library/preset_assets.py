# SPDX-License-Identifier: GPL-3.0-or-later
"""Own presets as material assets: one .blend each, with the textures of its layers, to drop or to dress a material with.

A file holds one material of the preset's layers, made for it, and packed images. The user's own material, images
and names are as before when it is written.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.material.stack import Stack
from ..blender.blend_files import save_material
from ..blender.translation import rpt_
from ..material import material as materials
from ..material.elements import node_of
from ..material.node_copy import channel_bags, copy_sources
from ..material.shader_node import remove_material
from . import user_presets
from .thumbnails import give_preview, pixels_of, render_thumbnail

_TEMPORARY = "Lamina Preset"
_FILES = ("FILE", "TILED")


def save(material: bpy.types.Material, name: str, stack: Stack, catalogue: str) -> tuple[str, str]:
    """Keep a material's stack as a preset of a catalogue, with its picture and its asset. Returns what `user_presets.save` does. Raises LaminaError."""
    require_savable(material)

    def keep(path: Path) -> None:
        picture = path.with_suffix(".png")
        write_asset(path, material, stack, catalogue, pixels_of(picture) if picture.is_file() else None)

    return user_presets.save(name, stack, lambda path: render_thumbnail(material, path), keep)


def dress(source: bpy.types.Material, target: bpy.types.Material) -> None:
    """Give the layers of a material the textures of those shown of another, which has the same. Raises LaminaError where it has not."""
    pairs = list(zip(_shown(source), _shown(target)))
    if [a.kind for a in _shown(source)] != [b.kind for b in _shown(target)]:
        raise LaminaError("the layers of {source} are others than those of {target}, so its textures fit nowhere", source=source.name, target=target.name)
    before = set(target.node_tree.nodes)
    try:
        for former, element in pairs:
            copy_sources(node_of(former), node_of(element))
    except Exception:
        for node in set(target.node_tree.nodes) - before:
            target.node_tree.nodes.remove(node)
        raise


def _shown(material) -> list:
    return [*material.lamina.shown_layers, material.lamina.base]


def left_out(material: bpy.types.Material) -> list[str]:
    """What a preset of a material leaves out, one sentence each, to be read before it is saved."""
    sentences = []
    if hidden := len(material.lamina.layers) - len(material.lamina.shown_layers):
        sentences.append(rpt_("Hidden layers stay behind: {count}").format(count=hidden))
    data = material.node_tree.animation_data
    if data is not None and (len(data.drivers) or any(len(bag.fcurves) for bag in channel_bags(data))):
        sentences.append(rpt_("Drivers and keyframes stay behind; values are those of now"))
    nodes = _feeding(material)
    for node in nodes:
        if getattr(node, "object", None) is not None:
            sentences.append(rpt_("The object of {node} stays behind").format(node=node.label or node.name))
    for image in _images(nodes):
        if image.source not in (*_FILES, "GENERATED") or image.library is not None:
            sentences.append(rpt_("{image} stays a file of its own, which the preset points to").format(image=image.name))
    return sentences


def require_savable(material: bpy.types.Material) -> None:
    """Raise LaminaError for a texture that cannot come along as it looks now."""
    for image in _images(_feeding(material)):
        if image.source == "FILE" and image.packed_file is None and not Path(bpy.path.abspath(image.filepath, library=image.library)).is_file():
            raise LaminaError("image {image} cannot come along: there is no file {path}", image=image.name, path=image.filepath)
        if image.is_dirty:
            raise LaminaError("image {image} has changes that are not saved, and a preset takes it as it is saved; save or pack it first", image=image.name)


def _feeding(material) -> list[bpy.types.Node]:
    """The nodes that give values to the shown layers and the base."""
    left, found = [node_of(element) for element in _shown(material)], {}
    values = {node.name for node in left}
    while left:
        for socket in left.pop().inputs:
            for link in socket.links:
                if link.from_node.name not in found and link.from_node.name not in values:
                    found[link.from_node.name] = link.from_node
                    left.append(link.from_node)
    return list(found.values())


def _images(nodes: Sequence[bpy.types.Node]) -> list[bpy.types.Image]:
    """The images of nodes, and of the groups among them."""
    found, groups, left = {}, set(), list(nodes)
    while left:
        node = left.pop()
        if (image := getattr(node, "image", None)) is not None:
            found[image.name_full] = image
        group = getattr(node, "node_tree", None)
        if group is not None and group.name_full not in groups:
            groups.add(group.name_full)
            left += group.nodes
    return list(found.values())


def _to_pack(nodes: Sequence[bpy.types.Node]) -> list[bpy.types.Image]:
    return [image for image in _images(nodes) if image.source in _FILES and image.packed_file is None and image.library is None]


def _dress_alone(material: bpy.types.Material, new: bpy.types.Material) -> None:
    dress(material, new)
    _without_scene(new)


def write_asset(path: Path, material: bpy.types.Material, stack: Stack, catalogue: str, pixels: np.ndarray | None) -> None:
    """Write `stack` with the textures of `material` as an asset; `pixels` as of a PNG are its picture. Raises LaminaError."""
    lamina = material.lamina
    made = bpy.data.materials.new(_TEMPORARY)
    try:
        materials.apply_stack(made, stack, lamina.tier, lamina.backend, lambda new: _dress_alone(material, new))
        made.asset_mark()
        data = made.asset_data
        data.catalog_id, data.description = catalogue, stack.source
        data.tags.new("Lamina")
        if pixels is not None:
            give_preview(made, pixels)
        with _named(made, stack.name), _packed(_to_pack(_feeding(made))):
            save_material(path, made)
    finally:
        remove_material(made)


def _without_scene(material) -> None:
    """Drop what would take other things of the scene into the file: animation, and objects that textures look at."""
    tree = material.node_tree
    for node in tree.nodes:
        if getattr(node, "object", None) is not None:
            node.object = None
    action = tree.animation_data.action if tree.animation_data is not None else None
    tree.animation_data_clear()
    if action is not None:
        bpy.data.actions.remove(action)


@contextmanager
def _named(material, name: str) -> Iterator[None]:
    """A material of just this name, as an asset is called; one that has it already is called so again afterwards."""
    other = next((m for m in bpy.data.materials if m.name == name and m.library is None), None)
    if other is not None:
        other.name = f"{_TEMPORARY} {name}"[:63]
    try:
        material.name = name
        yield
    finally:
        material.name = _TEMPORARY
        if other is not None:
            other.name = name


@contextmanager
def _packed(images: Sequence[bpy.types.Image]) -> Iterator[None]:
    """Images that are files are packed in the block, and files again after it. Raises LaminaError for a file that is gone."""
    packed = []
    try:
        for image in images:
            try:
                image.pack()
            except RuntimeError as error:
                raise LaminaError("image {image} cannot come along: {reason}", image=image.name, reason=" ".join(str(error).split())) from None
            packed.append(image)
        yield
    finally:
        for image in packed:
            image.unpack(method="REMOVE")


@contextmanager
def asset_of(path: Path) -> Iterator[bpy.types.Material]:
    """The material of a preset's file, in the open file during the block; what nothing uses then is gone after it. Raises LaminaError."""
    kinds = ("materials", "node_groups", "images", "texts")
    before = {kind: set(getattr(bpy.data, kind)) for kind in kinds}
    try:
        with bpy.data.libraries.load(str(path), link=False, assets_only=True) as (there, here):
            here.materials = list(there.materials)[:1]
    except (OSError, RuntimeError) as error:
        raise LaminaError("{path}: Blender cannot read the preset's textures: {reason}", path=path, reason=" ".join(str(error).split())) from None
    if not here.materials or here.materials[0] is None:
        raise LaminaError("{path}: there is no material in this file of a preset", path=path)
    try:
        yield here.materials[0]
    finally:
        remove_material(here.materials[0])
        for kind in kinds[1:]:
            for item in set(getattr(bpy.data, kind)) - before[kind]:
                if item.users == 0:
                    getattr(bpy.data, kind).remove(item)
