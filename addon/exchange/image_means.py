# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of an image of a MaterialX file, for where there are no textures."""

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.exchange.materialx_image import Image
from ...reference_py.optics.colour import is_known, to_linear_rec709


def mean_of_image(image: Image) -> np.ndarray:
    """(3,) in linear Rec.709, or (1,) of one channel or of data; of tiles that of all. Raises LaminaError for a file that is no image."""
    return image.at(np.mean([_mean(file, image) for file in image.files], axis=0))


def _mean(file: str, image: Image) -> np.ndarray:
    try:
        block = bpy.data.images.load(file)
    except RuntimeError:
        raise LaminaError("{file}: no image that Blender can read", file=file) from None
    try:
        block.colorspace_settings.name = "Non-Color"  # the file's own numbers
        width, height = block.size
        pixels = np.empty(width * height * block.channels, np.float32)
        if not len(pixels):
            raise LaminaError("{file}: no image that Blender can read", file=file)
        block.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(block)
    pixels = pixels.reshape(width * height, -1)
    if image.channel == 3:
        return np.atleast_1d(np.mean(pixels[:, -1], dtype=float)) if pixels.shape[1] in (2, 4) else np.ones(1)
    color = np.broadcast_to(pixels[:, :1], (len(pixels), 3)) if pixels.shape[1] < 3 else pixels[:, :3]
    if image.space and is_known(image.space):
        color = to_linear_rec709(color, image.space)
    return np.mean(color if image.channel is None else color[:, image.channel : image.channel + 1], axis=0, dtype=float)
