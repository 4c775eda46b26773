# SPDX-License-Identifier: GPL-3.0-or-later
"""Do the two truths agree? `adding` against the walks of `position_free` on the published suite.

They share the optics of one surface and nothing else: one sums operators on a grid, the other follows light.
"""

from dataclasses import dataclass, fields

import numpy as np

from ..reference_py.material.stack import Stack
from ..reference_py.optics.frame import spherical
from ..reference_py.optics.optical_stack import rough_surfaces
from ..reference_py.registry import make_model

VIEWS_DEG = (0.0, 40.0, 65.0, 85.0)
SIGMAS = 4.0
ALBEDO_MEAN = 0.005
"""Relative error that the albedo's mean over `VIEWS_DEG` and channels may have."""
ADDING_ALBEDO, ADDING_F = 1e-3, 0.035
"""Largest relative errors that `adding` states for itself: albedo; f where no rough surface is narrower than `NARROW`."""
NARROW = 0.05
DARK = 0.02
"""Albedo, and share of the brightest f, that is added to denominators: relative errors of less mean nothing."""
UNSEEN = 1e-6
"""f in 1/sr that is added too, for stacks of mirrors alone, whose f is rounding."""
TARGET = 0.00125
"""Relative standard error at which more walks are not worth it."""


@dataclass(frozen=True)
class Agreement:
    """How far adding and walks are apart for one stack, worst over views, directions and channels."""

    walks: int
    """Walks per view."""
    stderr: float
    """Standard error of the walks' albedo, relative to albedo + `DARK`."""
    sigmas: float
    """Difference of albedo in standard errors, a quarter of `ADDING_ALBEDO` counted as one of them."""
    mean: float
    """Relative difference of the mean albedo."""
    f_median: float
    """Median difference of f, relative to f + `DARK` of the brightest, noise of the walks included."""
    f_beyond: float
    """Worst difference of f beyond 4 standard errors, likewise relative."""
    narrowest: float
    """alpha of the narrowest rough surface; 0 without any."""

    @property
    def albedo_agrees(self) -> bool:
        return self.sigmas <= SIGMAS and self.mean <= ALBEDO_MEAN

    @property
    def f_agrees(self) -> bool:
        """Also true where adding states no error for f: surfaces narrower than `NARROW`."""
        return 0.0 < self.narrowest < NARROW or self.f_beyond <= ADDING_F


COLUMNS = tuple(field.name for field in fields(Agreement))


def agreement(stack: Stack, most_walks: int = 131_072, f_walks: int = 4000, seed: int = 1) -> Agreement:
    """Compare both truths; walks are added until their standard error is `TARGET` or there are `most_walks`."""
    rng = np.random.default_rng(seed)
    adding = make_model("adding", stack)
    wo = spherical(np.radians(VIEWS_DEG), 0.0)
    walked, stderr, walks = _albedo(stack, wo, most_walks, rng)
    exact = adding.albedo(wo)
    gap = np.abs(exact - walked)
    noise = np.hypot(stderr, ADDING_ALBEDO / SIGMAS * walked)
    views, lights = direction_grid()
    f, f_error = make_model("position_free", stack, walks=f_walks).f_stderr(views, lights, rng=rng)
    f_gap, scale = np.abs(adding.f(views, lights) - f), f + DARK * np.max(f) + UNSEEN
    alphas = [alpha for _, alpha in rough_surfaces(stack)]
    return Agreement(
        walks=walks,
        stderr=float(np.max(stderr / (walked + DARK))),
        sigmas=float(np.max(gap / np.maximum(noise, 1e-12))),
        mean=float(abs(np.mean(exact) - np.mean(walked)) / np.mean(walked)),
        f_median=float(np.median(f_gap / scale)),
        f_beyond=float(np.max(np.maximum(f_gap - SIGMAS * f_error, 0.0) / scale)),
        narrowest=min(alphas, default=0.0),
    )


def direction_grid() -> tuple[np.ndarray, np.ndarray]:
    """(wo, wi), each (24, 3): two views with lights on the viewer's side, across and opposite."""
    theta_o, theta_i, phi = np.meshgrid([20.0, 60.0], [5.0, 35.0, 60.0, 80.0], [10.0, 90.0, 175.0], indexing="ij")
    return spherical(np.radians(theta_o.ravel()), 0.0), spherical(np.radians(theta_i.ravel()), np.radians(phi.ravel()))


def _albedo(stack: Stack, wo, most_walks: int, rng) -> tuple[np.ndarray, np.ndarray, int]:
    """Albedo (V, 3) by walks, its standard error, and how many walks each view took."""
    each = min(most_walks, 16_384)
    model = make_model("position_free", stack, walks=each)
    values, variances = [], []
    while True:
        value, error = model.albedo_stderr(wo, rng=rng)
        values.append(value)
        variances.append(np.square(error))
        mean, stderr = np.mean(values, axis=0), np.sqrt(np.sum(variances, axis=0)) / len(values)
        walks = each * len(values)
        if walks + each > most_walks or np.all(stderr <= TARGET * (mean + DARK)):
            return mean, stderr, walks
