# SPDX-License-Identifier: GPL-3.0-or-later
"""The model that is fitted, seen from a vector of parameters: residuals and derivatives.

Derivatives are differences, one evaluation per parameter: a color's three channels move at once, as each sees its own
alone (Curtis, Powell and Reid 1974, "On the Estimation of Sparse Jacobian Matrices"). Measured: 9 evaluations for the 22 values of two layers over metal.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import LaminaError
from ..registry import MODELS, make_model
from .metric import Metric
from .parameters import Parameters

DEFAULT_MODEL = "adding"
# Residuals are never believed to be smaller than this: the accuracy of `adding`'s f.
MODEL_ERROR = 0.005
# Coarser and three to five times as fast: within .1 % in the median, some percent near grazing angles. For choosing a structure.
QUICK: dict[str, Mapping] = {"adding": {"nodes": 16, "modes": 40, "draft": 1}}
CLOUDY_MODEL = "adding"
_STEP = 1e-4


def fittable() -> tuple[str, ...]:
    """Models that can be fitted: without noise, and functions of a stack."""
    return tuple(name for name, model in MODELS.items() if not model.stochastic and name != "lafortune")


def require_fittable(name: str) -> None:
    """Raise LaminaError for a model that cannot be fitted."""
    if name not in fittable():
        raise LaminaError("model {name!r} cannot be fitted; choose {choices}", name=name, choices=", ".join(fittable()))


def evaluate(model: str, options: Mapping, stack, wo, wi, channels: int) -> np.ndarray:
    """f (n, channels) of a model."""
    return make_model(model, stack, **options).f(wo, wi)[:, :channels]


@dataclass(frozen=True)
class Forward:
    """Compressed residuals against one metric's data."""

    parameters: Parameters
    metric: Metric

    def compressed_at(self, x: np.ndarray) -> np.ndarray:
        """(B, n * c) of coordinates (B, p)."""
        raise NotImplementedError

    def compressed(self, x: np.ndarray) -> np.ndarray:
        """(n * c,) of coordinates (p,)."""
        return self.compressed_at(x[None])[0]

    def residual(self, x: np.ndarray) -> np.ndarray:
        """(n * c,), model less data, of coordinates (p,)."""
        return self.compressed(x) - self.target

    @property
    def target(self) -> np.ndarray:
        """(n * c,) the data, compressed."""
        return self.metric.target.ravel()

    def jacobian(self, x: np.ndarray, here: np.ndarray | None = None) -> np.ndarray:
        """(n * c, p) forward differences; `here` is `compressed(x)` where it is known."""
        here, channels = self.compressed(x) if here is None else here, self.parameters.channels
        groups, step = self.parameters.groups, np.where(x > 0.5, -_STEP, _STEP)
        there = np.tile(x, (len(groups), 1))
        for row, group in zip(there, groups):
            row[list(group.index)] += step[list(group.index)]
        jacobian = np.zeros((len(here), len(x)))
        for group, difference in zip(groups, self.compressed_at(there) - here):
            if group.is_color:
                for channel, i in enumerate(group.index):
                    jacobian[channel::channels, i] = difference[channel::channels] / step[i]
            else:
                jacobian[:, group.index[0]] = difference / step[group.index[0]]
        return jacobian


@dataclass(frozen=True)
class ModelForward(Forward):
    """Those of a model by name, stack after stack."""

    model: str
    options: Mapping

    def compressed_at(self, x: np.ndarray) -> np.ndarray:
        """(B, n * c) of coordinates (B, p)."""
        m, p = self.metric.measurement, self.parameters
        f = [evaluate(self.model, self.options, p.stack(each), m.wo, m.wi, m.channels) for each in x]
        return self.metric.compressed(np.stack(f)).reshape(len(x), -1)
