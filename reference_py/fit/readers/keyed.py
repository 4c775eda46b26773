# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables below a header of keys: ASTM E1392 as Cornell's files have it, and ALTA's text files.

ASTM: lines of a key and a word, then VARS with the names of the columns, two polar and two azimuth angles in radians, then
rows with commas; a name that ends in nm is a wavelength. ALTA: #DIM inputs outputs, #PARAM_IN, #PARAM_OUT, #VS, then rows of
angles in radians and f; PARAM_OUT with COS holds f times the cosine of the view.
"""

import re
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence
from ...optics.colour import xyz_to_rgb
from ...optics.frame import spherical
from .measurement import Measurement, checked, directions_of

_MOST_BYTES = 500_000_000
_WAVELENGTH = re.compile(r"(\d+(?:\.\d+)?)\s*nm", re.I)
# Columns of ALTA's parametrizations that are read: Rusinkiewicz' angles, and those of light and view.
_RUSINKIEWICZ = {"RUSIN_TH_TD_PD": ("th", "td", "pd"), "RUSIN_TH_PH_TD_PD": ("th", "ph", "td", "pd")}
_PLAIN = {
    "SPHERICAL_TL_PL_TV_PV": ("ti", "pi", "to", "po"), "ISOTROPIC_TV_TL_DPHI": ("to", "ti", "po"), "ISOTROPIC_TL_TV_DPHI": ("ti", "to", "po"),
}  # fmt: skip
_RADIANCE = ("RGB_COLOR", "INV_STERADIAN", "ENERGY", "UNKNOWN_OUTPUT", "UNKNOWN")


def read_astm(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError where VARS is missing or a row is not as it says."""
    lines = _lines(path)
    at = next((i for i, line in enumerate(lines) if line.split(None, 1)[0].upper() == "VARS"), None)
    if at is None:
        raise LaminaError("{path}: no ASTM E1392 table: it has no line VARS with the names of its columns", path=path)
    names = [name.strip() for name in lines[at].split(None, 1)[-1].split(",")]
    if len(names) < 5:
        raise LaminaError("{path}: VARS has {columns} columns; choose theta_i,phi_i,theta_s,phi_s, then values", path=path, columns=len(names))
    numbers = _numbers(path, lines[at + 1 :], len(names), ",")
    announced = next((line.split()[-1] for line in lines[:at] if line.upper().startswith("NUM_POINTS")), None)
    if announced is not None and announced.isdigit() and int(announced) != len(numbers):
        raise LaminaError("{path}: NUM_POINTS announces {announced} rows, and {rows} follow; truncated?", path=path, announced=announced, rows=len(numbers))
    theta_i, phi_i, theta_o, phi_o = numbers[:, :4].T
    f, nm, notes = numbers[:, 4:], None, []
    matches = [_WAVELENGTH.search(name) for name in names[4:]]
    if all(matches):
        nm = np.array([float(match[1]) for match in matches if match])
    elif [name[0].upper() for name in names[4:]] == ["X", "Y", "Z"]:
        f, notes = xyz_to_rgb(f), [Sentence("XYZ made linear RGB")]
    elif f.shape[1] not in (1, 3):
        raise LaminaError("{path}: VARS names {names}; choose one value, RGB, XYZ, or names that end in nm", path=path, names=", ".join(names[4:])[:80])
    told = Sentence("ASTM E1392 table of {rows} rows, angles in radians: {names}", rows=len(numbers), names=", ".join(names[4:])[:80])
    found = (told, *notes)
    return checked(spherical(theta_i, phi_i), spherical(theta_o, phi_o), f, str(path), found, nm, wavelength_nm, steepest_deg)


def read_alta(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a text file. Raises LaminaError for a binary one, or a parametrization that is not known."""
    lines = _lines(path)
    keys = {words[0][1:].upper(): words[1:] for line in lines if re.match(r"#[A-Za-z]", line) and (words := line.split())}
    if "DIM" not in keys or len(keys["DIM"]) != 2 or not all(word.isdigit() for word in keys["DIM"]):
        raise LaminaError("{path}: no data file of ALTA: it has no line #DIM with the counts of inputs and outputs", path=path)
    if "FORMAT" in keys and "binary" in keys["FORMAT"]:
        raise LaminaError("{path}: is ALTA's binary format; write it as text", path=path)
    inputs, outputs = map(int, keys["DIM"])
    given, kind = (keys.get(key, ["UNKNOWN"])[0].upper() for key in ("PARAM_IN", "PARAM_OUT"))
    columns = _RUSINKIEWICZ.get(given) or _PLAIN.get(given)
    if columns is None or len(columns) != inputs:
        raise LaminaError(
            "{path}: PARAM_IN is {given} of {inputs} inputs; choose {choices}",
            path=path,
            given=given,
            inputs=inputs,
            choices=", ".join([*_RUSINKIEWICZ, *_PLAIN]),
        )
    has_cosine = "COS" in kind
    if not has_cosine and kind not in _RADIANCE:
        raise LaminaError(
            "{path}: PARAM_OUT is {kind}; choose {choices}, or one with COS for f times the cosine", path=path, kind=kind, choices=", ".join(_RADIANCE)
        )
    if outputs not in (1, 3):
        raise LaminaError("{path}: {outputs} outputs; choose 1 or 3, RGB", path=path, outputs=outputs)
    rows = [line for line in lines if not line.startswith("#")]
    numbers = _numbers(path, rows, len(rows[0].split()) if rows else 0, None)
    if numbers.shape[1] < inputs + outputs:
        raise LaminaError(
            "{path}: rows have {count} numbers where {inputs} + {outputs} are announced", path=path, count=numbers.shape[1], inputs=inputs, outputs=outputs
        )
    values, zero = dict(zip(columns, numbers.T)), np.zeros(len(numbers))
    if given in _RUSINKIEWICZ:
        wi, wo = directions_of(values["th"], values["td"], values["pd"])
        if "ph" in values:
            wi, wo = (_turned(w, values["ph"]) for w in (wi, wo))
    else:
        wi, wo = spherical(values["ti"], values.get("pi", zero)), spherical(values["to"], values["po"])
    f = numbers[:, inputs : inputs + outputs]
    if has_cosine:
        f = f / np.maximum(wo[:, 2:], 1e-6)
    cosine = Sentence(", divided by the cosine") if has_cosine else ""
    found = (Sentence("ALTA data of {rows} rows, {given}{cosine}", rows=len(numbers), given=given, cosine=cosine),)
    return checked(wi, wo, f, str(path), found, only_nm=wavelength_nm, steepest_deg=steepest_deg)


def _lines(path: Path) -> list[str]:
    if path.stat().st_size > _MOST_BYTES:
        raise LaminaError("{path}: {size} bytes are too large for a table; at most {most}", path=path, size=path.stat().st_size, most=_MOST_BYTES)
    return [line.strip() for line in path.read_text(encoding="latin-1").splitlines() if line.strip()]


def _numbers(path: Path, lines: list[str], count: int, delimiter: str | None) -> np.ndarray:
    if not lines:
        raise LaminaError("{path}: has no rows below its header; truncated?", path=path)
    rows = [line.split(delimiter) for line in lines]
    for row in rows:
        if len(row) != count:
            raise LaminaError(
                "{path}: the row {text!r} has {given} numbers where {count} are named; truncated?",
                path=path,
                text=" ".join(row)[:40],
                given=len(row),
                count=count,
            )
    try:
        return np.array(rows, float)
    except ValueError:
        raise LaminaError("{path}: a row holds what is not a number", path=path) from None


def _turned(w: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], axis=-1)
