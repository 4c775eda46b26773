# SPDX-License-Identifier: GPL-3.0-or-later
"""An image of a MaterialX file, where its texels lie, and what a graph makes of their values where that is a factor and an offset.

A graph of arithmetic is not taken apart: it is evaluated at some values of the image, and is followed where it is affine there.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

TILES = ("<UDIM>", "<UVTILE>")
"""What stands for the number of a tile in a file's name."""
# 1001 to 2000, as Blender counts: other numbers of four digits are a frame's, or a size.
_UDIM_NUMBERS = ("100[1-9]", "10[1-9][0-9]", "1[1-9][0-9][0-9]", "2000")
_CLOSE = 1e-6


@dataclass(frozen=True)
class Image:
    """An image of a file: `scale` times what it holds, colors in linear Rec.709, plus `offset`, each one number or one a channel.

    `space` is its color space's name, empty for data. It lies where uv is turned by `turn` radians (counterclockwise) after `tiling`, then shifted.
    """

    file: str
    space: str
    is_normal: bool = False
    tiling: tuple[float, float] = (1.0, 1.0)
    channel: int | None = None
    """The one that is taken, 0 to 3; None for all."""
    turn: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, ...] = (1.0,)
    offset: tuple[float, ...] = (0.0,)
    strength: float = 1.0
    """Of a normal."""
    count: int = field(default=3, compare=False)
    """Channels of the node that reads it."""
    default: tuple[float, ...] | None = field(default=None, compare=False)
    """What the file says where there is no such image, before `scale`."""

    @property
    def is_plain(self) -> bool:
        """Its values are those of the file."""
        return set(self.scale) == {1.0} and set(self.offset) == {0.0}

    @property
    def plain(self) -> "Image":
        """With the values of the file."""
        return replace(self, scale=(1.0,), offset=(0.0,))

    @property
    def width(self) -> int:
        """How many numbers a place of it has."""
        return 1 if self.channel is not None else self.count

    def at(self, values: np.ndarray) -> np.ndarray:
        """What is made of values of the file (..., n); of one channel (..., 1) as many as there are factors or offsets."""
        n = values.shape[-1]
        scale, offset = (np.array(v[:n] if n > 1 else v) for v in (self.scale, self.offset))
        return scale * values + offset

    def of_channel(self, index: int) -> "Image":
        """One channel of it."""
        one = [(v[min(index, len(v) - 1)],) for v in (self.scale, self.offset)]
        channel = index if self.channel is None and self.count > 1 else self.channel
        return replace(self, is_normal=False, channel=channel, scale=one[0], offset=one[1])

    @property
    def files(self) -> list[str]:
        """Those that are there: one, or the tiles of a UDIM image by their numbers."""
        for mark in TILES:
            if mark in self.file:
                path = Path(self.file)
                patterns = _UDIM_NUMBERS if mark == TILES[0] else ("u[0-9]*_v[0-9]*",)
                names = [path.name.replace("[", "[[]").replace(mark, pattern) for pattern in patterns]
                return sorted(str(p) for name in names for p in path.parent.glob(name) if p.is_file())
        return [self.file] if Path(self.file).is_file() else []


def made_of(image: Image, at: Callable[[np.ndarray], np.ndarray]) -> Image | np.ndarray | None:
    """What a function of an image's values (n,) is: that image with a factor and an offset, numbers, or None for neither."""
    n = image.width
    offset = at(np.zeros(n))
    slopes = np.stack([at(row) - offset for row in np.eye(n)], axis=-1)
    probes = [np.full(n, level) for level in (0.1, 0.3, 0.7, 1.0)] + [np.linspace(0.2, 0.9, n)]
    if not all(np.allclose(at(x), offset + slopes @ x, atol=_CLOSE) for x in probes):
        return None
    used = np.flatnonzero(np.any(np.abs(slopes) > _CLOSE, axis=0))
    if not len(used):
        return offset
    if len(used) == 1 and n > 1:
        return replace(image, channel=int(used[0]), scale=_numbers(slopes[:, used[0]]), offset=_numbers(offset))
    if n == 1:
        return replace(image, scale=_numbers(slopes[:, 0]), offset=_numbers(offset))
    diagonal = np.diagonal(slopes)
    if np.any(np.abs(slopes - np.eye(*slopes.shape) * np.pad(diagonal, (0, len(offset) - len(diagonal)))[:, None]) > _CLOSE):
        return None
    return replace(image, count=min(n, len(offset)), scale=_numbers(diagonal), offset=_numbers(offset))


def lying(at: Callable[[np.ndarray], np.ndarray]) -> tuple[tuple[float, float], float, tuple[float, float]] | None:
    """Tiling, turn and shift of a function of uv (2,); None where it is another."""
    shift = at(np.zeros(2))
    along, across = at(np.array([1.0, 0.0])) - shift, at(np.array([0.0, 1.0])) - shift
    if len(shift) != 2 or any(not np.allclose(at(p), shift + p[0] * along + p[1] * across, atol=_CLOSE) for p in np.array([[0.3, 0.6], [2.0, -1.5]])):
        return None
    size = float(np.hypot(*along))
    if size < _CLOSE or abs(along @ across) > _CLOSE * max(1.0, size * float(np.hypot(*across))):
        return None
    up = float(along[0] * across[1] - along[1] * across[0]) / size
    turn = float(np.arctan2(along[1], along[0]))
    if abs(abs(turn) - np.pi) < _CLOSE and size:  # a mirrored u is told as one
        size, up, turn = -size, -up, 0.0
    return (round(size, 9), round(up, 9)), round(turn, 9), (round(float(shift[0]), 9), round(float(shift[1]), 9))


def _numbers(values: np.ndarray) -> tuple[float, ...]:
    """One where all are the same."""
    kept = tuple(round(float(v), 9) for v in values)
    return kept[:1] if len(set(kept)) == 1 else kept
