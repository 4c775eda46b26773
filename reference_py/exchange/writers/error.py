# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a table, read back, is from the truth that it was made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...fit.readers.measurement import half_angles, spread_pairs
from ...optics.frame import rotate_z
from .truth import Progress, Truth

PAIRS = 2000
# Where f cos is below this share of its mean, a relative error tells nothing.
_LEAST = 1e-3


@dataclass(frozen=True)
class TableError:
    """Relative errors of the worst channel at random pairs: the median, that of 95 %, and the worst with its directions in degrees."""

    mean: float
    """Of the light that a uniform sky sends to all views, the share that the table sends elsewhere."""
    median: float
    most: float
    worst: float
    wi_deg: tuple[float, float]
    wo_deg: tuple[float, float]
    noise: float
    """The truth's own median relative standard error; 0 where it has none."""

    def __str__(self) -> str:
        noise = f"; the truth's own noise is {100.0 * self.noise:.2g} %" if self.noise else ""
        where = " from ".join(f"{theta:.0f},{phi:.0f}" for theta, phi in (self.wo_deg, self.wi_deg))
        return (
            f"read back at {PAIRS} random pairs of directions: {100.0 * self.mean:.2g} % of the light is elsewhere; half of the values are within "
            f"{100.0 * self.median:.2g} %, 95 % within {100.0 * self.most:.2g} %, the worst is {100.0 * self.worst:.2g} % off (to {where} degrees){noise}"
        )


def of_table(truth: Truth, read_back: Callable[[np.ndarray, np.ndarray], np.ndarray], progress: Progress | None = None) -> TableError:
    """That of `read_back(wi, wo)`, (n, 3), at pairs spread over half and difference angles, so that highlights have their share."""
    rng = np.random.default_rng(1)
    wi, wo = spread_pairs(PAIRS, rng)
    turn = 2.0 * np.pi * rng.random(PAIRS)
    wi, wo = rotate_z(wi, turn), rotate_z(wo, turn)
    f, stderr = truth.f_stderr(wo, wi, progress)
    told = f.mean(axis=1) * wo[:, 2] >= _LEAST * np.mean(f.mean(axis=1) * wo[:, 2])
    wi, wo, f, stderr = wi[told], wo[told], f[told], stderr[told]
    scale = np.maximum(f, 0.1 * f.max(axis=1, keepdims=True))
    difference = np.abs(read_back(wi, wo) - f)
    error = np.max(difference / scale, axis=1)
    worst = int(np.argmax(error))
    weight = (wi[:, 2] * wo[:, 2] / _density(wi, wo))[:, None]
    return TableError(
        float(np.sum(difference * weight) / np.sum(f * weight)), float(np.median(error)), float(np.quantile(error, 0.95)), float(error[worst]), _degrees(wi[worst]), _degrees(wo[worst]),
        float(np.median(stderr / scale)),
    )  # fmt: skip


def _density(wi, wo) -> np.ndarray:
    """Of `spread_pairs`, up to a factor: even in sqrt(theta_h), theta_d and phi_d; pairs have the solid angle 4 cos(theta_d) dh dd."""
    theta_h, theta_d, _ = half_angles(wi, wo)
    return 1.0 / np.maximum(np.sqrt(theta_h) * np.sin(theta_h) * np.sin(theta_d) * np.cos(theta_d), 1e-12)


def _degrees(w: np.ndarray) -> tuple[float, float]:
    return float(np.degrees(np.arctan2(np.hypot(w[0], w[1]), w[2]))), float(np.degrees(np.arctan2(w[1], w[0])))
