# SPDX-License-Identifier: GPL-3.0-or-later
"""An OpenEXR file in memory, for images that are packed: Blender packs floats of its own without compression.

Source: "OpenEXR File Layout", openexr.com: version 2, scan lines, 32-bit floats, ZIP.
"""

import struct
import zlib

import numpy as np

_MAGIC, _VERSION = 20000630, 2
_ZIP, _LINES, _FLOAT = 3, 16, 2
_CHANNELS = "ABGR"  # in the order of the alphabet, as a file has them


def exr_bytes(pixels: np.ndarray) -> bytes:
    """The file of pixels (h, w, 4), red to alpha, with the lowest row first as Blender has them."""
    pixels = np.asarray(pixels, np.float32)
    height, width, _ = pixels.shape
    lines = np.ascontiguousarray(pixels[::-1, :, ::-1].transpose(0, 2, 1), "<f4")
    head = _head(width, height)
    chunks = [struct.pack("<i", y) + _packed(lines[y : y + _LINES].tobytes()) for y in range(0, height, _LINES)]
    starts = len(head) + 8 * len(chunks) + np.cumsum([0, *map(len, chunks[:-1])])
    return b"".join((head, starts.astype("<u8").tobytes(), *chunks))


def _head(width: int, height: int) -> bytes:
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", _FLOAT, 0, 1, 1) for name in _CHANNELS) + b"\0"
    attributes = (
        ("channels", "chlist", channels),
        ("compression", "compression", bytes((_ZIP,))),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    )
    parts = (f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value for name, kind, value in attributes)
    return struct.pack("<ii", _MAGIC, _VERSION) + b"".join(parts) + b"\0"


def _packed(raw: bytes) -> bytes:
    """Lines with their length: even bytes before odd ones, each as its difference from the last, deflated; as they are where that is no shorter."""
    numbers = np.frombuffer(raw, np.uint8)
    halves = np.concatenate([numbers[0::2], numbers[1::2]])
    steps = np.concatenate([halves[:1], halves[1:] - halves[:-1] + np.uint8(128)])
    deflated = zlib.compress(steps.tobytes(), 4)
    kept = deflated if len(deflated) < len(raw) else raw
    return struct.pack("<i", len(kept)) + kept
