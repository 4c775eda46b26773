# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes MERL's binary tables, which `fit.readers.merl` describes and reads; and looks them up as the database's own code does."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...atomic import replacing
from ...fit.readers.measurement import half_angles
from ...fit.readers.merl import SCALES, cell_directions
from .truth import Progress, Truth, require_finite, require_isotropic

SIZES = (90, 90, 180)
FORMAT = "MERL"
_BELOW = -1.0


def require_holdable(stack) -> None:
    """Raise LaminaError for what such a table cannot hold."""
    require_isotropic(stack, FORMAT, "--to rgl")
    require_finite(stack, FORMAT)


def table(truth: Truth, progress: Progress | None = None) -> np.ndarray:
    """f (90, 90, 180, 3) at the middle of every cell; -1 where one of the directions is below the horizon.

    Half of it is the other half: f of an isotropic stack is the same on both sides of the half vector's meridian.
    """
    wi, wo = (w.reshape(*SIZES, 3)[:, :, : SIZES[2] // 2] for w in cell_directions(SIZES))
    above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    half = np.full(wi.shape, _BELOW)
    half[above] = truth.f(wo[above], wi[above], progress)
    return np.concatenate([half, half[:, :, ::-1]], axis=2)


def write(values: np.ndarray, path: Path) -> None:
    """Write a `table`, whole or not at all. Raises LaminaError."""
    stored = np.where(values < 0.0, _BELOW, values / SCALES)
    with replacing(path) as temporary, open(temporary, "wb") as file:
        file.write(np.array(SIZES, "<i4").tobytes())
        file.write(np.moveaxis(stored, -1, 0).astype("<f8").tobytes())


def reader(path: Path) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """f(wi, wo), (n, 3), of a file of this module: that of the directions' cell, as in the database's BRDFRead."""
    values = np.fromfile(path, "<f8", offset=12).reshape(3, -1)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        theta_h, theta_d, phi_d = half_angles(wi, wo)
        places = (np.sqrt(theta_h / (0.5 * np.pi)), theta_d / (0.5 * np.pi), phi_d / np.pi)
        cell = np.ravel_multi_index([np.minimum((p * n).astype(int), n - 1) for p, n in zip(places, SIZES)], SIZES)
        return values[:, cell].T * SCALES

    return f
