# SPDX-License-Identifier: GPL-3.0-or-later
"""What a model is to its users."""

from typing import Protocol

import numpy as np


class Model(Protocol):
    """A stack in numbers. The colour axis, written (..., 3) below, has `channels` entries: one per wavelength for a stack of `spectral`.

    What directions may be, and what becomes of those that are not, is the same for all (`optics.frame`).
    Most models can be sampled: `sample(wo, rng)` gives (wi, valid), (..., 3) and (...), and `pdf(wo, wi)` the density (...) of wi in
    1/sr; the truths draw theirs of simple lobes (`optics.quadrature.LobeMixture`). Samples that are not valid have value 0 and count as samples. Those that draw random numbers are `stochastic`, and
    have `f_stderr` and `albedo_stderr`.
    """

    name: str
    stochastic: bool
    channels: int

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine, for directions (..., 3); mirror-like components have none and count as 0."""
        ...

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like components included."""
        ...


class SampledModel(Model, Protocol):
    """A model that can be sampled."""

    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo, and whether it is valid, (...)."""
        ...

    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample`."""
        ...
