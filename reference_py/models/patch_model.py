# SPDX-License-Identifier: GPL-3.0-or-later
"""A model of a stack with covered or opaque layers: the mixture of the models of its patches (`coverage`)."""

from collections.abc import Callable, Sequence

import numpy as np

from ..material.coverage import Patch
from .model import SampledModel


class PatchModel:
    """What a model says of a stack of several patches: every figure is the patches' mean, weighted by their shares."""

    def __init__(self, parts: Sequence[tuple[Patch, SampledModel]]):
        models = [model for _, model in parts]
        self._shares, self._models = np.array([patch.share for patch, _ in parts]), models
        self.name, self.stochastic = models[0].name, models[0].stochastic

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like components have none and count as 0."""
        return self._mean(lambda model: model.f(wo, wi))

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like components included."""
        return self._mean(lambda model: model.albedo(wo))

    def f_stderr(self, wo, wi, **options) -> tuple[np.ndarray, np.ndarray]:
        """`f` and its standard error, both (..., 3), of models that have one."""
        return self._mean_and_stderr(lambda model: model.f_stderr(wo, wi, **options))

    def albedo_stderr(self, wo, **options) -> tuple[np.ndarray, np.ndarray]:
        """`albedo` and its standard error, both (..., 3), of models that have one."""
        return self._mean_and_stderr(lambda model: model.albedo_stderr(wo, **options))

    def sample(self, wo: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo, of a patch picked by its share, and whether it is valid, (...)."""
        wo = np.asarray(wo, float)
        chosen = rng.choice(len(self._models), size=wo.shape[:-1], p=self._shares)
        wi, valid = np.zeros(wo.shape), np.zeros(wo.shape[:-1], bool)
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

    def _mean_and_stderr(self, figures: Callable) -> tuple[np.ndarray, np.ndarray]:
        pairs = [figures(model) for model in self._models]
        mean = sum(share * value for share, (value, _) in zip(self._shares, pairs))
        return mean, np.sqrt(sum(np.square(share * error) for share, (_, error) in zip(self._shares, pairs)))
