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
from .solve import Ask

DEFAULT_MODEL = "adding"
# Residuals are never believed to be smaller than this: the accuracy of `adding`'s f.
MODEL_ERROR = 0.005
# Coarser and three to five times as fast: within .1 % in the median, some percent near grazing angles. For choosing a structure.
QUICK: dict[str, Mapping] = {"adding": {"nodes": 16, "modes": 40, "draft": 1}}
# For derivatives, whose steps are about as small as a draft's single precision.
SMOOTH: dict[str, Mapping] = {"adding": {"nodes": 16, "modes": 40}}
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
        here = self.compressed(x) if here is None else here
        return self._slopes(x, self.compressed_at(self._moved(x)) - here)

    def answers(self, asks: list[Ask]) -> list[np.ndarray]:
        """Residuals and Jacobians that searches ask for, of one evaluation of many stacks."""
        rows = [ask.x[None] if ask.r is None else self._moved(ask.x) for ask in asks]
        values = np.split(self.compressed_at(np.concatenate(rows)) - self.target, np.cumsum([len(part) for part in rows])[:-1])
        return [part[0] if ask.r is None else self._slopes(ask.x, part - ask.r) for ask, part in zip(asks, values)]

    def _moved(self, x: np.ndarray) -> np.ndarray:
        """(groups, p) coordinates of which those of one group are a step away."""
        moved, steps = np.tile(x, (len(self.parameters.groups), 1)), _steps(x)
        for row, group in zip(moved, self.parameters.groups):
            row[list(group.index)] += steps[list(group.index)]
        return moved

    def _slopes(self, x: np.ndarray, differences: np.ndarray) -> np.ndarray:
        """(n * c, p) of what each group's step changes, (groups, n * c)."""
        steps, channels = _steps(x), self.parameters.channels
        slopes = np.zeros((differences.shape[1], len(x)))
        for group, difference in zip(self.parameters.groups, differences):
            if group.is_color:
                for channel, i in enumerate(group.index):
                    slopes[channel::channels, i] = difference[channel::channels] / steps[i]
            else:
                slopes[:, group.index[0]] = difference / steps[group.index[0]]
        return slopes


def _steps(x: np.ndarray) -> np.ndarray:
    """(p,) steps of differences, which stay between 0 and 1."""
    return np.where(x > 0.5, -_STEP, _STEP)


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
