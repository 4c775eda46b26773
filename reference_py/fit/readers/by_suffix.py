# SPDX-License-Identifier: GPL-3.0-or-later
"""Any file of a measurement, by its suffix."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence
from . import SUFFIXES, keyed, merl, rgl, speos, text_table, zemax
from .measurement import Measurement, without_shadows
from .tensor_file import MAGIC

_CHOICES = ".binary (MERL), .bsdf (RGL, Zemax), .brdf (Speos), .astm (ASTM E1392), .dat (ALTA), .csv or .txt (a table)"
# Formats whose makers publish no description.
_CLOSED = {".axf": Sentence("X-Rite's AxF has no public description"), ".sdf": Sentence("it has no public description")}
Reader = Callable[[Path, float | None, float | None], Measurement]


def _bsdf(path: Path, wavelength_nm: float | None, steepest_deg: float | None) -> Measurement:
    """RGL's files and Zemax' have the same suffix: which one it is stands at the beginning."""
    with open(path, "rb") as file:
        head = file.read(2000)
    if zemax.looks_like(head):
        return zemax.read(path, wavelength_nm, steepest_deg)
    if not head.startswith(MAGIC):
        raise LaminaError(
            "{path}: neither a tensor file of the RGL database, which starts with 'tensor_file', nor a Zemax or Radiant table, with 'Source'", path=path
        )
    return rgl.read(path, wavelength_nm, steepest_deg)


_BY_SUFFIX: dict[str, Reader] = dict(
    zip(SUFFIXES, (merl.read, _bsdf, speos.read, text_table.read, text_table.read, keyed.read_astm, keyed.read_alta), strict=True)
)


def read(path: str | os.PathLike, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """Read a measurement, by its suffix: those of `_CHOICES`.

    With `wavelength_nm` it has one channel; `steepest_deg` is the largest angle that is used, 85 unless given. Raises LaminaError.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in _BY_SUFFIX:
        if suffix in _CLOSED:
            why = Sentence("cannot be read, as {reason}; export a table", reason=_CLOSED[suffix])
        else:
            why = Sentence("unknown kind of measurement {suffix!r}", suffix=path.suffix)
        raise LaminaError("{path}: {why}; choose {choices}", path=path, why=why, choices=_CHOICES)
    try:
        # a broken file holds any numbers; `checked` counts those that are none
        with np.errstate(all="ignore"):
            return without_shadows(_BY_SUFFIX[suffix](path, wavelength_nm, steepest_deg))
    except OSError as error:
        raise LaminaError("{path}: cannot read the measurement: {reason}", path=path, reason=error.strerror or error) from None
