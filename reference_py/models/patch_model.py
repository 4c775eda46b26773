# SPDX-License-Identifier: GPL-3.0-or-later
"""A model of a stack with covered or opaque layers: the mixture of the models of its patches (`coverage`)."""

from collections.abc import Callable, Sequence

import numpy as np

from ..material.coverage import Patch
from ..optics.frame import generator, sampled
from .model import SampledModel


class PatchModel:
    """What a model says of a stack of several patches: every figure is the patches' mean, weighted by their shares."""

    def __init__(self, parts: Sequence[tuple[Patch, SampledModel]]):
        models = [model for _, model in parts]
        self._shares, self._models = np.array([patch.share for patch, _ in parts]), models
        self.name, self.stochastic, self.channels = models[0].name, models[0].stochastic, models[0].channels

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like components have none and count as 0."""
        return self._mean(lambda model: model.f(wo, wi))

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like components included."""
        return self._mean(lambda model: model.albedo(wo))

    def f_stderr(self, wo, wi, *, rng=None, progress=None, cancel=None) -> tuple[np.ndarray, np.ndarray]:
        """`f` and its standard error, both (..., 3), of models that have one."""
        return self._mean_and_stderr(lambda model, rng: model.f_stderr(wo, wi, rng=rng, progress=progress, cancel=cancel), rng)

    def albedo_stderr(self, wo, *, rng=None, progress=None, cancel=None) -> tuple[np.ndarray, np.ndarray]:
        """`albedo` and its standard error, both (..., 3), of models that have one."""
        return self._mean_and_stderr(lambda model, rng: model.albedo_stderr(wo, rng=rng, progress=progress, cancel=cancel), rng)

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo, of a patch picked by its share, and whether it is valid, (...)."""
        chosen = rng.choice(len(self._models), size=len(wo), p=self._shares)
        wi, valid = np.zeros(wo.shape), np.zeros(len(wo), bool)
        for i, model in enumerate(self._models):
            here = chosen == i
            if np.any(here):
                wi[here], valid[here] = model.sample(wo[here], rng)
        return wi, valid

    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample`."""
        return self._mean(lambda model: model.pdf(wo, wi))

    def _mean(self, figure: Callable) -> np.ndarray:
        return sum(share * figure(model) for share, model in zip(self._shares, self._models))

    def _mean_and_stderr(self, figures: Callable, rng) -> tuple[np.ndarray, np.ndarray]:
        """Without an rng the patches have the same random numbers, so their errors may add up."""
        rng = None if rng is None else generator(rng)
        pairs = [figures(model, rng) for model in self._models]
        mean = sum(share * value for share, (value, _) in zip(self._shares, pairs))
        errors = [share * error for share, (_, error) in zip(self._shares, pairs)]
        return mean, sum(errors) if rng is None else np.sqrt(sum(np.square(error) for error in errors))
