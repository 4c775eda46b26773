# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the tensor container of the RGL material database, which `fit.readers.tensor_file` describes and reads."""

import struct
from collections.abc import Mapping

import numpy as np

from ...fit.readers.tensor_file import MAGIC, TYPES

_KINDS = {kind: number for number, kind in TYPES.items()}
# Readers that map the file into memory want every field at an address of its own type.
_ALIGNMENT = 8


def tensor_bytes(fields: Mapping[str, np.ndarray]) -> bytes:
    """A whole file of arrays of bytes, float32 and the like by name."""
    arrays = {name: np.ascontiguousarray(array).astype(np.dtype(array.dtype).newbyteorder("<")) for name, array in fields.items()}
    at = len(MAGIC) + 6 + sum(2 + len(name) + 11 + 8 * array.ndim for name, array in arrays.items())
    head, body = [MAGIC, struct.pack("<2BI", 1, 0, len(arrays))], []
    for name, array in arrays.items():
        body.append(b"\0" * (-at % _ALIGNMENT))
        at += len(body[-1])
        head.append(struct.pack(f"<H{len(name)}sHBQ{array.ndim}Q", len(name), name.encode(), array.ndim, _KINDS[_kind(array)], at, *array.shape))
        body.append(array.tobytes())
        at += len(body[-1])
    return b"".join(head + body)


def _kind(array: np.ndarray) -> str:
    return "<" + array.dtype.str[1:]
