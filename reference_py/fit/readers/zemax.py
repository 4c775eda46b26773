# SPDX-License-Identifier: GPL-3.0-or-later
"""Tabular BSDF files of Zemax and Radiant's imaging spheres: text, by "BSDF Data Interchange file format specification" (Rykowski).

Lines of a name and a count, each followed by that many angles: SampleRotation, AngleOfIncidence, ScatterAzimuth,
ScatterRadial; then a block for each channel (Monochrome, or TristimulusX, Y and Z) between DataBegin and DataEnd: per
rotation and incidence a line TIS, then a line per azimuth with f at every radial angle. Radial angles count from the
direction of mirror reflection, azimuth 0 points from there to the normal.
"""

from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence, joined
from ...optics.colour import xyz_to_rgb
from ...optics.frame import rotate_z
from .measurement import Measurement, checked

_AXES = ("SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial")
_BLOCKS = {"monochrome": ("Monochrome",), "xyz": ("TristimulusX", "TristimulusY", "TristimulusZ")}
_MOST_BYTES, _MOST_VALUES = 500_000_000, 50_000_000


def looks_like(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    lines = [line.strip() for line in head.decode("latin-1").splitlines()]
    first = next((line for line in lines if line and not line.startswith("#")), "")
    return first.lower().startswith("source")


def read(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError on what is missing, or data of transmission."""
    if path.stat().st_size > _MOST_BYTES:
        raise LaminaError("{path}: {size} bytes are too large for a table; at most {most}", path=path, size=path.stat().st_size, most=_MOST_BYTES)
    lines = [line.strip() for line in path.read_text(encoding="latin-1").splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    header, axes, at = _header(path, lines)
    if header.get("scattertype", "brdf").lower() != "brdf":
        raise LaminaError("{path}: ScatterType is {kind}; only BRDF, light that comes back, can be fitted", path=path, kind=header["scattertype"][:40])
    content = header.get("spectralcontent", "monochrome").lower()
    if content not in _BLOCKS:
        raise LaminaError("{path}: SpectralContent is {content!r}; choose Monochrome or XYZ", path=path, content=content[:40])
    shape = tuple(len(axes[name]) for name in _AXES)
    f = np.stack([_block(path, lines, at, name, shape) for name in _BLOCKS[content]], axis=-1)
    notes = []
    if content == "xyz":
        f = xyz_to_rgb(f)
        notes.append(Sentence("XYZ made linear RGB"))
    wi, wo = _directions(*(np.radians(axes[name]) for name in _AXES))
    counts = joined(Sentence("{count} of {axis}", count=count, axis=name) for name, count in zip(_AXES, shape))
    found = (Sentence("Zemax or Radiant table: {counts}", counts=counts), *notes)
    return checked(wi.reshape(-1, 3), wo.reshape(-1, 3), f.reshape(-1, f.shape[-1]), str(path), found, only_nm=wavelength_nm, steepest_deg=steepest_deg)


def _header(path: Path, lines: list[str]) -> tuple[dict, dict, int]:
    """Words by name in lower case, the axes in degrees, and the line after them."""
    words, axes, at = {}, {}, 0
    while at < len(lines) and set(axes) != set(_AXES):
        name, _, rest = lines[at].partition(" ") if " " in lines[at] else lines[at].partition("\t")
        at += 1
        axis = next((a for a in _AXES if a.lower() == name.lower()), None)
        if axis is None:
            words[name.lower()] = rest.strip()
            continue
        try:
            values = np.array([float(v) for v in (lines[at].split() if at < len(lines) else ())])
            count = int(rest)
        except ValueError:
            values, count = np.zeros(0), -1
        if len(values) != count or count < 1:
            raise LaminaError("{path}: {axis} announces {text!r} angles, and {values} follow", path=path, axis=axis, text=rest[:20], values=len(values))
        axes[axis], at = values, at + 1
    if missing := [name for name in _AXES if name not in axes]:
        raise LaminaError("{path}: missing {missing}; a Zemax or Radiant table has {axes}", path=path, missing=", ".join(missing), axes=", ".join(_AXES))
    if np.prod([float(len(a)) for a in axes.values()]) > _MOST_VALUES:
        raise LaminaError("{path}: more than {most} values", path=path, most=_MOST_VALUES)
    return words, axes, at


def _block(path: Path, lines: list[str], at: int, name: str, shape) -> np.ndarray:
    """Values of one channel, of shape (rotations, incidences, azimuths, radii)."""
    start = next((i for i in range(at, len(lines)) if lines[i].lower() == name.lower()), None)
    if start is None:
        raise LaminaError("{path}: missing the data {name}", path=path, name=name)
    rows = []
    for line in lines[start + 1 :]:
        if line.lower().startswith("dataend"):
            break
        if not line.lower().startswith(("databegin", "tis")):
            rows.append(line.split())
    wanted = int(np.prod(shape[:3]))
    if len(rows) != wanted or any(len(row) != shape[3] for row in rows):
        raise LaminaError(
            "{path}: {name} has {rows} rows where {wanted} of {count} values are announced; truncated?",
            path=path,
            name=name,
            rows=len(rows),
            wanted=wanted,
            count=shape[3],
        )
    try:
        return np.array(rows, float).reshape(shape)
    except ValueError:
        raise LaminaError("{path}: {name} holds what is not a number", path=path, name=name) from None


def _directions(rotation, incidence, azimuth, radial) -> tuple[np.ndarray, np.ndarray]:
    """wi, wo (rotations, incidences, azimuths, radii, 3); the sample's turn moves both."""
    r, i, a, s = np.meshgrid(rotation, incidence, azimuth, radial, indexing="ij")
    mirror = np.stack([np.sin(i), 0.0 * i, np.cos(i)], axis=-1)
    to_normal = np.stack([-np.cos(i), 0.0 * i, np.sin(i)], axis=-1)
    side = np.array([0.0, 1.0, 0.0])
    wo = np.cos(s)[..., None] * mirror + np.sin(s)[..., None] * (np.cos(a)[..., None] * to_normal + np.sin(a)[..., None] * side)
    wi = np.stack([-np.sin(i), 0.0 * i, np.cos(i)], axis=-1)
    return rotate_z(wi, r), rotate_z(wo, r)
