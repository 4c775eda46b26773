# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of materials: the studio's ball, as the preset menu and the asset library show it."""

import os
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from ...reference_py.atomic import replacing
from ..rendering.settings import render_to
from ..rendering.studio import build_ball_scene

SIZE, SAMPLES = 128, 32
_RESULT = "Render Result"


def render_thumbnail(material: bpy.types.Material, path: str | os.PathLike, size: int = SIZE, samples: int = SAMPLES) -> None:
    """Write a square PNG of a ball of `material`, whole or not at all. Raises LaminaError.

    It takes a few seconds. What the user rendered last stays in the Image Editor.
    """
    studio = build_ball_scene(material, size, samples, name="Lamina Thumbnail")
    try:
        with tempfile.TemporaryDirectory() as folder, _slot_of_its_own():
            picture = Path(folder, "thumbnail.png")
            render_to(studio.scene, picture)
            with replacing(path) as temporary:
                temporary.write_bytes(_without_texts(picture.read_bytes()))
    finally:
        studio.remove()


def _without_texts(png: bytes) -> bytes:
    """A PNG's pixels alone: no date, no file's name. Needs no OpenImageIO, which some Blenders' Python lacks."""
    kept, place = [png[:8]], 8
    while place < len(png):
        end = place + 12 + struct.unpack(">I", png[place : place + 4])[0]
        if png[place + 4 : place + 5].isupper():  # what a reader needs; the rest is written in small letters
            kept.append(png[place:end])
        place = end
    return b"".join(kept)


def pixels_of(path: str | os.PathLike) -> np.ndarray:
    """(h, w, 3) uint8 pixels of a PNG as stored, top row first, by Blender's own reader."""
    image = bpy.data.images.load(str(path))
    try:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        width, height = image.size
        return np.rint(255.0 * pixels.reshape(height, width, -1)[::-1, :, :3]).astype(np.uint8)
    finally:
        bpy.data.images.remove(image)


@contextmanager
def _slot_of_its_own() -> Iterator[None]:
    """Render into the last slot of the user's Render Result, if there is one, and show the one that was shown."""
    result = bpy.data.images.get(_RESULT)
    if result is None or len(result.render_slots) < 2:
        yield
        return
    shown, result.render_slots.active_index = result.render_slots.active_index, len(result.render_slots) - 1
    try:
        yield
    finally:
        result.render_slots.active_index = shown


def give_preview(material: bpy.types.Material, pixels: np.ndarray) -> None:
    """Make (h, w, 3) uint8 pixels as stored in a PNG, top row first, the preview of a material."""
    opaque = np.concatenate([pixels, np.full_like(pixels[..., :1], 255)], axis=-1)[::-1]
    preview = material.preview_ensure()
    preview.image_size = (pixels.shape[1], pixels.shape[0])
    preview.image_pixels_float.foreach_set((opaque.astype(np.float32) / 255.0).ravel())
