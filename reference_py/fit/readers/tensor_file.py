# SPDX-License-Identifier: GPL-3.0-or-later
"""The tensor container of the RGL material database: named arrays of any shape in one file.

"tensor_file" and a zero byte, version (two bytes: 1, 0), count of fields (uint32); per field: length of its name
(uint16), the name, number of dimensions (uint16), type (uint8), offset (uint64), shape (uint64 each). Little-endian.
"""

import struct
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence

MAGIC = b"tensor_file\0"
TYPES = {1: "<u1", 2: "<i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8", 9: "<f2", 10: "<f4", 11: "<f8"}
_MOST_FIELDS, _MOST_DIMENSIONS = 256, 16


def read_tensors(path: Path) -> dict[str, np.ndarray]:
    """The fields by name. Raises LaminaError when the file is no tensor file, truncated, or of the wrong byte order."""
    data = path.read_bytes()
    if data[: len(MAGIC)] != MAGIC:
        raise LaminaError("{path}: no tensor file of the RGL database: it does not start with 'tensor_file'", path=path)
    at = len(MAGIC)
    version, count, at = *_unpack(path, data, "<2BI", at, lambda v: (v[:2], v[2])), at + 6
    if version != (1, 0):
        raise LaminaError("{path}: tensor file of version {major}.{minor}; this reader knows 1.0", path=path, major=version[0], minor=version[1])
    if count > _MOST_FIELDS:
        swapped = int.from_bytes(count.to_bytes(4, "little"), "big")
        hint = Sentence("; written with the other byte order?") if swapped <= _MOST_FIELDS else ""
        raise LaminaError("{path}: {count} fields are not plausible{hint}", path=path, count=count, hint=hint)
    fields = {}
    for _ in range(count):
        (length,) = _unpack(path, data, "<H", at)
        (name,) = _unpack(path, data, f"<{length}s", at + 2)
        at += 2 + length
        dimensions, kind, offset = _unpack(path, data, "<HBQ", at)
        at += 11
        if kind not in TYPES or dimensions > _MOST_DIMENSIONS:
            raise LaminaError(
                "{path}: field {name!r} has type {kind} and {dimensions} dimensions; choose types 1 to 11",
                path=path,
                name=name.decode(errors="replace"),
                kind=kind,
                dimensions=dimensions,
            )
        shape = _unpack(path, data, f"<{dimensions}Q", at)
        at += 8 * dimensions
        size = int(np.prod(shape, dtype=object)) if dimensions else 1
        item = np.dtype(TYPES[kind])
        if offset + size * item.itemsize > len(data):
            raise LaminaError(
                "{path}: truncated, field {name!r} ends at byte {end} of {count}",
                path=path,
                name=name.decode(errors="replace"),
                end=offset + size * item.itemsize,
                count=len(data),
            )
        fields[name.decode(errors="replace")] = np.frombuffer(data, item, size, offset).reshape(shape)
    return fields


def _unpack(path: Path, data: bytes, form: str, at: int, result=tuple):
    try:
        return result(struct.unpack_from(form, data, at))
    except struct.error:
        raise LaminaError("{path}: truncated in its header, at byte {at} of {count}", path=path, at=at, count=len(data)) from None
