# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in for a slow model: starts and derivatives come from it.

The truth `adding` takes .1 to 5 seconds per evaluation. The closures of the method `analytic`, which are within 1 to 2 % of it in the
median, take 2 ms, and as much for all the stacks of a Jacobian or of many guesses, as most of it is numpy's calls. To that end lobes are
asked for at a few views and interpolated; fits ask for smoothness more than for what tables say between these.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..lobes.analytic import AnalyticLobes
from ..lobes.closure import lobe_f
from ..lobes.lobe import DiffuseLobe, GlossyLobe
from ..lobes.view_table import MIN_COS_O
from .forward import Forward, ModelForward
from .metric import Metric
from .parameters import Parameters

# Models that another stands in for.
_SLOW = ("adding",)
# Of media that scatter, which no fast model knows, the same model stands in: within .1 %, in a tenth of the time.
_COARSE = {"nodes": 12, "modes": 12}
# Views that lobes are asked for.
_KNOTS = 24


@dataclass(frozen=True, eq=False, repr=False)
class StandIn(Forward):
    """The method's closures, plus what these lack to the model at some place, against one metric's data."""

    discrepancy: np.ndarray | float

    @cached_property
    def _views(self) -> tuple[np.ndarray, np.ndarray]:
        """Cosines (K,) at which lobes are asked for, even in their root, and weights (n, K) of the cubic through four of them for each view."""
        root = np.sqrt(np.maximum(self.metric.measurement.wo[:, 2], MIN_COS_O))
        low, high = float(np.min(root)), float(np.max(root))
        knots = np.linspace(low, high, _KNOTS)
        place = (root - low) / max(high - low, 1e-9) * (_KNOTS - 1)
        first = np.clip(place.astype(int) - 1, 0, _KNOTS - 4)
        weights = np.zeros((len(root), _KNOTS))
        for own in range(4):
            share = np.prod([(place - first - other) / (own - other) for other in range(4) if other != own], axis=0)
            weights[np.arange(len(root)), first + own] = share
        return np.square(knots), weights

    def compressed_at(self, x: np.ndarray) -> np.ndarray:
        """(B, n * c) of coordinates (B, p)."""
        _, kind = np.unique(self._kinds(x), axis=0, return_inverse=True)
        result = np.empty((len(x), self.target.size))
        for k in range(np.max(kind) + 1):
            result[kind.ravel() == k] = self._alike(x[kind.ravel() == k])
        return result

    def _kinds(self, x: np.ndarray) -> np.ndarray:
        """(B, k) what is equal for stacks of one way through the formulas: whether media are denser than those above, and whether a base has facets."""
        values = {name: [g.value(x[:, g.index[0]]) for g in self.parameters.groups if g.parameter.name == name] for name in ("ior", "sigma_deg")}
        indices = np.stack([np.ones(len(x)), *values["ior"]], axis=1)
        return np.hstack([np.sign(np.diff(indices, axis=1)), np.sign(np.array(values["sigma_deg"])).T.reshape(len(x), -1)])

    def _alike(self, x: np.ndarray) -> np.ndarray:
        m, (cos_o, weights) = self.metric.measurement, self._views
        f = np.zeros(())
        for lobe in AnalyticLobes(self.parameters.together(x)).lobes_of(cos_o):
            f = f + lobe_f(_between(lobe, weights, (len(x), len(cos_o))), m.wo, m.wi)
        return self.metric.compressed(f[..., : m.channels]).reshape(len(x), -1) + self.discrepancy


def _between(lobe: GlossyLobe | DiffuseLobe, weights: np.ndarray, shape: tuple[int, int]):
    """A lobe of views `shape`[1:] at others, by weights (n, K)."""
    lobe = replace(lobe, weight=weights @ np.broadcast_to(lobe.weight, (*shape, 3)))
    if isinstance(lobe, DiffuseLobe):
        return lobe
    alpha_x, alpha_y = (np.broadcast_to(alpha, shape) @ weights.T for alpha in (lobe.alpha_x, lobe.alpha_y))
    return replace(lobe, alpha_x=alpha_x, alpha_y=alpha_y)


def stand_in(model: str, parameters: Parameters, metric: Metric, discrepancy: np.ndarray | float = 0.0) -> tuple[Forward, bool]:
    """What starts and derivatives come from, and whether it is another model than `model`: then it gets the discrepancy (n * c,) from that."""
    if parameters.structure.cloudy:
        return ModelForward(parameters, metric, model, _COARSE), False
    return (StandIn(parameters, metric, discrepancy), True) if model in _SLOW else (ModelForward(parameters, metric, model, {}), False)
