# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures that have no image, and images whose file is not where it was."""

import os
from collections.abc import Iterator

import bpy

_DEPTH = 16


def lost_images(node: bpy.types.Node, depth: int = _DEPTH) -> Iterator[bpy.types.Image | None]:
    """The images that textures at or before a node cannot show, as their files are gone; None for a texture that has no image."""
    if node.bl_idname == "ShaderNodeTexImage":
        if node.image is None or _is_gone(node.image):
            yield node.image
    elif depth > 0:
        for socket in node.inputs:
            for link in socket.links:
                yield from lost_images(link.from_node, depth - 1)


def file_of(image: bpy.types.Image) -> str:
    """The path of an image's file, in full."""
    return os.path.normpath(bpy.path.abspath(image.filepath, library=image.library))


def _is_gone(image: bpy.types.Image) -> bool:
    return image.source == "FILE" and image.packed_file is None and not image.has_data and not os.path.exists(file_of(image))
