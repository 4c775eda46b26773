# SPDX-License-Identifier: GPL-3.0-or-later
"""MERL's binary tables (Matusik et al. 2003): three int32 sizes, then all red, green and blue values as doubles.

Axes are theta_h (spaced as the root of the angle), theta_d and phi_d (0 to pi) of Rusinkiewicz 1998, the last one
fastest; (90, 90, 180) in the database. Little-endian. Values are f times a factor per channel; negative means not valid.
"""

from itertools import permutations
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence
from .measurement import Measurement, checked, directions_of

SCALES = np.array([1.0, 1.15, 1.66]) / 1500.0
_MOST = 100_000_000
# Share of cells that are marked as the geometry says; below it, another order of axes that does clearly better is the file's.
_ALIKE, _CLEARLY = 0.97, 0.015


def read(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError on a wrong size, byte order, order of axes, or black data."""
    with open(path, "rb") as file:
        head = file.read(12)
        if len(head) < 12:
            raise LaminaError("{path}: {count} bytes are no MERL file, which starts with three int32 sizes", path=path, count=len(head))
        sizes = _sizes(path, head)
        data = np.fromfile(file, dtype="<f8")
    expected = 3 * int(np.prod(sizes))
    if len(data) != expected:
        raise LaminaError(
            "{path}: {what}, {count} values where {sizes} directions of three colors need {expected}",
            path=path,
            what=Sentence("truncated") if len(data) < expected else Sentence("too long"),
            count=len(data),
            sizes=" x ".join(map(str, sizes)),
            expected=expected,
        )
    table = data.reshape(3, -1)
    if np.all(np.abs(table[np.isfinite(table)]) < 1e-30) and np.isfinite(table).any():
        raise LaminaError("{path}: all {expected} values are 0: a black measurement tells nothing", path=path, expected=expected)
    _require_plausible(path, table)
    wi, wo = cell_directions(sizes)
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    _require_order(path, sizes, table, above)
    # cells below the horizon belong to the format; they are no fault of the file
    found = (Sentence("MERL table of {sizes}: theta_h, theta_d, phi_d", sizes=" x ".join(map(str, sizes))),)
    f = np.stack([channel[above] * scale for channel, scale in zip(table, SCALES)], axis=-1)
    return checked(wi[above], wo[above], f, str(path), found, only_nm=wavelength_nm, steepest_deg=steepest_deg)


def cell_directions(sizes: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """wi, wo (n, 3) at the middle of every cell, in the file's order."""
    h, d, p = ((np.arange(n) + 0.5) / n for n in sizes)
    angles = np.meshgrid(np.square(h) * 0.5 * np.pi, d * 0.5 * np.pi, p * np.pi, indexing="ij", sparse=True)
    wi, wo = directions_of(*angles)
    return wi.reshape(-1, 3), wo.reshape(-1, 3)


def _sizes(path: Path, head: bytes) -> tuple[int, int, int]:
    little, big = (np.frombuffer(head, dtype=kind).tolist() for kind in ("<i4", ">i4"))

    def fits(sizes):
        return sizes[0] == sizes[1] and sizes[2] == 2 * sizes[0] and 4 <= sizes[0] and 3 * np.prod(sizes, dtype=float) <= _MOST

    if fits(little):
        return tuple(little)
    if fits(big):
        raise LaminaError("{path}: written with the other byte order (big-endian sizes {big}); MERL files are little-endian", path=path, big=big)
    if any(fits(list(order)) for order in permutations(little)):
        raise LaminaError("{path}: axes are swapped, sizes {little}; choose the order theta_h, theta_d, phi_d, such as 90, 90, 180", path=path, little=little)
    raise LaminaError("{path}: sizes {little} are no MERL table's; choose n, n, 2 n, such as 90, 90, 180", path=path, little=little)


def _require_plausible(path: Path, table: np.ndarray) -> None:
    """Doubles in the other byte order are numbers of wild size."""
    sample = table[:, :: max(1, table.shape[1] // 4000)]
    magnitude = np.abs(sample[np.isfinite(sample) & (sample != 0.0)])
    if len(magnitude) and np.mean((magnitude < 1e-30) | (magnitude > 1e30)) > 0.2:
        raise LaminaError(
            "{path}: values are not plausible (such as {value:.3g}): written with the other byte order? MERL files hold little-endian doubles",
            path=path,
            value=magnitude[0],
        )


def _require_order(path: Path, sizes, table: np.ndarray, above: np.ndarray) -> None:
    """Cells that are marked as invalid must be those below the horizon."""
    marked = np.all(table > 0.0, axis=0)
    if marked.all():
        return  # nothing is marked
    agree = {}
    for order in permutations(range(3)):
        restored = marked.reshape([sizes[axis] for axis in order]).transpose(np.argsort(order)).ravel()
        agree[order] = np.mean(restored == above)
    best = max(agree, key=agree.get)
    if agree[0, 1, 2] < _ALIKE and agree[best] > agree[0, 1, 2] + _CLEARLY:
        raise LaminaError(
            "{path}: axes are swapped: its invalid cells lie below the horizon only if the file's order is {order}; MERL's is theta_h, theta_d, phi_d",
            path=path,
            order=_named(best),
        )


def _named(order) -> str:
    return ", ".join(("theta_h", "theta_d", "phi_d")[axis] for axis in order)
