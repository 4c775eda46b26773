# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write EXR and PNG whole or not at all, with Lamina's errors. Arrays have the top row first."""

import os
from typing import NamedTuple

import numpy as np

from ...reference_py.atomic import replacing
from ...reference_py.errors import LaminaError
from . import oiio


class Exr(NamedTuple):
    """channels: name -> (h, w) float32 array; metadata: the texts in the first part's header."""

    channels: dict[str, np.ndarray]
    metadata: dict[str, str]

    def layer(self, prefix: str, components: str = "RGB") -> np.ndarray:
        """Channels `prefix`.R, .G, .B (or the given letters) as float64 (h, w, n). Raises LaminaError if absent."""
        try:
            return np.stack([self.channels[f"{prefix}.{c}"] for c in components], axis=-1).astype(np.float64)
        except KeyError as missing:
            raise LaminaError("EXR channel {missing} is not there; choose from {choices}", missing=missing, choices=", ".join(self.channels)) from None


def require_pictures() -> None:
    """Raise LaminaError where pictures can be neither read nor written, before long work starts."""
    try:
        oiio.module()
    except ImportError as error:
        raise LaminaError(str(error)) from None


def _read(path: str | os.PathLike, kind: str, what: str):
    try:
        return oiio.read(path, kind)
    except OSError as error:
        raise LaminaError("{path}: cannot read: {reason}", path=path, reason=error.strerror or error) from None
    except ImportError as error:
        raise LaminaError(str(error)) from None
    except (ValueError, MemoryError) as error:
        raise LaminaError("{path}: not {what} file that can be read here: {reason}", path=path, what=what, reason=" ".join(str(error).split())) from None


def _write(path: str | os.PathLike, channels: dict[str, np.ndarray], metadata: dict[str, str]) -> None:
    require_pictures()
    with replacing(path) as temporary:
        oiio.write(temporary, channels, metadata)


def read_exr(path: str | os.PathLike) -> Exr:
    """All channels and texts of an EXR file. Raises LaminaError."""
    return Exr(*_read(path, "float", "an EXR"))


def write_exr(path: str | os.PathLike, channels: dict[str, np.ndarray], metadata: dict[str, str] | None = None) -> None:
    """Write (h, w) channels as 32-bit floats, ZIP, with texts in the header; whole or not at all. Raises LaminaError."""
    _write(path, {name: np.asarray(plane, np.float32) for name, plane in channels.items()}, metadata or {})


def read_png(path: str | os.PathLike) -> tuple[np.ndarray, dict[str, str]]:
    """(h, w, channels) uint8 pixels as stored, and the texts, of a PNG. Raises LaminaError."""
    channels, texts = _read(path, "uint8", "a PNG")
    return np.stack(list(channels.values()), axis=-1), texts


def write_png(path: str | os.PathLike, pixels: np.ndarray, metadata: dict[str, str] | None = None) -> None:
    """Write (h, w, 3 or 4) uint8 sRGB pixels with texts; whole or not at all. Raises LaminaError."""
    planes = np.asarray(pixels, np.uint8)
    _write(path, {name: planes[..., i] for i, name in enumerate("RGBA"[: planes.shape[-1]])}, metadata or {})
