# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes f as text on an even grid of angles, which `fit.readers.text_table` reads: a row for every pair of directions.

theta_i, phi_i, theta_o, phi_o in degrees, r, g, b in 1/sr without cosine. Isotropic stacks have no phi_i, and phi_o, from the light's azimuth, up to
180: they reflect alike on both sides. Anisotropic ones have phi_i up to 180, as their axes are those of an ellipse.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...atomic import write_text
from ...optics.frame import azimuth, spherical
from .truth import Progress, Truth, is_isotropic, require_finite

FORMAT = "a table of angles"
# Steepest angle in degrees; beyond it f changes too fast for an even grid.
_STEEPEST_DEG = 85.0


def require_holdable(stack) -> None:
    """Raise LaminaError for what such a table cannot hold."""
    require_finite(stack, FORMAT)


def axes_of(isotropic: bool, step_deg: float) -> dict[str, np.ndarray]:
    """Values in degrees of every angle, by its column."""
    theta, half = np.arange(0.0, _STEEPEST_DEG + 1e-9, step_deg), np.linspace(0.0, 180.0, max(round(180.0 / step_deg), 1) + 1)
    if isotropic:
        return {"theta_i": theta, "theta_o": theta, "phi_o": half}
    return {"theta_i": theta, "phi_i": half, "theta_o": theta, "phi_o": np.concatenate([half, half[1:-1] + 180.0])}


def text(truth: Truth, step_deg: float, progress: Progress | None = None) -> str:
    """The whole table."""
    axes = axes_of(is_isotropic(truth.stack), step_deg)
    rows = np.stack([values.ravel() for values in np.meshgrid(*axes.values(), indexing="ij")], axis=-1)
    angle = dict(zip(axes, np.radians(rows.T)))
    f = truth.f(spherical(angle["theta_o"], angle["phi_o"]), spherical(angle["theta_i"], angle.get("phi_i", 0.0)), progress)
    lines = [",".join([*axes, "r", "g", "b"]), *(",".join(f"{v:.6g}" for v in row) for row in np.concatenate([rows, f], axis=1))]
    return "\n".join(lines) + "\n"


def write(table: str, path: Path) -> None:
    """Write a `text`, whole or not at all. Raises LaminaError."""
    write_text(path, table)


class Interpolation:
    """f of a file of this module, linear in every angle between its rows."""

    def __init__(self, path: Path):
        with open(path, encoding="utf-8") as file:
            names = file.readline().strip().split(",")[:-3]
            rows = np.loadtxt(file, delimiter=",")
        self._axes = {name: np.unique(rows[:, i]) for i, name in enumerate(names)}
        self._f = rows[:, -3:].reshape(*(len(axis) for axis in self._axes.values()), 3)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (n, 3) at directions (n, 3)."""
        phi_i, phi_o = np.degrees(azimuth(wi)), np.degrees(azimuth(wo))
        if "phi_i" in self._axes:
            half_turn = np.where(phi_i % 360.0 >= 180.0, 180.0, 0.0)
            phi_i, phi_o = (phi_i - half_turn) % 360.0, (phi_o - half_turn) % 360.0
        else:
            phi_o = np.abs((phi_o - phi_i + 180.0) % 360.0 - 180.0)
        angles = {"theta_i": _theta(wi), "phi_i": phi_i, "theta_o": _theta(wo), "phi_o": phi_o}
        return self._mixed([angles[name] for name in self._axes])

    def _mixed(self, angles: Sequence[np.ndarray]) -> np.ndarray:
        f, index, weights = self._f, [np.zeros(len(angles[0]), int)], [np.ones(len(angles[0]))]
        flat, strides = f.reshape(-1, 3), np.cumprod([1, *f.shape[-2:0:-1]])[::-1]
        for values, (name, axis), stride in zip(angles, self._axes.items(), strides):
            wraps = name == "phi_o" and axis[-1] > 180.0
            nodes = np.append(axis, 360.0) if wraps else axis
            low = np.clip(np.searchsorted(nodes, values, side="right") - 1, 0, max(len(nodes) - 2, 0))
            high = np.minimum(low + 1, len(nodes) - 1)
            share = np.clip((values - nodes[low]) / np.maximum(nodes[high] - nodes[low], 1e-9), 0.0, 1.0)
            index = [place + stride * (side % len(axis)) for place in index for side in (low, high)]
            weights = [weight * part for weight in weights for part in (1.0 - share, share)]
        return sum(weight[:, None] * flat[place] for place, weight in zip(index, weights))


def _theta(w: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))
