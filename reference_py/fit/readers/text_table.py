# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain tables: theta_i, phi_i, theta_o, phi_o in degrees, then r, g, b or one column per wavelength in nm.

The first line that is no comment (#) names the columns, in any order; values are f in 1/sr, without cosine. Semicolons
and tabs separate too, and then a comma is a decimal one.
"""

import csv
import re
from pathlib import Path

import numpy as np

from ...errors import LaminaError
from ...optics.frame import spherical
from .measurement import Measurement, checked

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
_RGB = ("r", "g", "b")
# Looked for in this order: beside the others a comma is a decimal one.
_DELIMITERS = (";", "\t", ",")
_MOST_BYTES = 500_000_000
_WAVELENGTH = re.compile(r"(\d+(?:\.\d+)?)\s*(?:nm)?")


def read(path: Path, wavelength_nm: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError on missing columns, duplicate or out-of-range angles, or text."""
    if path.stat().st_size > _MOST_BYTES:
        raise LaminaError(f"{path}: {path.stat().st_size} bytes are too large for a table; at most {_MOST_BYTES}")
    try:
        lines = [(i, line) for i, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")]
    except UnicodeDecodeError as error:
        raise LaminaError(f"{path}: not UTF-8 text: {error.reason} at byte {error.start}") from None
    if len(lines) < 2:
        raise LaminaError(f"{path}: no rows; a table has a line of column names ({', '.join(ANGLES)}, r, g, b) and numbers below it")
    delimiter = next((d for d in _DELIMITERS if d in lines[0][1]), ",")
    names = [name.strip().lower() for name in next(csv.reader([lines[0][1]], delimiter=delimiter))]
    columns, nm = _columns(path, names)
    numbers = _numbers(path, lines[1:], names, delimiter)
    angles = numbers[:, [names.index(a) for a in ANGLES]]
    _check_angles(path, angles, [i for i, _ in lines[1:]])
    theta_i, phi_i, theta_o, phi_o = np.radians(angles).T
    found = (f"table of {len(numbers)} rows, {'RGB' if nm is None else f'wavelengths: {len(nm)}'}",)
    return checked(spherical(theta_i, phi_i), spherical(theta_o, phi_o), numbers[:, columns], str(path), found, nm, wavelength_nm)


def _columns(path: Path, names: list[str]) -> tuple[list[int], np.ndarray | None]:
    missing = [name for name in ANGLES if name not in names]
    if missing:
        raise LaminaError(
            f"{path}: missing column{'s' * (len(missing) > 1)} {', '.join(missing)}; it has {', '.join(names)}; "
            f"choose {', '.join(ANGLES)}, then r, g, b or wavelengths in nm"
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise LaminaError(f"{path}: column {twice[0]} is there twice")
    others = [name for name in names if name not in ANGLES]
    if set(others) == set(_RGB):
        return [names.index(name) for name in _RGB], None
    matches = [(name, _WAVELENGTH.fullmatch(name)) for name in others]
    strange = [name for name, match in matches if match is None and name not in _RGB]
    if strange:
        raise LaminaError(f"{path}: column {strange[0]!r} is neither r, g, b nor a wavelength in nm; rename or remove it")
    if any(match is None for _, match in matches) and any(match is not None for _, match in matches):
        raise LaminaError(f"{path}: it has both {', '.join(n for n, match in matches if match is None)} and wavelengths; choose one of them")
    if not others or any(match is None for _, match in matches):
        missing = [name for name in _RGB if name not in others]
        raise LaminaError(f"{path}: missing column{'s' * (len(missing) > 1)} {', '.join(missing)}; choose r, g, b or wavelengths in nm")
    pairs = sorted((float(match[1]), names.index(name)) for name, match in matches)
    nm = np.array([p[0] for p in pairs])
    if nm[0] < 200.0 or nm[-1] > 2500.0 or np.any(np.diff(nm) <= 0.0):
        raise LaminaError(f"{path}: wavelengths {nm[0]:g} to {nm[-1]:g}; choose nm that differ, from 200 to 2500")
    return [p[1] for p in pairs], nm


def _numbers(path: Path, lines, names: list[str], delimiter: str) -> np.ndarray:
    rows = []
    for number, line in lines:
        cells = (line if delimiter == "," else line.replace(",", ".")).split(delimiter)
        if len(cells) != len(names):
            raise LaminaError(
                f"{path}: line {number} has {len(cells)} cells where {len(names)} are named" + ("; truncated?" if len(cells) < len(names) else "")
            )
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            name, bad = next(pair for pair in zip(names, cells) if not _is_number(pair[1]))
            raise LaminaError(f"{path}: line {number}: {name} is {bad.strip()!r}, which is not a number") from None
    return np.array(rows)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _check_angles(path: Path, angles: np.ndarray, line_numbers: list[int]) -> None:
    for column, (name, low, high) in enumerate((("theta_i", 0, 180), ("phi_i", -360, 360), ("theta_o", 0, 180), ("phi_o", -360, 360))):
        values = angles[:, column]
        bad = ~((values >= low) & (values <= high))
        if bad.any():
            at = int(np.argmax(bad))
            raise LaminaError(f"{path}: line {line_numbers[at]}: {name} is {values[at]:g}; choose {low} to {high} degrees")
    if angles[:, [0, 2]].max() <= 0.5 * np.pi + 1e-9 and angles[:, [0, 2]].max() > 0.1:
        raise LaminaError(f"{path}: no angle from the normal exceeds {angles[:, [0, 2]].max():.3g}: these are radians; give degrees")
    rounded = np.round(angles, 4)
    rounded[:, [1, 3]] %= 360.0
    order = np.lexsort(rounded.T)
    same = np.all(rounded[order[1:]] == rounded[order[:-1]], axis=1)
    if same.any():
        at = int(np.argmax(same))
        first, second = sorted(line_numbers[k] for k in (order[at], order[at + 1]))
        raise LaminaError(f"{path}: lines {first} and {second} have the same angles; give each pair of directions once ({int(same.sum())} such)")
