# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of MaterialX files as Lamina materials, with their images as textures."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.exchange.conversion import Converted
from ...reference_py.exchange.materialx import AnyMaterial, load_mtlx
from ...reference_py.exchange.materialx_image import TILES, Image
from ...reference_py.exchange.report import KEPT, LOST, Report, noted
from ...reference_py.material.place import Place
from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import canonical, is_known
from ..material import material as materials
from ..material.elements import kind_of, node_of
from ..material.means import mean_name
from ..material.principled_node import link_through, parameter_of
from ..material.state import is_followed
from .image_means import with_means

# Blender's names of color spaces; an image of another one is told.
_SPACES = {
    "": "Non-Color", "srgb_rec709": "sRGB", "lin_rec709": "Linear Rec.709", "lin_ap1": "ACEScg", "lin_ap0": "ACES2065-1", "lin_rec2020": "Linear Rec.2020",
    "lin_p3d65": "Linear DCI-P3 D65", "g24_rec709": "Rec.1886",
}  # fmt: skip
_APART = 300
_CHANNELS = ("Red", "Green", "Blue")


@dataclass(frozen=True)
class Imported:
    """A material, what became of its values, and a sentence for each image."""

    material: bpy.types.Material
    report: Report
    notes: list[Sentence]


def import_materials(path: str, chosen: Callable[[bpy.types.Material], tuple[str, str]]) -> tuple[list[Imported], list[Sentence]]:
    """A new material for every one of a file, and a sentence for each that no stack can show.

    Raises LaminaError, and leaves nothing behind, where the file cannot be read or none can be shown.
    """
    made: list[Imported] = []
    left_out: list[LaminaError] = []
    try:
        for source in load_mtlx(path):
            target = bpy.data.materials.new(source.name or "Lamina")
            try:
                made.append(apply_material(target, source, *chosen(target)))
            except LaminaError as error:
                bpy.data.materials.remove(target)
                left_out.append(error)
            except Exception:
                bpy.data.materials.remove(target)
                raise
    except Exception:
        for imported in made:
            bpy.data.materials.remove(imported.material)
        raise
    if not made:
        raise left_out[0]
    return made, [noted(LOST, error.sentence) for error in left_out]


def apply_material(target: bpy.types.Material, source: AnyMaterial, tier: str, backend: str) -> Imported:
    """Give a material the stack and the images of one of a file. Raises LaminaError, and leaves it as it was."""
    there = [given for given, image in source.images.items() if image.files]
    gone = [(given, image.file) for given, image in source.images.items() if given not in there]
    notes = [noted(LOST, Sentence("{given} image {file}: there is no such file", given=given, file=file)) for given, file in gone]
    # what else the file says is solved where its images are in the mean
    source, unread = with_means(source, there)
    notes += [noted(LOST, error.sentence) for error in unread]
    converted = source.to_stack(frozenset(source.images) - frozenset(there))
    places = {given: source.places(given, converted) for given in there}
    stack = _with_linked_features(converted, places)

    linked: dict[str, list[Place]] = {}

    def link(material: bpy.types.Material) -> None:
        outputs: dict[Image, bpy.types.NodeSocket] = {}
        for row, given in enumerate(there):
            linked[given] = _link(material, places[given], source.images[given], outputs, converted, row, notes)

    materials.apply_stack(target, stack, tier, backend, link)
    for given, ways in linked.items():
        is_through = converted.colors is not None and (-1, "color") in places[given]
        notes.append(_told(target, ways, is_through, {"given": given, "file": Path(source.images[given].file).name}))
    return Imported(target, converted.report, notes)


def _with_linked_features(converted: Converted, places: dict[str, list[tuple[int, str]]]) -> Stack:
    data = converted.stack.to_dict()
    rows = [*data["layers"], data["base"]]
    for index, parameter in (place for found in places.values() for place in found):
        if parameter in ("normal", "coverage"):
            rows[index].setdefault(parameter, [0.0, 0.0, 0.0] if parameter == "normal" else 1.0)
    return Stack.from_dict(data, converted.stack.name or "MaterialX")


def _link(
    material: bpy.types.Material, places: list[tuple[int, str]], image: Image, outputs: dict, converted: Converted, row: int, notes: list[Sentence]
) -> list[Place]:
    """Link one image to what its input became; returns these places, and adds to `notes` how it is read otherwise."""
    elements = [*material.lamina.shown_layers, material.lamina.base]
    linked = []
    for index, name in places:
        element = elements[index]
        kind, parameter = kind_of(element), parameter_of(element, name)
        if parameter not in {p.name for p in kind.given_by(element.given)} | {p.name for f in kind.features for p in f.parameters}:
            continue
        target = node_of(element).inputs[kind.parameter(parameter).label]
        if image not in outputs:
            outputs[image] = _texture(material.node_tree, image, target.node.location_absolute, row, notes)
        if index < 0 and name == "color" and converted.colors is not None:
            link_through(outputs[image], target, converted.colors)
        else:
            material.node_tree.links.new(outputs[image], target)
        linked.append(Place(None if element == material.lamina.base else index, parameter))
    return linked


def _told(material: bpy.types.Material, linked: list[Place], is_through: bool, words: dict) -> Sentence:
    """What became of an image that is linked to these places."""
    if not linked:
        return noted(LOST, Sentence("{given} image {file}: the stack has no place for it", **words))
    if not all(is_followed(material, place) for place in linked):
        return noted(LOST, Sentence("{given} image {file}: it stays linked, but stock nodes cannot follow it and show its mean", **words))
    if is_through:
        return noted(KEPT, Sentence("{given} image {file}: through nodes that keep the mean color", **words))
    return noted(KEPT, Sentence("{given} image {file}: linked to the layer", **words))


def _texture(tree: bpy.types.NodeTree, image: Image, place, row: int, notes: list[Sentence]) -> bpy.types.NodeSocket:
    """Nodes that read an image; returns the output that has what is wanted of it."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.location = (place[0] - 5 * _APART, place[1] - row * _APART)
    node.image = _block(image, notes)
    if (image.tiling, image.turn, image.shift) != ((1.0, 1.0), 0.0, (0.0, 0.0)):
        coordinates, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
        coordinates.location, mapping.location = (node.location.x - 2 * _APART, node.location.y), (node.location.x - _APART, node.location.y)
        mapping.inputs["Scale"].default_value = (*image.tiling, 1.0)
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, image.turn)
        mapping.inputs["Location"].default_value = (*image.shift, 0.0)
        tree.links.new(coordinates.outputs["UV"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    if image.is_normal:
        bump = tree.nodes.new("ShaderNodeNormalMap")
        bump.location = (node.location.x + _APART, node.location.y)
        bump.inputs["Strength"].default_value = image.strength
        tree.links.new(node.outputs["Color"], bump.inputs["Color"])
        return bump.outputs["Normal"]
    output = node.outputs["Color"]
    if image.channel == 3:
        output = node.outputs["Alpha"]
    elif image.channel is not None:
        split = tree.nodes.new("ShaderNodeSeparateColor")
        split.location = (node.location.x + _APART, node.location.y)
        tree.links.new(node.outputs["Color"], split.inputs["Color"])
        output = split.outputs[_CHANNELS[image.channel]]
    return output if image.is_plain else _scaled(tree, output, image)


def _scaled(tree: bpy.types.NodeTree, output: bpy.types.NodeSocket, image: Image) -> bpy.types.NodeSocket:
    """What a graph makes of an image's values: a factor and an offset."""
    is_value = image.width == 1 and len(image.scale) == len(image.offset) == 1
    node = tree.nodes.new("ShaderNodeMath" if is_value else "ShaderNodeVectorMath")
    node.operation, node.location = "MULTIPLY_ADD", (output.node.location.x + _APART, output.node.location.y)
    for socket, numbers in zip(node.inputs[1:3], (image.scale, image.offset)):
        socket.default_value = numbers[0] if is_value else tuple(numbers * 3)[:3]
    tree.links.new(output, node.inputs[0])
    return node.outputs[0]


def _block(image: Image, notes: list[Sentence]) -> bpy.types.Image:
    """The image in its color space: one that is there already, unless it is read in another space."""
    wanted = _SPACES.get(canonical(image.space)) if is_known(image.space) else None
    if wanted not in bpy.types.ColorManagedInputColorspaceSettings.bl_rna.properties["name"].enum_items:
        told = Sentence("color space {space} of the image {file}: read as sRGB; Blender has not this one", space=image.space, file=Path(image.file).name)
        notes.append(noted(LOST, told))
        wanted = "sRGB"
    for block in bpy.data.images:
        if block.library is None and bpy.path.abspath(block.filepath) == image.file and block.colorspace_settings.name == wanted:
            return block
    block = bpy.data.images.load(image.files[0])
    if image.files[0] != image.file:
        _tile(block, image)
    block.colorspace_settings.name = wanted
    return block


def _tile(block: bpy.types.Image, image: Image) -> None:
    """Make all tiles of an image of the first one."""
    block.source, block.filepath = "TILED", image.file
    name = Path(image.file).name
    block.name = name
    before = len(image.file[: min(i for mark in TILES if (i := image.file.find(mark)) >= 0)])
    numbers = [int(file[before : before + 4]) if TILES[0] in name else _number(file[before:]) for file in image.files]
    first = block.tiles[0]
    first.number = numbers[0]
    for number in numbers[1:]:
        block.tiles.new(number)


def _number(text: str) -> int:
    """Of a tile u1_v1."""
    u, v = re.match(r"u(\d+)_v(\d+)", text).groups()
    return 1000 + int(u) + 10 * (int(v) - 1)


def lost_textures(material: bpy.types.Material) -> list[Sentence]:
    """What a file of numbers loses of a material: the sockets of its layers that something feeds, whose means are written."""
    sockets = [s for e in (*material.lamina.shown_layers, material.lamina.base) for s in node_of(e).inputs]
    return [noted(LOST, Sentence("{socket} texture: the mean of {source} is written", socket=s.name, source=mean_name(s))) for s in sockets if mean_name(s)]
