# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables over the view and rows of live values in one float image of a node group.

A block holds three numbers, in red, green and blue, or four with alpha: rows of one axis upwards, and from left to right tiles of the view, one for
each row of a second axis, or, with a third, for each of its rows in each of those.
"""

import bpy
import numpy as np

from ....reference_py.lobes.view_table import KNOTS
from ...blender.exr_bytes import exr_bytes


class TableImage:
    """Blocks of so many `numbers`, 3 or 4, on a grid of `rows` of one axis and `tiles` of the others, 1 where there is no second."""

    def __init__(self, numbers: int, rows: int, tiles: int):
        self.numbers, self.rows, self.tiles = numbers, rows, tiles
        self._blocks: list[list[np.ndarray]] = []

    def add(self, numbers: list[np.ndarray]) -> tuple[int, ...]:
        """Blocks for numbers (rows, ..., KNOTS), as many in each as it holds; their indices."""
        first = len(self._blocks)
        self._blocks += [numbers[i : i + self.numbers] for i in range(0, len(numbers), self.numbers)]
        return tuple(range(first, len(self._blocks)))

    def count(self, block: int) -> int:
        """How many numbers a block has."""
        return len(self._blocks[block])

    @property
    def width(self) -> int:
        """Texels from left to right."""
        return self.tiles * KNOTS

    @property
    def height(self) -> int:
        """Texels from bottom to top."""
        return len(self._blocks) * self.rows

    def _pixels(self) -> np.ndarray:
        pixels = np.zeros((len(self._blocks), self.rows, self.tiles, KNOTS, 4), np.float32)
        pixels[..., 3] = 1.0
        for block, numbers in zip(pixels, self._blocks):
            for channel, table in enumerate(numbers):
                block[..., channel] = table.reshape(self.rows, self.tiles, KNOTS)
        return pixels.reshape(self.height, self.width, 4)

    def make(self) -> bpy.types.Image:
        """The image in this file. It is packed, as Blender keeps pixels of no file in no save and in no undo."""
        image = bpy.data.images.new("Lamina Tables", self.width, self.height, float_buffer=True, is_data=True, alpha=True)
        # alpha is a number as the others are
        image.use_half_precision, image.alpha_mode = False, "CHANNEL_PACKED"
        file = exr_bytes(self._pixels())
        image.pack(data=file, data_len=len(file))
        image.source, image.file_format = "FILE", "OPEN_EXR"  # its pixels are the file's
        return image
