# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the constants of the tier `analytic` again (`reference_py/network/analytic/calibration.py`), from `models.adding`.

    python -m lamina.study.calibrate_analytic [--seed N] [--start committed|plain] [--write]

Levenberg-Marquardt steps in the constants' logarithms (logits where they have an upper limit), on the signed relative errors of the
albedo in per cent, of every channel at 0, 40, 65 and 80 degrees, squared in size so that large ones count. Stacks: the suite and the
paper's presets (weight 1) and `TRAINING` random ones (weight 1/4). Two constants are found by themselves: LOBE_BEND moves no energy
and is fitted to shapes, BRUSHED_KEPT matters under anisotropy alone and is fitted to the walks of `position_free`.
Prints committed and fitted constants, and the errors of both on what was fitted and on what was held out.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from ..reference_py import presets
from ..reference_py.fit.solve import least_squares
from ..reference_py.frame import spherical
from ..reference_py.models.adding.model import Adding
from ..reference_py.network.analytic import AnalyticNetwork, base, beam, calibration, network
from ..reference_py.network.analytic.tables import closure_energy
from ..reference_py.network.closure import lobe_energy
from ..reference_py.network.lobe import DiffuseLobe, GlossyLobe
from ..reference_py.stack import Stack
from ..reference_py.suite import suite
from .calibration.source import Value, read_constants, rounded, write_constants
from .calibration.stacks import hard_stacks, plain_stacks

FILE = Path(calibration.__file__)
THETA_DEG = (0.0, 40.0, 65.0, 80.0)
SEED = 7
TRAINING, HELD_OUT, HELD_OUT_HARD = 51, 60, 30
# Of the sum of squares that random stacks have, over those that have names.
RANDOM_WEIGHT = 0.25

# What energies are fitted by, from where a fit starts that knows nothing, and an upper limit.
_LIMITED = {"MOST_SHARE": 1.0, "TRAPPED_COS": 1.0, "TAU_SHARE": 1.0, "MOST_LOBE_SHARE": 1.0, "KEPT_ORDER": 1.0}
PLAIN: dict[str, Value] = {
    "LEAN_GGX": (1.0, 1.0, 1.0), "LEAN_BECKMANN": (1.0, 1.0, 1.0), "LOBE_SPREAD": 1.0, "SPREAD_GRAZING": 1.0, "MOST_SHARE": 0.9,
    "SPREAD_INCIDENCE": 1.0, "SPREAD_HALF": 1.0, "SPREAD_LIMIT": 1.0, "BACK_SPREAD": 1.0, "TRAPPED_COS": 0.5, "TRAPPED_SPREAD": 1.0,
    "TAU_SPREAD": 1.0, "TAU_SHARE": 0.9, "EXIT_SPREAD": 1.0, "NODE_SPREAD": 1.0, "MOST_LOBE_SHARE": 0.9,
    "STIR_SCALE": 0.3, "STIR_BACK": 0.3, "STIR_POWER": 1.0, "KEPT_ORDER": 0.5, "KEPT_SCALE": 0.1, "BASE_LOSS": 0.3,
}  # fmt: skip
# How far a constant may go from where it starts, in its logarithm or logit, and the step of derivatives.
_RANGE, _STEP = 3.0, 1e-3


@contextmanager
def in_force(values: Mapping[str, Value]) -> Iterator[None]:
    """The tier with other constants."""
    places = [(module, name) for module in (calibration, beam, base, network) for name in values if hasattr(module, name)]
    before = [getattr(module, name) for module, name in places]
    try:
        for module, name in places:
            setattr(module, name, values[name])
        yield
    finally:
        for (module, name), value in zip(places, before):
            setattr(module, name, value)


def to_numbers(values: Mapping[str, Value]) -> np.ndarray:
    """The constants of `PLAIN` (p,) as the solver sees them."""
    parts = []
    for name in PLAIN:
        v = np.atleast_1d(np.asarray(values[name], float))
        parts.append(np.log(v / (_LIMITED[name] - v)) if name in _LIMITED else np.log(v))
    return np.concatenate(parts)


def from_numbers(x: np.ndarray) -> dict[str, Value]:
    """The inverse of `to_numbers`."""
    values: dict[str, Value] = {}
    at = 0
    for name, like in PLAIN.items():
        count = len(like) if isinstance(like, tuple) else 1
        v = np.exp(x[at : at + count])
        v = _LIMITED[name] * v / (1.0 + v) if name in _LIMITED else v
        values[name] = tuple(map(float, v)) if isinstance(like, tuple) else float(v[0])
        at += count
    return values


class Case:
    """A stack, its albedo (v, 3) by the truth at `THETA_DEG`, and its weight."""

    def __init__(self, stack: Stack, weight: float = 1.0, truth: np.ndarray | None = None):
        self.stack, self.weight = stack, weight
        theta = np.radians(THETA_DEG)
        self._cos = np.cos(theta)
        self.truth = Adding(stack).albedo(spherical(theta, 0.0)) if truth is None else truth
        # no constant moves what these lobes have with weight 1, and it takes most of the time
        self._units = [_unit_energy(lobe, self._cos) for lobe in AnalyticNetwork(stack).lobes(self._cos)]

    def albedo(self) -> np.ndarray:
        """(v, 3) by the tier with the constants in force."""
        total = np.zeros(self.truth.shape)
        for lobe, unit in zip(AnalyticNetwork(self.stack).lobes(self._cos), self._units):
            total += lobe.weight * (closure_energy(self._cos, lobe.alpha_x, lobe.distribution)[:, None] if unit is None else unit)
        return total

    def errors(self) -> np.ndarray:
        """(v, 3) signed and relative."""
        return (self.albedo() - self.truth) / np.maximum(self.truth, 1e-3)


def _unit_energy(lobe: GlossyLobe | DiffuseLobe, cos_theta: np.ndarray) -> np.ndarray | None:
    """Energy (v, 3) of a lobe of weight 1; None for one whose width the constants move."""
    if isinstance(lobe, GlossyLobe) and lobe.fresnel is None:
        return None
    return lobe_energy(type(lobe)(**{**vars(lobe), "weight": np.ones((len(cos_theta), 3))}), cos_theta)


def fit(cases: Sequence[Case], start: Mapping[str, Value], steps: int = 40, report: Callable[[str], None] = lambda text: None) -> dict[str, Value]:
    """Constants that leave least, from those of `start`."""

    def residual(x: np.ndarray) -> np.ndarray:
        with in_force(from_numbers(x)):
            errors = [np.sqrt(case.weight) * 100.0 * case.errors() for case in cases]
        flat = np.concatenate([e.ravel() for e in errors])
        return flat * np.abs(flat)

    def jacobian(x: np.ndarray, r: np.ndarray) -> np.ndarray:
        report(f"sum of squares {r @ r:.5g}")
        return np.stack([(residual(x + step) - r) / _STEP for step in _STEP * np.eye(len(x))], axis=1)

    x = to_numbers(start)
    return from_numbers(least_squares(residual, jacobian, x, x - _RANGE, x + _RANGE, steps, tolerance=1e-5).x)
