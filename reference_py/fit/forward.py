# SPDX-License-Identifier: GPL-3.0-or-later
"""The model that is fitted, seen from a vector of parameters: residuals and derivatives.

Derivatives are differences, one evaluation per parameter: a color's three channels move at once, as each sees its own
alone (Curtis, Powell and Reid 1974, "On the Estimation of Sparse Jacobian Matrices"). Measured: 9 evaluations for the 22 values of two layers over metal.

The truth `adding` takes .5 to 5 seconds per evaluation and the closures of the method `analytic`, which are within 1 to 2 %
of it in the median, 2 to 9 ms; so `fitting` takes the derivatives, and the starts, from the latter.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import LaminaError
from ..registry import MODELS, make_model
from .metric import Metric
from .parameters import Parameters

DEFAULT_MODEL = "adding"
# Residuals are never believed to be smaller than this: the accuracy of `adding`'s f.
MODEL_ERROR = 0.005
# What stands in for a slow model: a model's name and options.
_STAND_IN = {"adding": ("closure_model", {"method": "analytic"})}
# Coarser and about twice as fast: within .1 % in the median, some percent near grazing angles. For choosing a structure.
QUICK = {"adding": {"nodes": 16, "modes": 40}}
# Of media that scatter, which no fast model knows, the same model stands in: within .1 %, in a tenth of the time.
_COARSE = {"nodes": 12, "modes": 12}
CLOUDY_MODEL = "adding"
_STEP = 1e-4


def fittable() -> tuple[str, ...]:
    """Models that can be fitted: without noise, and functions of a stack."""
    return tuple(name for name, model in MODELS.items() if not model.stochastic and name != "lafortune")


def require_fittable(name: str) -> None:
    """Raise LaminaError for a model that cannot be fitted."""
    if name not in fittable():
        raise LaminaError("model {name!r} cannot be fitted; choose {choices}", name=name, choices=", ".join(fittable()))


def evaluate(model: str, options: dict, stack, wo, wi, channels: int) -> np.ndarray:
    """f (n, channels) of a model."""
    return make_model(model, stack, **options).f(wo, wi)[:, :channels]


@dataclass(frozen=True)
class Forward:
    """A model's compressed residuals against one metric's data."""

    model: str
    options: tuple[tuple[str, str], ...]
    parameters: Parameters
    metric: Metric

    def compressed(self, x: np.ndarray) -> np.ndarray:
        """(n * c,) of coordinates (p,)."""
        m, p = self.metric.measurement, self.parameters
        f = evaluate(self.model, dict(self.options), p.stack(x), m.wo, m.wi, m.channels)
        return self.metric.compressed(f).ravel()

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
        jacobian = np.zeros((len(here), len(x)))
        for group in self.parameters.groups:
            index = list(group.index)
            step = np.where(x[index] > 0.5, -_STEP, _STEP)
            there = x.copy()
            there[index] += step
            difference = (self.compressed(there) - here).reshape(-1, channels)
            if group.is_color:
                for channel, i in enumerate(index):
                    jacobian[channel::channels, i] = difference[:, channel] / step[channel]
            else:
                jacobian[:, index[0]] = difference.ravel() / step[0]
        return jacobian


def stand_in(model: str, parameters: Parameters, metric: Metric) -> tuple[Forward, bool]:
    """What starts and derivatives come from, and whether it is another model than `model`."""
    if parameters.structure.cloudy:
        return Forward(model, tuple(_COARSE.items()), parameters, metric), False
    name, options = _STAND_IN.get(model, (model, {}))
    return Forward(name, tuple(options.items()), parameters, metric), model in _STAND_IN
