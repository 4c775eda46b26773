# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of an image's pixels, as the model has colors. Exact, and in memory that does not grow with the image's file.

Only what Cycles shows by a plain rule is summed here: three color spaces, no transparency. The rest is for a bake (`source_mean`).
"""

from collections.abc import Callable, Iterator

import bpy
import numpy as np

from ..blender import oiio
from ..blender.dependencies import files_at
from ..shader.working_space import REC709, out_of_working

DATA, SRGB = "Non-Color", "sRGB"
_LINEAR = (REC709, "Linear")
# Floats that are read at once.
_CHUNK = 1 << 22
# Pixels of an image that Blender has to hold whole.
_MOST_PIXELS = 1 << 25


def image_mean(image: bpy.types.Image, user: bpy.types.ImageUser, read: Callable[[np.ndarray], np.ndarray]) -> np.ndarray | None:
    """The mean over all pixels of `read`, which gets linear colors (n, 3) and gives values (n, k). Every tile of a UDIM image counts alike.

    None for what is not shown by a plain rule, or cannot be read: a missing file, another color space, transparency, a film.
    """
    space = image.colorspace_settings.name
    if space not in (DATA, SRGB, *_LINEAR):
        return None
    means = []
    for pieces in _parts(image, user):
        total, count = 0.0, 0
        try:
            for pixels, is_working in pieces:
                if space != DATA and image.alpha_mode not in ("NONE", "CHANNEL_PACKED") and pixels.shape[1] == 4 and np.any(pixels[:, 3] < 1.0):
                    return None
                colors = pixels[:, :3].astype(float)
                if is_working or space == DATA:
                    colors = out_of_working(colors)
                elif space == SRGB:
                    colors = _decoded(colors)
                total, count = total + np.sum(read(np.where(np.isfinite(colors), colors, 0.0)), axis=0), count + len(colors)
        except (OSError, ValueError, ImportError):
            return None
        if not count:
            return None
        means.append(total / count)
    return np.mean(means, axis=0) if means else None


def _parts(image, user) -> Iterator[Iterator[tuple[np.ndarray, bool]]]:
    """Pixels (n, 1 to 4) of each tile, or of the image, piece by piece, and whether they are in the working space already."""
    if image.source == "MOVIE":
        return
    in_file = image.source in ("FILE", "SEQUENCE", "TILED") and not image.packed_files and not image.is_dirty
    if in_file:
        yield from map(_file_pixels, files_at(image, user, bpy.context.scene.frame_current))
    elif image.source in ("FILE", "GENERATED"):
        yield _held_pixels(image)


def _file_pixels(path: str) -> Iterator[tuple[np.ndarray, bool]]:
    for pixels in oiio.pieces(path, _CHUNK):
        yield (np.repeat(pixels, 3, axis=1) if pixels.shape[1] == 1 else pixels), False


def _held_pixels(image) -> Iterator[tuple[np.ndarray, bool]]:
    if not 0 < image.size[0] * image.size[1] <= _MOST_PIXELS or image.channels != 4:
        raise ValueError
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    yield pixels.reshape(-1, 4), image.is_float


def _decoded(colors: np.ndarray) -> np.ndarray:
    """sRGB's inverse curve (IEC 61966-2-1)."""
    return np.where(colors <= 0.04045, colors / 12.92, ((np.maximum(colors, 0.0) + 0.055) / 1.055) ** 2.4)
