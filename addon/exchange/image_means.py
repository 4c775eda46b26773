# SPDX-License-Identifier: GPL-3.0-or-later
"""The means of the images of a MaterialX file, by which a surface is solved, and which a stack without textures has."""

from collections.abc import Iterable

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.exchange.materialx import AnyMaterial
from ...reference_py.exchange.materialx_image import Image
from ...reference_py.optics.colour import is_known, to_linear_rec709
from ..blender import oiio

# Numbers that are read at once: of a large picture there is never more in memory.
_CHUNK = 1 << 22


def with_means(material: AnyMaterial, images: Iterable[str]) -> tuple[AnyMaterial, list[LaminaError]]:
    """A material with the means of these of its images as values, and why some have none. Normals have none to say."""
    means, unread = {}, []
    for given in images:
        if not material.images[given].is_normal:
            try:
                means[given] = mean_of_image(material.images[given])
            except LaminaError as error:
                unread.append(error)
    return material.with_means(means), unread


def mean_of_image(image: Image) -> np.ndarray:
    """(3,) in linear Rec.709, or (1,) of one channel or of data; of tiles that of all. Raises LaminaError for a file that is no image."""
    return image.at(np.mean([_mean(file, image) for file in image.files], axis=0))


def _mean(file: str, image: Image) -> np.ndarray:
    try:
        return _mean_of(oiio.pieces(file, _CHUNK), image)
    except (OSError, ValueError, ImportError):  # other channels, which Blender may know
        return _mean_of([_loaded(file)], image)


def _mean_of(pieces: Iterable[np.ndarray], image: Image) -> np.ndarray:
    total, count = 0.0, 0
    for pixels in pieces:
        total, count = total + np.sum(_values(pixels, image), axis=0, dtype=float), count + len(pixels)
    return total / count


def _values(pixels: np.ndarray, image: Image) -> np.ndarray:
    """What an image gives (n, 3) or (n, 1) of a file's own numbers (n, 1 to 4)."""
    if image.channel == 3:
        return pixels[:, -1:] if pixels.shape[1] in (2, 4) else np.ones((len(pixels), 1))
    color = np.broadcast_to(pixels[:, :1], (len(pixels), 3)) if pixels.shape[1] < 3 else pixels[:, :3]
    if image.space and is_known(image.space):
        color = to_linear_rec709(color, image.space)
    return color if image.channel is None else color[:, image.channel : image.channel + 1]


def _loaded(file: str) -> np.ndarray:
    try:
        block = bpy.data.images.load(file)
    except RuntimeError:
        raise LaminaError("{file}: no image that Blender can read", file=file) from None
    try:
        block.colorspace_settings.name = "Non-Color"  # the file's own numbers
        pixels = np.empty(len(block.pixels), np.float32)
        if not len(pixels):
            raise LaminaError("{file}: no image that Blender can read", file=file)
        block.pixels.foreach_get(pixels)
        return pixels.reshape(-1, block.channels)
    finally:
        bpy.data.images.remove(block)
