# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups of lobe sets in a file: equal lobe sets share one, and what somebody edited is left alone."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import bpy
import numpy as np

from ....reference_py.lobes.patch_lobes import PatchLobes
from ..working_space import REC709, is_current, working_space
from .stock_nodes import SPACE_MARK, Tables, build_group

GROUP_KEY = "lamina_network"
# The working space that a group was made in.
SPACE_KEY = "lamina_space"
# What the groups of lobe sets were, by a digest of the lobe set, who shows it, and the working space: the many nodes of one that is there need not be built again.
_MOST_BUILT = 256
_built: dict[tuple[str, bool, str], str] = {}


def lobe_group(lobe_set: Tables, in_eevee: bool = False) -> bpy.types.NodeTree:
    """The node group of a lobe set that `tabulate` made: one output "BSDF", and `group_inputs`. Cycles alone shows it unless `in_eevee`.

    Lobe sets of equal tables share one group of this file. A group that somebody edited is left alone.
    """
    wanted = _digest(lobe_set), in_eevee, working_space()
    if tree := _group_with(_built.get(wanted)):
        return tree
    tree = bpy.data.node_groups.new("Lamina Lobes", "ShaderNodeTree")
    try:
        build_group(tree, lobe_set, in_eevee)
    except Exception:
        _remove(tree)
        raise
    content = _content(tree)
    if len(_built) >= _MOST_BUILT:
        _built.pop(next(iter(_built)))
    _built[wanted] = content
    if other := _group_with(content):
        _remove(tree)
        return other
    tree.name, tree[GROUP_KEY], tree[SPACE_KEY] = f"Lamina Lobe set {content}", content, working_space()
    for image in _images(tree):
        image.name = tree.name
    return tree


def needs_eevee_output(tree: bpy.types.NodeTree) -> bool:
    """Whether a group shows wrong numbers in EEVEE, where it reads smaller copies of the image of its tables."""
    return GROUP_KEY in tree and any(node.bl_idname == "ShaderNodeTexImage" for node in tree.nodes)


def tables_size(tree: bpy.types.NodeTree) -> int:
    """The longest side in pixels of the images that a group looks up in; 0 where it has none."""
    return max((max(image.size) for image in _images(tree)), default=0)


def _group_with(content: str | None) -> bpy.types.NodeTree | None:
    """This file's group of a content, as long as nobody edited it."""
    own = (group for group in bpy.data.node_groups if content and group.library is None and group.get(GROUP_KEY) == content)
    return next((group for group in own if _space_of(group) == working_space() and is_untouched(group)), None)


def _digest(lobe_set: Tables) -> str:
    def plain(value):
        if isinstance(value, np.ndarray):
            return [value.shape, hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()]
        if isinstance(value, PatchLobes):
            return plain((value.stack, value.parts))
        if is_dataclass(value):
            return [type(value).__name__, *(plain(getattr(value, field.name)) for field in fields(value))]
        if isinstance(value, Mapping):
            return [[name, plain(value[name])] for name in sorted(value)]
        return [plain(v) for v in value] if isinstance(value, (list, tuple)) else value

    return hashlib.sha256(json.dumps(plain(lobe_set)).encode()).hexdigest()


def drop_group(tree: bpy.types.NodeTree | None) -> None:
    """Remove a lobe set's group that nothing uses any more. A group edited by hand stays."""
    if tree is not None and tree.library is None and GROUP_KEY in tree and tree.users == 0 and is_untouched(tree):
        _remove(tree)


def _remove(tree: bpy.types.NodeTree) -> None:
    """Remove a group and the images of its tables."""
    images = _images(tree)
    bpy.data.node_groups.remove(tree)
    for image in images:
        if image.users == 0:
            bpy.data.images.remove(image)


def _images(tree: bpy.types.NodeTree) -> list[bpy.types.Image]:
    """The images of a group's tables."""
    return list({node.image.name: node.image for node in tree.nodes if getattr(node, "image", None) is not None}.values())


def is_untouched(tree: bpy.types.NodeTree) -> bool:
    """Whether a lobe set's group still is what its hash was taken of; of one that Blender converted that cannot be said, so it counts as such."""
    return _space_of(tree) != working_space() or tree.get(GROUP_KEY) == _content(tree)


def is_in_working_space(tree: bpy.types.NodeTree) -> bool:
    """Whether a group's colors are in the file's working space: it was made for it, or Blender converted them.

    What follows a color converts it by numbers, which Blender leaves as they are.
    """
    if any(item.in_out == "INPUT" and item.socket_type == "NodeSocketColor" for item in tree.interface.items_tree):
        return _space_of(tree) == working_space()
    mark = tree.nodes.get(SPACE_MARK)
    return working_space() == REC709 if mark is None else is_current(mark.outputs[0].default_value[:3], 0)


def _space_of(tree) -> str:
    return tree.get(SPACE_KEY, REC709)


def _content(tree) -> str:
    """A hash of what a group computes."""
    nodes, known = [], {}
    for node in tree.nodes:
        settings = [getattr(node, name, None) for name in ("operation", "distribution", "fresnel_type")]
        values = [_plain(s.default_value) for s in node.inputs if not s.is_linked and hasattr(s, "default_value")]
        ramp = node.color_ramp if hasattr(node, "color_ramp") else None
        stops = [ramp.interpolation, [(e.position, *e.color) for e in ramp.elements]] if ramp else []
        image = [_pixels_of(node.image, known)] if getattr(node, "image", None) is not None else []
        nodes.append([node.bl_idname, node.mute, settings, values, stops, *image])
    order = {node.name: index for index, node in enumerate(tree.nodes)}
    links = sorted([order[k.from_node.name], k.from_socket.identifier, order[k.to_node.name], k.to_socket.identifier] for k in tree.links)
    return hashlib.sha256(json.dumps([nodes, links]).encode()).hexdigest()[:12]


def _pixels_of(image: bpy.types.Image, known: dict[str, str]) -> str:
    """A hash of an image's pixels."""
    if image.name not in known:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        known[image.name] = hashlib.sha256(pixels.tobytes()).hexdigest()
    return known[image.name]


def _plain(value):
    return list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
