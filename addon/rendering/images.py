# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write EXR and PNG with numpy and zlib alone, so that measuring never depends on what a Blender bundles.

Arrays have the top row first. Of EXR: scanline files, single or multi part, without compression or with ZIP/ZIPS
(OpenEXR file layout, openexr.com/en/latest/OpenEXRFileLayout.html). Of PNG: 8 bit per channel, not interlaced
(W3C PNG specification, third edition).
"""

import os
import struct
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...reference_py.atomic import replacing
from ...reference_py.errors import LaminaError

_EXR_MAGIC, _MULTI_PART, _TILED_OR_DEEP = 20000630, 0x1000, 0x0A00
_LINES_PER_CHUNK = {0: 1, 2: 1, 3: 16}  # by EXR compression: none, ZIPS, ZIP
_CHANNEL_TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}
_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_PNG_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # by PNG colour type


class Exr(NamedTuple):
    """channels: name -> (h, w) array; metadata: the text attributes of the first part."""

    channels: dict[str, np.ndarray]
    metadata: dict[str, str]

    def layer(self, prefix: str, components: str = "RGB") -> np.ndarray:
        """Channels `prefix`.R, .G, .B (or the given letters) as float64 (h, w, n). Raises LaminaError if absent."""
        try:
            return np.stack([self.channels[f"{prefix}.{c}"] for c in components], axis=-1).astype(np.float64)
        except KeyError as missing:
            raise LaminaError(f"EXR channel {missing} is not there; choose from {', '.join(self.channels)}") from None


class _Cursor:
    """Reads little-endian values one after the other."""

    def __init__(self, data: bytes):
        self.data, self.at = data, 0

    def take(self, layout: str) -> tuple:
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values

    def text(self) -> str:
        end = self.data.index(b"\0", self.at)
        value, self.at = self.data[self.at:end].decode("utf-8", "replace"), end + 1
        return value


def _exr_header(cursor: _Cursor) -> dict[str, tuple[str, bytes]]:
    header = {}
    while name := cursor.text():
        kind, (size,) = cursor.text(), cursor.take("i")
        header[name] = kind, cursor.data[cursor.at:cursor.at + size]
        cursor.at += size
    return header


def _exr_channels(block: bytes) -> list[tuple[str, np.dtype]]:
    cursor, channels = _Cursor(block), []
    while name := cursor.text():
        kind, _, x_step, y_step = cursor.take("iIii")
        if (x_step, y_step) != (1, 1):
            raise LaminaError(f"EXR channel {name}: subsampled channels are not supported")
        channels.append((name, np.dtype(_CHANNEL_TYPES[kind])))
    return channels


def _unzip(block: bytes, size: int) -> bytes:
    """Undo EXR's ZIP: deflate, then differences of successive bytes, then split even and odd bytes."""
    if len(block) >= size:  # a block that would not shrink is stored as it is
        return block
    delta = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    delta[1:] -= 128
    merged = np.empty(size, np.uint8)
    half = (size + 1) // 2
    merged[0::2], merged[1::2] = np.split(np.cumsum(delta).astype(np.uint8), [half])
    return merged.tobytes()


def _zip(block: bytes) -> bytes:
    data = np.frombuffer(block, np.uint8)
    split = np.concatenate([data[0::2], data[1::2]])
    split[1:] = np.diff(split) + np.uint8(128)
    packed = zlib.compress(split.tobytes())
    return packed if len(packed) < len(block) else block


def read_exr(path: str | os.PathLike) -> Exr:
    """Channels and text attributes of an EXR file (see the module's limits). Raises LaminaError."""
    try:
        return _parse_exr(Path(path).read_bytes())
    except OSError as error:
        raise LaminaError(f"{path}: cannot read: {error.strerror}") from None
    except (struct.error, ValueError, KeyError, IndexError, zlib.error) as error:
        raise LaminaError(f"{path}: not an EXR file that can be read here: {error}") from None


def _parse_exr(data: bytes) -> Exr:
    cursor = _Cursor(data)
    magic, version = cursor.take("II")
    if magic != _EXR_MAGIC or version & _TILED_OR_DEEP:
        raise LaminaError("only scanline EXR files are supported")
    headers = [_exr_header(cursor)]
    while version & _MULTI_PART and (header := _exr_header(cursor)):
        headers.append(header)
    parts = []
    for header in headers:
        compression = header["compression"][1][0]
        if compression not in _LINES_PER_CHUNK:
            raise LaminaError(f"EXR compression number {compression}; choose none, ZIPS or ZIP")
        x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"][1])
        parts.append((_exr_channels(header["channels"][1]), compression, x1 - x0 + 1, y0, y1 - y0 + 1))
    chunks = [(part, -(-height // _LINES_PER_CHUNK[compression]))
              for part, (_, compression, _, _, height) in enumerate(parts)]
    offsets = [cursor.take(f"{count}Q") for _, count in chunks]
    channels: dict[str, np.ndarray] = {}
    for part, (layout, compression, width, top, height) in enumerate(parts):
        planes = {name: np.empty((height, width), kind) for name, kind in layout}
        row_bytes = sum(kind.itemsize for _, kind in layout) * width
        for cursor.at in offsets[part]:
            if version & _MULTI_PART:
                cursor.take("i")
            y, size = cursor.take("ii")
            lines = min(_LINES_PER_CHUNK[compression], top + height - y)
            block = _unzip(data[cursor.at:cursor.at + size], row_bytes * lines)
            at = 0
            for line in range(y - top, y - top + lines):
                for name, kind in layout:
                    planes[name][line] = np.frombuffer(block, kind, width, at)
                    at += kind.itemsize * width
        channels.update(planes)
    texts = {name: value.decode("utf-8", "replace") for name, (kind, value) in headers[0].items() if kind == "string"}
    return Exr(channels, texts)


def write_exr(path: str | os.PathLike, channels: dict[str, np.ndarray], metadata: dict[str, str] | None = None) -> None:
    """Write (h, w) channels as 32-bit floats, ZIP, with text attributes; whole or not at all. Raises LaminaError."""
    names = sorted(channels)  # the format wants them in this order
    planes = np.stack([np.asarray(channels[name], "<f4") for name in names], axis=1)
    height, _, width = planes.shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listing = b"".join(name.encode() + b"\0" + struct.pack("<iIii", 2, 0, 1, 1) for name in names) + b"\0"
    attributes = {
        "channels": ("chlist", listing), "compression": ("compression", b"\3"), "dataWindow": ("box2i", window),
        "displayWindow": ("box2i", window), "lineOrder": ("lineOrder", b"\0"),
        "pixelAspectRatio": ("float", struct.pack("<f", 1.0)), "screenWindowCenter": ("v2f", bytes(8)),
        "screenWindowWidth": ("float", struct.pack("<f", 1.0)),
    } | {key: ("string", value.encode()) for key, value in (metadata or {}).items()}
    head = struct.pack("<II", _EXR_MAGIC, 2) + b"".join(
        name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
        for name, (kind, value) in attributes.items()) + b"\0"
    blocks = [struct.pack("<i", y) + struct.pack("<i", len(packed)) + packed
              for y in range(0, height, 16) for packed in [_zip(planes[y:y + 16].tobytes())]]
    starts = len(head) + 8 * len(blocks) + np.cumsum([0] + [len(block) for block in blocks[:-1]])
    with replacing(path) as temporary:
        temporary.write_bytes(head + starts.astype("<u8").tobytes() + b"".join(blocks))


def _paeth(left, above, corner):
    """PNG's predictor: whichever of the three is nearest to left + above - corner."""
    p = left + above - corner
    d_left, d_above, d_corner = abs(p - left), abs(p - above), abs(p - corner)
    return np.where((d_left <= d_above) & (d_left <= d_corner), left, np.where(d_above <= d_corner, above, corner))


def write_png(path: str | os.PathLike, pixels: np.ndarray, metadata: dict[str, str] | None = None) -> None:
    """Write (h, w, 3 or 4) uint8 sRGB pixels with text metadata; whole or not at all. Raises LaminaError."""
    pixels = np.asarray(pixels)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] not in (3, 4):
        raise LaminaError(f"{path}: a PNG needs (h, w, 3 or 4) uint8 pixels, not {pixels.shape} {pixels.dtype}")
    height, width, depth = pixels.shape
    here = pixels.astype(np.int16)
    padded = np.pad(here, ((1, 0), (1, 0), (0, 0)))
    left, above, corner = padded[1:, :-1], padded[:-1, 1:], padded[:-1, :-1]
    coded = np.stack([here, here - left, here - above, here - (left + above) // 2, here - _paeth(left, above, corner)])
    coded = coded.astype(np.uint8).reshape(5, height, width * depth)
    best = np.abs(coded.astype(np.int8).astype(np.int64)).sum(axis=2).argmin(axis=0)
    rows = np.concatenate([best[:, None].astype(np.uint8), coded[best, np.arange(height)]], axis=1)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2 if depth == 3 else 6, 0, 0, 0)), (b"sRGB", b"\0")]
    chunks += [(b"iTXt", key.encode("latin-1") + bytes(5) + text.encode()) for key, text in (metadata or {}).items()]
    chunks += [(b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")]
    with replacing(path) as temporary:
        temporary.write_bytes(_PNG_SIGNATURE + b"".join(
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
            for kind, body in chunks))


def read_png(path: str | os.PathLike) -> tuple[np.ndarray, dict[str, str]]:
    """(h, w, channels) uint8 pixels as stored, and the iTXt/tEXt metadata, of an 8-bit PNG. Raises LaminaError."""
    try:
        data = Path(path).read_bytes()
        if data[:8] != _PNG_SIGNATURE:
            raise LaminaError("no PNG signature")
        at, packed, texts = 8, b"", {}
        while at < len(data):
            (size,), kind = struct.unpack_from(">I", data, at), data[at + 4:at + 8]
            body, at = data[at + 8:at + 8 + size], at + 12 + size
            if kind == b"IHDR":
                width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            elif kind == b"IDAT":
                packed += body
            elif kind in (b"tEXt", b"iTXt"):
                key, text = body.split(b"\0", 1)
                if kind == b"tEXt":
                    texts[key.decode("latin-1")] = text.decode("latin-1")
                elif text[0] == 0:  # not compressed; two more fields (language, translated key) come first
                    texts[key.decode("latin-1")] = text[2:].split(b"\0", 2)[2].decode()
        if bits != 8 or interlaced or colour not in _PNG_CHANNELS:
            raise LaminaError(f"{bits} bits, colour type {colour}: only plain 8-bit pictures are supported")
        return _unfilter(zlib.decompress(packed), width, height, _PNG_CHANNELS[colour]), texts
    except OSError as error:
        raise LaminaError(f"{path}: cannot read: {error.strerror}") from None
    except (struct.error, ValueError, UnboundLocalError, zlib.error) as error:
        raise LaminaError(f"{path}: not a PNG file that can be read here: {error}") from None


def _unfilter(data: bytes, width: int, height: int, depth: int) -> np.ndarray:
    rows = np.frombuffer(data, np.uint8).reshape(height, 1 + width * depth)
    pixels = np.zeros((height, width, depth), np.uint8)
    above = np.zeros((width, depth), np.uint8)
    for y, row in enumerate(rows):
        line = row[1:].reshape(width, depth)
        if row[0] == 1:
            line = np.cumsum(line, axis=0, dtype=np.uint8)
        elif row[0] == 2:
            line = line + above
        elif row[0] in (3, 4):  # each pixel needs its left neighbour: plain integers are faster here than numpy
            line = np.array([_unfilter_line(row[0], line[:, c].tolist(), above[:, c].tolist())
                             for c in range(depth)], np.uint8).T
        pixels[y] = above = line
    return pixels


def _unfilter_line(kind: int, line: list[int], above: list[int]) -> list[int]:
    left = corner = 0
    for x, up in enumerate(above):
        if kind == 3:
            guess = (left + up) >> 1
        else:
            d_left, d_up, d_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            guess = left if d_left <= d_up and d_left <= d_corner else up if d_up <= d_corner else corner
        left = line[x] = (line[x] + guess) & 255
        corner = up
    return line
