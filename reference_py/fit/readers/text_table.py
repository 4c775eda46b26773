# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain tables: theta_i, phi_i, theta_o, phi_o in degrees, then r, g, b, one column per wavelength in nm, one value, or a wavelength and a value.

The first line that has the angles, or else the first that is no comment (#), names the columns, in any order, by the names of `ALIASES` too, with
units where a table has them, radians among them; values are f in 1/sr, without cosine, and none where a cell is empty. Semicolons, tabs and blanks separate
too; beside the first two a comma is a decimal one. Without both phi the table is in the plane of incidence: an angle of reflection is positive on the
side away from the light. A negative angle from the normal is the positive one half a turn further.
"""

import csv
import re
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence, joined
from ...optics.frame import spherical
from .measurement import Measurement, checked

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
_ALIASES = {
    "theta_i": ("theta_in", "theta_s", "theta_l", "thetai", "theta_incident", "incidence", "aoi", "angle_of_incidence", "incident_angle", "incidence_angle"),
    "phi_i": ("phi_in", "phi_s", "phi_l", "phii", "phi_incident"),
    "theta_o": ("theta_out", "theta_r", "theta_v", "theta_d", "thetao", "thetar", "theta_scatter", "theta_view", "theta_reflected",
        "scatter_angle", "viewing_angle", "detector_angle", "reflection_angle"),
    "phi_o": ("phi_out", "phi_r", "phi_v", "phi_d", "phio", "phir", "phi_scatter", "phi_view", "phi_reflected"),
    "r": ("red",), "g": ("green",), "b": ("blue",), "wavelength": ("lambda", "wl", "wavelength_nm"),
}  # fmt: skip
ALIASES = {alias: name for name, aliases in _ALIASES.items() for alias in aliases}
"""Other names of the angles, colors and the wavelength."""
VALUES = ("f", "fr", "f_r", "brdf", "bsdf", "value")
"""Names of the one value of a grey table."""
_HINTS = {
    "brf": Sentence("f times pi; divide by pi"), "reflectance_factor": Sentence("f times pi; divide by pi"), "r_factor": Sentence("f times pi; divide by pi"),
    "f_cos": Sentence("f times the cosine of theta_o; divide by it"), "brdf_cos": Sentence("f times the cosine of theta_o; divide by it"),
    "ccbrdf": Sentence("f times the cosine of theta_o; divide by it"), "ccbsdf": Sentence("f times the cosine of theta_o; divide by it"),
}  # fmt: skip
_RGB = ("r", "g", "b")
_WAVE = "wavelength"
# Looked for in this order: beside the first two a comma is a decimal one.
_DELIMITERS = (";", "\t", ",")
_MOST_BYTES = 500_000_000
_WAVELENGTH = re.compile(r"(?:(?:f|fr|f_r|brdf|bsdf|value|wl|lambda)_?)?(\d+(?:\.\d+)?)[\s_]*(?:nm)?")
# A column's unit: those that are meant anyway go, others stay a part of the name.
_UNIT = re.compile(r"(?:\s*[\[(](?:deg|degrees?|°|º|1/sr|sr\^?-1|sr⁻¹|nm)[\])]|[\s_]deg(?:rees)?)$")
_RADIANS = re.compile(r"(?:\s*[\[(]rad(?:ians?)?[\])]|[\s_]rad(?:ians)?)$")
_GREEK = str.maketrans({"θ": "theta", "ϑ": "theta", "φ": "phi", "ϕ": "phi", "λ": "lambda"})
# Columns beside the values that say how sure or which they are.
_BESIDE = re.compile(r"(?:sigma|std|stdev|std_dev|uncertainty|error|err|index|id|no|nr|point|time|timestamp)(?:_.*)?|.*_(?:std|sigma|err|error|uncertainty)")
# Lines that are looked through for the names of columns.
_HEAD = 200


def _missing(names: list[str]) -> Sentence:
    words = ", ".join(names)
    return Sentence("missing columns {names}", names=words) if len(names) > 1 else Sentence("missing column {names}", names=words)


def read(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError on missing columns, duplicate or out-of-range angles, or text."""
    if path.stat().st_size > _MOST_BYTES:
        raise LaminaError("{path}: {size} bytes are too large for a table; at most {most}", path=path, size=path.stat().st_size, most=_MOST_BYTES)
    lines, delimiter = _lines(path)
    cells = _cells(lines[0][1], delimiter)
    if delimiter is not None and len(cells) > 1 and not cells[-1].strip():
        cells = cells[:-1]  # a separator behind the last one
    in_radians = [bool(_RADIANS.search(cell.strip().lower())) for cell in cells]
    given = [_RADIANS.sub("", _UNIT.sub("", cell.strip().lower())) for cell in cells]
    names = [_named(name) for name in given]
    found = []
    if renamed := [Sentence("{old} is {new}", old=old, new=new) for old, new in zip(given, names) if old != new and new in _ALIASES]:
        found.append(joined(renamed))
    found += [Sentence("column {name} is left out", name=name) for name in names if _BESIDE.fullmatch(name)]
    columns, nm = _columns(path, names, given)
    numbers = _numbers(path, lines[1:], names, delimiter)
    in_plane = "phi_o" not in names
    if in_plane:
        found.append(Sentence("in the plane of incidence: theta_o is positive on the side away from the light"))
    numbers[:, in_radians] = np.degrees(numbers[:, in_radians])
    if any(in_radians):
        found.append(Sentence("in radians: {names}", names=", ".join(name for name, is_so in zip(names, in_radians) if is_so)))
    zero = np.zeros(len(numbers))
    angles = np.stack([numbers[:, names.index(a)] if a in names else zero + 180.0 * (a == "phi_o") for a in ANGLES], axis=-1)
    found += _made_positive(angles)
    values, places = numbers[:, columns], [i for i, _ in lines[1:]]
    if _WAVE in names:
        angles, values, nm, places = _unfolded(path, angles, values[:, 0], numbers[:, names.index(_WAVE)], places)
    _check_angles(path, angles, places)
    theta_i, phi_i, theta_o, phi_o = np.radians(angles).T
    content = Sentence("wavelengths: {count}", count=len(nm)) if nm is not None else Sentence("RGB") if len(columns) == 3 else Sentence("one value")
    found.insert(0, Sentence("table of {rows} rows, {content}", rows=len(numbers), content=content))
    return checked(spherical(theta_i, phi_i), spherical(theta_o, phi_o), values, str(path), tuple(found), nm, wavelength_nm, steepest_deg)


def _lines(path: Path) -> tuple[list[tuple[int, str]], str | None]:
    """The line with the names of columns and those below it, by their numbers, and what separates cells; None is blanks."""
    data = path.read_bytes()
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError as error:
        if b"\0" in data:
            raise LaminaError("{path}: not UTF-8 text: {reason} at byte {start}", path=path, reason=error.reason, start=error.start) from None
        text = data.decode("latin-1")
    every = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip()]
    lines = [(i, line) for i, line in every if not line.lstrip().startswith("#")]
    said = [(i, line.lstrip(" \t#")) for i, line in every if line.lstrip().startswith("#")]
    head = next((one for one in (*lines[:_HEAD], *said[:_HEAD]) if _has_angles(one[1])), lines[0] if lines else None)
    if head is not None:
        lines = [head, *((i, line) for i, line in lines if i > head[0])]
    if len(lines) < 2:
        raise LaminaError("{path}: no rows; a table has a line of column names ({angles}, r, g, b) and numbers below it", path=path, angles=", ".join(ANGLES))
    return lines, _delimiter(lines[0][1])


def _delimiter(line: str) -> str | None:
    return next((d for d in _DELIMITERS if d in line), None)


def _has_angles(line: str) -> bool:
    names = {_named(_RADIANS.sub("", _UNIT.sub("", cell.strip().lower()))) for cell in _cells(line, _delimiter(line))}
    return {"theta_i", "theta_o"} <= names


def _named(name: str) -> str:
    """A column's usual name: of Greek letters, blanks and other names of it."""
    plain = re.sub(r"[\s\-]+", "_", name.translate(_GREEK))
    return ALIASES.get(plain, plain)


def _unfolded(path: Path, angles: np.ndarray, values: np.ndarray, wave: np.ndarray, places: list[int]):
    """Angles, values by wavelength, wavelengths and lines of a table with a row for each wavelength. Raises LaminaError where some lack."""
    nm = np.unique(wave)
    pairs, first, pair = np.unique(np.round(angles, 4), axis=0, return_index=True, return_inverse=True)
    counts = np.zeros((len(pairs), len(nm)), int)
    column = np.searchsorted(nm, wave)
    np.add.at(counts, (pair.ravel(), column), 1)
    if np.any(counts != 1) or nm[0] < 200.0 or nm[-1] > 2500.0:
        raise LaminaError("{path}: not every pair of directions has each wavelength once, in nm from 200 to 2500; give each", path=path)
    result = np.empty(counts.shape)
    result[pair.ravel(), column] = values
    return angles[first], result, nm, [places[at] for at in first]


def _cells(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line; `delimiter` None is blanks."""
    return line.split() if delimiter is None else next(csv.reader([line], delimiter=delimiter))


def _made_positive(angles: np.ndarray) -> list[Sentence]:
    """Turn angles from the normal that are negative, in place; what was done, in words."""
    done = []
    for name, theta, phi in (("theta_i", 0, 1), ("theta_o", 2, 3)):
        negative = (angles[:, theta] < 0.0) & (angles[:, theta] >= -90.0)
        if negative.any():
            angles[negative, theta] *= -1.0
            angles[negative, phi] = (angles[negative, phi] + 180.0) % 360.0
            rows = int(negative.sum())
            done.append(Sentence("{name} is negative in {rows} rows: read as positive half a turn further", name=name, rows=rows))
    return done


def _columns(path: Path, names: list[str], given: list[str]) -> tuple[list[int], np.ndarray | None]:
    needed = [name for name in ANGLES if not name.startswith("phi") or "phi_i" in names or "phi_o" in names]
    if "phi_o" in names:
        needed.remove("phi_i")  # then phi_o counts from the light's
    missing = [name for name in needed if name not in names]
    if missing:
        raise LaminaError(
            "{path}: {missing}; it has {names}; choose {angles}, then r, g, b or wavelengths in nm",
            path=path,
            missing=_missing(missing),
            names=", ".join(given),
            angles=", ".join(ANGLES),
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise LaminaError("{path}: column {column} is there twice", path=path, column=twice[0])
    others = [name for name in names if name not in ANGLES and not _BESIDE.fullmatch(name)]
    if _WAVE in others and len(others) == 2 and (value := next(n for n in others if n != _WAVE)) in VALUES:
        return [names.index(value)], None
    for name in others:
        if name in _HINTS:
            raise LaminaError("{path}: column {name!r} holds {hint}, and name the column f", path=path, name=name, hint=_HINTS[name])
    if set(others) == set(_RGB):
        return [names.index(name) for name in _RGB], None
    if len(others) == 1 and others[0] in VALUES:
        return [names.index(others[0])], None
    matches = [(name, _WAVELENGTH.fullmatch(name)) for name in others]
    strange = [name for name, match in matches if match is None and name not in _RGB]
    if strange:
        raise LaminaError(
            "{path}: column {column!r} is neither r, g, b nor a wavelength in nm, nor alone and one of {values}; rename or remove it",
            path=path,
            column=strange[0],
            values=", ".join(VALUES),
        )
    if any(match is None for _, match in matches) and any(match is not None for _, match in matches):
        raise LaminaError(
            "{path}: it has both {names} and wavelengths; choose one of them", path=path, names=", ".join((n for n, match in matches if match is None))
        )
    if not others or any(match is None for _, match in matches):
        missing = [name for name in _RGB if name not in others]
        raise LaminaError("{path}: {missing}; choose r, g, b or wavelengths in nm", path=path, missing=_missing(missing))
    pairs = sorted((float(match[1]), names.index(name)) for name, match in matches)
    nm = np.array([p[0] for p in pairs])
    if nm[0] < 200.0 or nm[-1] > 2500.0 or np.any(np.diff(nm) <= 0.0):
        raise LaminaError("{path}: wavelengths {first:g} to {last:g}; choose nm that differ, from 200 to 2500", path=path, first=nm[0], last=nm[-1])
    return [p[1] for p in pairs], nm


def _numbers(path: Path, lines, names: list[str], delimiter: str | None) -> np.ndarray:
    rows = []
    for number, line in lines:
        cells = _cells(line if delimiter in (",", None) else line.replace(",", "."), delimiter)
        if len(cells) == len(names) + 1 and not cells[-1].strip():
            cells = cells[:-1]
        if len(cells) != len(names):
            raise LaminaError(
                "{path}: line {number} has {cells} cells where {columns} are named{hint}",
                path=path,
                number=number,
                cells=len(cells),
                columns=len(names),
                hint=Sentence("; truncated?") if len(cells) < len(names) else "",
            )
        try:
            rows.append([_number(name, cell) for name, cell in zip(names, cells)])
        except ValueError:
            name, bad = next(pair for pair in zip(names, cells) if not _is_number(*pair))
            raise LaminaError(
                "{path}: line {number}: {name} is {text!r}, which is not a number", path=path, number=number, name=name, text=bad.strip()
            ) from None
    return np.array(rows)


def _number(name: str, cell: str) -> float:
    """Of a cell; an empty one of a value was not measured, and what stands beside the values is not read."""
    if _BESIDE.fullmatch(name):
        return 0.0
    return float("nan") if not cell.strip() and name not in (*ANGLES, _WAVE) else float(cell)


def _is_number(name: str, cell: str) -> bool:
    try:
        _number(name, cell)
    except ValueError:
        return False
    return True


def _check_angles(path: Path, angles: np.ndarray, line_numbers: list[int]) -> None:
    for column, (name, low, high) in enumerate((("theta_i", -90, 180), ("phi_i", -360, 360), ("theta_o", -90, 180), ("phi_o", -360, 360))):
        values = angles[:, column]
        bad = ~((values >= max(low, 0) if name.startswith("theta") else values >= low) & (values <= high))
        if bad.any():
            at = int(np.argmax(bad))
            raise LaminaError(
                "{path}: line {line}: {name} is {value:g}; choose {low} to {high} degrees",
                path=path,
                line=line_numbers[at],
                name=name,
                value=values[at],
                low=low,
                high=high,
            )
    if angles[:, [0, 2]].max() <= 0.5 * np.pi + 1e-9 and angles[:, [0, 2]].max() > 0.1:
        raise LaminaError("{path}: no angle from the normal exceeds {most:.3g}: these are radians; give degrees", path=path, most=angles[:, [0, 2]].max())
    rounded = np.round(angles, 4)
    rounded[:, [1, 3]] %= 360.0
    order = np.lexsort(rounded.T)
    same = np.all(rounded[order[1:]] == rounded[order[:-1]], axis=1)
    if same.any():
        at = int(np.argmax(same))
        first, second = sorted(line_numbers[k] for k in (order[at], order[at + 1]))
        raise LaminaError(
            "{path}: lines {first} and {second} have the same angles; give each pair of directions once ({count} such)",
            path=path,
            first=first,
            second=second,
            count=int(same.sum()),
        )
