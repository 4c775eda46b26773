# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers: each turns one kind of file into a `Measurement`, or says in one line what is wrong with the file."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...errors import LaminaError
from . import merl, rgl, text_table
from .measurement import Measurement

_BY_SUFFIX: dict[str, Callable[[Path, float | None], Measurement]] = {
    ".binary": merl.read,
    ".bsdf": rgl.read,
    ".csv": text_table.read,
    ".txt": text_table.read,
}
SUFFIXES = tuple(_BY_SUFFIX)


def read(path: str | os.PathLike, wavelength_nm: float | None = None) -> Measurement:
    """Read a measurement, by its suffix: .binary (MERL), .bsdf (RGL), .csv or .txt (a text_table).

    With `wavelength_nm` it has one channel. Raises LaminaError.
    """
    path = Path(path)
    if path.suffix.lower() not in _BY_SUFFIX:
        raise LaminaError(f"{path}: unknown kind of measurement {path.suffix!r}; choose .binary (MERL), .bsdf (RGL), .csv or .txt (text_table)")
    try:
        # a broken file holds any numbers; `checked` counts those that are none
        with np.errstate(all="ignore"):
            return _BY_SUFFIX[path.suffix.lower()](path, wavelength_nm)
    except OSError as error:
        raise LaminaError(f"{path}: cannot read the measurement: {error.strerror or error}") from None
