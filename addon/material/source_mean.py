# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of what is linked to a value: of an image's pixels, of a constant, or of a small bake by Cycles of any other nodes.

The bake is 1,024 points, spread evenly over the UV square (all tiles of UDIM images) and over the unit cube that generated and object coordinates run
through, and facing all ways, with what the things that show the material have there. It needs no OSL, 20 to 60 ms, and a scene, a mesh, an image and a copy of the material, which are gone afterwards.
"""

import hashlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.material.schema import FLOAT, Parameter
from ..blender.dependencies import files_at
from ..shader.working_space import out_of_working, working_space
from .image_mean import image_mean
from .shown_values import ShownValues, shown_values

# Of luminance in linear Rec.709, which a color gives to a number (ITU-R BT.709).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_SIDE = 32
_TINY = 1e-4
_IMAGE, _CONSTANTS = "ShaderNodeTexImage", ("ShaderNodeRGB", "ShaderNodeValue")
# What does not change what a node gives.
_LOOKS = {
    "rna_type", "name", "label", "location", "location_absolute", "width", "height", "dimensions", "parent", "select", "color", "use_custom_color",
    "color_tag", "warning_propagation", "show_options", "show_preview", "hide", "show_texture", "inputs", "outputs", "internal_links",
    "is_active_output", "bl_icon", "bl_width_default", "bl_width_min", "bl_width_max", "bl_height_default", "bl_height_min", "bl_height_max",
}  # fmt: skip


def source_of_socket(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """What gives an input its value by a link that counts; None where its own value does."""
    if not socket.is_linked:
        return None
    return next((link.from_socket for link in socket.links if not link.is_muted and link.is_valid), None)


def name_of(source: bpy.types.NodeSocket) -> str:
    """What is linked, as a user knows it: an image's name, or a node's."""
    node = source.node
    if node.bl_idname == _IMAGE and node.image is not None:
        return f"image {node.image.name}"
    return node.label or node.name


def state_of(source: bpy.types.NodeSocket, parameter: Parameter) -> str:
    """A hash of all that a mean follows from: nodes with their values, files by size and date. Pixels that are painted count for nothing."""
    words = [parameter.name, parameter.type, working_space(), source.identifier, *_words(source.node, _Way()), *_shown(source).words()]
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:16]


def is_painted(source: bpy.types.NodeSocket) -> bool:
    """Whether an image before a socket has pixels that are in no file, which may have changed without a trace."""
    return any(image.is_dirty or image.source == "GENERATED" for image in _images(source.node))


def has_images(source: bpy.types.NodeSocket) -> bool:
    """Whether an image is before a socket."""
    return next(_images(source.node), None) is not None


def mean_of(source: bpy.types.NodeSocket, parameter: Parameter) -> list[float] | float:
    """The mean of what a socket gives, within the parameter's range, to four digits: the same on every machine."""
    read = partial(_read, parameter)
    found = None
    if source.node.bl_idname == _IMAGE and source.name == "Color" and not source.node.mute and source.node.image is not None:
        found = image_mean(source.node.image, source.node.image_user, read)
    elif source.node.bl_idname in _CONSTANTS:
        value = source.default_value
        found = read(out_of_working([list(value)[:3]]) if source.type == "RGBA" else np.full((1, 3), value))[0]
    if found is None:
        found = np.mean(read(out_of_working(_baked(source, parameter.type == FLOAT))), axis=0)
    digits = _digits(found)
    return digits[0] if parameter.type == FLOAT else digits


def picture_mean(source: bpy.types.NodeSocket, parameter: Parameter) -> list[float] | None:
    """The mean of the bare picture that glTF's exporter takes for what a socket gives a color, dropping the nodes between; white where it finds none.

    None for a picture whose pixels alone do not say what Cycles shows (`image_mean`).
    """
    node = _first_picture(source, (), set(), _Way())
    if node is None or node.image is None:
        return [1.0, 1.0, 1.0]
    found = image_mean(node.image, node.image_user, partial(_read, parameter))
    return None if found is None else _digits(found)


def _first_picture(source: bpy.types.NodeSocket, groups: tuple[bpy.types.Node, ...], seen: set, way: "_Way") -> bpy.types.Node | None:
    """The first image texture before a socket in the order of inputs, looked for in `groups` too."""
    node, place = source.node, list(source.node.outputs).index(source)
    if node.bl_idname == _IMAGE or (node, place, groups) in seen:
        return node if node.bl_idname == _IMAGE else None
    seen.add((node, place, groups))
    inputs = list(node.inputs)
    if node.bl_idname == "NodeGroupInput":
        inputs, groups = ([groups[-1].inputs[place]], groups[:-1]) if groups else ([], ())
    elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
        inputs, groups = [n.inputs[place] for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput"][:1], (*groups, node)
    found = (_first_picture(link.from_socket, groups, seen, way) for socket in inputs for link in way.links(socket))
    return next((picture for picture in found if picture is not None), None)


def _digits(values: np.ndarray) -> list[float]:
    return [float(f"{v:.4g}") for v in values]


def _read(parameter: Parameter, colors: np.ndarray) -> np.ndarray:
    """Colors (n, 3) as values (n, 1 or 3) of a parameter: what is no number is its least, as in a shader."""
    values = np.where(np.isfinite(colors), colors, parameter.minimum)
    values = values @ _LUMINANCE[:, None] if parameter.type == FLOAT else values
    return np.clip(values, parameter.minimum, parameter.maximum)


class _Way:
    """A walk through what is before a node: the nodes that it saw, and links by the socket that they feed, for which Blender looks through a whole tree."""

    def __init__(self) -> None:
        self._seen: set[bpy.types.Node] = set()
        self._links: dict[bpy.types.NodeTree, dict[int, list[bpy.types.NodeLink]]] = {}

    def is_new(self, node: bpy.types.Node) -> bool:
        """Whether a node is met for the first time."""
        is_new = node not in self._seen
        self._seen.add(node)
        return is_new

    def links(self, socket: bpy.types.NodeSocket) -> Sequence[bpy.types.NodeLink]:
        """The links to an input."""
        if not socket.is_linked:
            return ()
        tree = socket.id_data
        if tree not in self._links:
            into = self._links[tree] = {}
            for link in tree.links:
                into.setdefault(link.to_socket.as_pointer(), []).append(link)
        return self._links[tree].get(socket.as_pointer(), ())

    def before(self, node: bpy.types.Node) -> Iterator[bpy.types.Node]:
        """The nodes that feed a node."""
        return (link.from_node for socket in node.inputs for link in self.links(socket))


def _all_before(node: bpy.types.Node, way: _Way) -> Iterator[bpy.types.Node]:
    """A node and all before it in its tree."""
    if way.is_new(node):
        yield node
        for other in way.before(node):
            yield from _all_before(other, way)


def _with_groups(node: bpy.types.Node, way: _Way) -> Iterator[bpy.types.Node]:
    """A node and all before it, with the nodes of groups."""
    if way.is_new(node):
        yield node
        for other in (*way.before(node), *(node.node_tree.nodes if getattr(node, "node_tree", None) is not None else ())):
            yield from _with_groups(other, way)


def _images(node: bpy.types.Node) -> Iterator[bpy.types.Image]:
    return (other.image for other in _with_groups(node, _Way()) if isinstance(getattr(other, "image", None), bpy.types.Image))


def _shown(source: bpy.types.NodeSocket) -> ShownValues:
    """What is read before a socket of the things that show its material."""
    return shown_values(list(_with_groups(source.node, _Way())), source.id_data, _SIDE**2)


def _words(node: bpy.types.Node, way: _Way) -> Iterator[str]:
    """What a node and all before it give, as text."""
    if not way.is_new(node):
        return
    yield node.bl_idname
    yield from _facts(node)
    tree = getattr(node, "node_tree", None)
    if tree is not None:
        for other in tree.nodes:
            yield from _words(other, way)
    for socket in node.inputs:
        if not socket.is_linked and hasattr(socket, "default_value"):
            yield f"{socket.identifier} {_plain(socket.default_value)}"
        for link in way.links(socket):
            yield f"{socket.identifier} < {link.from_node.name} {link.from_socket.identifier} {link.is_muted}"
            yield from _words(link.from_node, way)
    for socket in node.outputs if node.bl_idname in _CONSTANTS else ():
        yield _plain(socket.default_value)


def _facts(block, depth: int = 4) -> Iterator[str]:
    for name in _properties(type(block)):
        value = getattr(block, name)
        if isinstance(value, bpy.types.Image):
            yield f"{name} {_image_facts(value, getattr(block, 'image_user', None))}"
        elif isinstance(value, bpy.types.ID):
            yield f"{name} {value.name_full}"
        elif isinstance(value, bpy.types.bpy_prop_collection):
            for item in value if depth else ():
                yield from _facts(item, depth - 1)
        elif isinstance(value, bpy.types.bpy_struct):
            yield from _facts(value, depth - 1) if depth else ()
        else:
            yield f"{name} {_plain(value)}"


@cache
def _properties(kind) -> tuple[str, ...]:
    return tuple(p.identifier for p in kind.bl_rna.properties if p.identifier not in _LOOKS and not p.identifier.startswith("bl_"))


def _plain(value) -> str:
    return str(value if isinstance(value, (str, bool, int, float)) or not hasattr(value, "__iter__") else list(value))


def _image_facts(image: bpy.types.Image, user) -> str:
    dates = []
    for file in () if image.packed_files else files_at(image, user, bpy.context.scene.frame_current):
        try:
            dates.append((file, os.stat(file).st_size, os.stat(file).st_mtime_ns))
        except OSError:
            dates.append((file, 0, 0))
    return str((image.name_full, image.source, image.colorspace_settings.name, image.alpha_mode, list(image.generated_color), image.generated_type, dates))


@cache
def _points() -> np.ndarray:
    """Evenly spread points of the unit cube in five dimensions: UV and place (Roberts' R sequence)."""
    phi = 1.0
    for _ in range(60):
        phi = (1.0 + phi) ** (1.0 / 6.0)
    return (0.5 + np.arange(_SIDE**2)[:, None] * phi ** -np.arange(1.0, 6.0)) % 1.0


def _baked(source: bpy.types.NodeSocket, is_float: bool) -> np.ndarray:
    """What a socket gives at the points, (n, 3), in the working space."""
    tiles = sorted({tile.number for image in _images(source.node) if image.source == "TILED" for tile in image.tiles}) or [1001]
    shown = _shown(source)
    with _painted_kept(), _bench(source.id_data, tiles) as (scene, item, material, image):
        shown.dress(scene, item)
        tree = material.node_tree
        before = {node.name for node in _all_before(source.node, _Way())}
        for other in [node for node in tree.nodes if node.name not in before and node != tree.nodes.active]:
            tree.nodes.remove(other)  # their images need not be loaded
        twin = tree.nodes[source.node.name].outputs[list(source.node.outputs).index(source)]
        if is_float:  # as a number's socket reads it
            number = tree.nodes.new("ShaderNodeMath")
            number.inputs[1].default_value = 0.0
            tree.links.new(twin, number.inputs[0])
            twin = number.outputs[0]
        emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(twin, emission.inputs["Color"])
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        target = {"object": item, "active_object": item, "selected_objects": [item], "selected_editable_objects": [item]}
        with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0], **target):
            try:
                bpy.ops.object.bake(type="EMIT", margin=0, use_clear=True, target="IMAGE_TEXTURES", save_mode="INTERNAL")
            except RuntimeError as error:
                raise LaminaError("Blender cannot bake the mean of {source}: {reason}", source=name_of(source), reason=str(error).strip()) from None
        pixels = np.empty(_SIDE**2 * 4, np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(-1, 4)[:, :3].astype(float)


@contextmanager
def _painted_kept() -> Iterator[None]:
    """Give the file's images back the pixels that nobody saved: without a window, a bake by Cycles frees all images (seen in 4.5.15)."""
    kept = [(image, np.empty(len(image.pixels), np.float32)) for image in bpy.data.images if image.is_dirty]
    for image, pixels in kept:
        image.pixels.foreach_get(pixels)
    try:
        yield
    finally:
        for image, pixels in kept:
            if not image.is_dirty:
                image.pixels.foreach_set(pixels)
                image.pixels[0] = float(pixels[0])  # which alone says that they are not saved
                image.update()


@contextmanager
def _bench(tree: bpy.types.NodeTree, tiles: list[int]) -> Iterator[tuple]:
    """A scene with one square a point, each a pixel of an image, of a material with a copy of the nodes."""
    made: list[bpy.types.ID] = []

    def keep(block):
        made.append(block)
        return block

    try:
        owner = next(m for m in bpy.data.materials if m.node_tree == tree)
        material = keep(owner.copy())
        material.property_unset("lamina")  # nothing that looks after stacks is to look after it
        # its sockets have the values of this frame; a node that is removed takes its curves from the action that both trees share
        material.node_tree.animation_data_clear()
        image = keep(bpy.data.images.new("Lamina Means", _SIDE, _SIDE, alpha=False, float_buffer=True))
        image.colorspace_settings.name = "Non-Color"
        node = material.node_tree.nodes.new(_IMAGE)
        node.image, material.node_tree.nodes.active = image, node
        mesh = keep(_mesh(tiles, {n.uv_map for n in material.node_tree.nodes if getattr(n, "uv_map", "")}))
        mesh.materials.append(material)
        item = keep(bpy.data.objects.new("Lamina Means", mesh))
        scene = keep(bpy.data.scenes.new("Lamina Means"))
        scene.collection.objects.link(item)
        scene.render.engine = "CYCLES"
        scene.cycles.samples, scene.cycles.device, scene.cycles.use_adaptive_sampling = 1, "CPU", False
        scene.cycles.shading_system = False
        scene.frame_set(bpy.context.scene.frame_current)
        scene.view_layers[0].objects.active = item
        item.select_set(True, view_layer=scene.view_layers[0])
        yield scene, item, material, image
    finally:
        for block in reversed(made):
            bpy.data.batch_remove([block])


def _tangents(count: int) -> np.ndarray:
    """(n, 2, 3) tangents of planes that face evenly all ways, as those of things do (a Fibonacci sphere)."""
    z, phi = 1.0 - (2.0 * np.arange(count) + 1.0) / count, np.arange(count) * np.pi * (3.0 - 5.0**0.5)
    across = np.stack([-np.sin(phi), np.cos(phi), np.zeros(count)], axis=-1)
    normal = np.stack([*(np.sqrt(1.0 - z * z) * np.stack([np.cos(phi), np.sin(phi)])), z], axis=-1)
    return np.stack([across, np.cross(normal, across)], axis=1)


def _mesh(tiles: list[int], names: set[str]) -> bpy.types.Mesh:
    points, corners = _points(), np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    count = len(points)
    offsets = np.array([[(t - 1001) % 10, (t - 1001) // 10] for t in tiles])[np.arange(count) % len(tiles)]
    around = _TINY * (corners - 0.5)
    mesh = bpy.data.meshes.new("Lamina Means")
    mesh.vertices.add(4 * count)
    places = (2.0 * points[:, None, 2:] - 1.0) + np.einsum("kc,ncx->nkx", around, _tangents(count))
    mesh.vertices.foreach_set("co", places.astype(np.float32).ravel())
    mesh.loops.add(4 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(4 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * count, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    cells = np.stack(np.divmod(np.arange(count), _SIDE)[::-1], axis=-1)
    for name in ("Lamina Places", *(sorted(names)[:6] or ["UVMap"])):
        uvs = (cells[:, None] + corners) / _SIDE if name == "Lamina Places" else (points[:, :2] + offsets)[:, None] + around
        layer = mesh.uv_layers.new(name=name)
        layer.data.foreach_set("uv", uvs.astype(np.float32).ravel())
        layer.active_render = name != "Lamina Places"
    mesh.uv_layers["Lamina Places"].active = True
    return mesh
