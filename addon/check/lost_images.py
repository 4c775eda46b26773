# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures that have no image, and images of which a file is not where it was."""

import os
from collections.abc import Iterator
from typing import NamedTuple

import bpy

from ..blender.dependencies import files_at

_DEPTH = 16


class Lost(NamedTuple):
    """What a texture cannot show: an image and the file of it that is gone, or no image."""

    image: bpy.types.Image | None
    path: str


def lost_images(node: bpy.types.Node, depth: int = _DEPTH) -> Iterator[Lost]:
    """What textures at or before a node cannot show at this frame; of tiles the first that is gone."""
    if node.bl_idname == "ShaderNodeTexImage":
        if node.image is None:
            yield Lost(None, "")
        elif gone := _gone(node.image, node.image_user):
            yield Lost(node.image, gone[0])
    elif depth > 0:
        for socket in node.inputs:
            for link in socket.links:
                yield from lost_images(link.from_node, depth - 1)


def _gone(image: bpy.types.Image, user: bpy.types.ImageUser) -> list[str]:
    if image.packed_files or image.is_dirty or (image.source == "FILE" and image.has_data):
        return []
    return [path for path in files_at(image, user, bpy.context.scene.frame_current) if not os.path.exists(path)]
