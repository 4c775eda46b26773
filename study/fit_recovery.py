# SPDX-License-Identifier: GPL-3.0-or-later
"""How well stacks are found again: random stacks, measured by the model itself, with and without noise.

The truth is taken at coarse settings for data and fit alike: as hard to invert, a third of the time.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..reference_py.fit.certainty import certainty
from ..reference_py.fit.fitting import Fit, fit_structure
from ..reference_py.fit.metric import Metric, shape_error
from ..reference_py.fit.parameters import Parameters, Structure
from ..reference_py.fit.readers.measurement import Measurement, checked, spread_pairs
from ..reference_py.material.stack import Stack
from ..reference_py.registry import make_model

_PAIRS, _HELD_OUT = 500, 1500
SETTINGS = {"adding": {"nodes": 16, "modes": 24}}
# Values in the schema's units between which random stacks lie.
_IN_RANGE = {
    "ior": (1.2, 2.0),
    "roughness": (0.2, 0.7),
    "tint": (0.3, 1.0),
    "color": (0.05, 0.95),
    "sigma_deg": (5.0, 40.0),
    "reflectance": (0.3, 0.95),
    "edge_color": (0.3, 1.0),
}
_KINDS = (("lambert", "ggx"), ("conductor", "ggx"), ("oren_nayar", "beckmann"), ("lambert", "beckmann"), ("conductor", "beckmann"))


@dataclass(frozen=True)
class Recovery:
    """One stack found again. `shape` and `error` are those of f at pairs that were not fitted, against data without noise;
    `worst` the largest relative error of a determined parameter. `data_error` is what the fit leaves of the data that it was
    given, and `true_data_error` what the true stack leaves of them, so the noise: a fit that leaves no more is as near as data can tell.
    """

    structure: Structure
    noise: float
    shape: float
    error: float
    data_error: float
    true_data_error: float
    worst: float
    worst_name: str
    determined: int
    count: int
    evaluations: int


def random_structure(layers: int, number: int) -> Structure:
    """Bases and distributions take turns."""
    return Structure.of(layers, *_KINDS[number % len(_KINDS)])


def random_stack(structure: Structure, rng: np.random.Generator) -> Stack:
    """A stack of a structure with values in the usual range."""
    parameters = Parameters(structure, 3)
    x = np.empty(parameters.size)
    for g in parameters.groups:
        low, high = _IN_RANGE[g.parameter.name]
        x[list(g.index)] = g.coordinate(low + (high - low) * rng.random(len(g.index)))
    return parameters.stack(x)


def data_of(stack: Stack, model: str, noise: float, rng: np.random.Generator, floor: float = 0.0) -> tuple[Measurement, Measurement]:
    """Data to fit, with multiplicative noise of deviation `noise` and additive of `floor` times the mean, and clean data."""
    wi, wo = spread_pairs(_PAIRS + _HELD_OUT, rng)
    f = make_model(model, stack, **SETTINGS.get(model, {})).f(wo, wi)
    clean = checked(wi, wo, f, "a random stack")
    noisy = f * (1.0 + noise * rng.standard_normal(f.shape)) + floor * np.mean(f) * rng.standard_normal(f.shape)
    first = slice(0, _PAIRS)
    return replace(clean.subset(first), f=np.maximum(noisy[first], 0.0)), clean.subset(slice(_PAIRS, None))


def recovery(stack: Stack, structure: Structure, model: str, noise: float, seed: int) -> tuple[Recovery, Fit]:
    """Fit a stack's own samples, its structure given."""
    data, clean = data_of(stack, model, noise, np.random.default_rng(seed))
    fit = fit_structure(data, structure, model, seed=seed, options=SETTINGS.get(model, {}))
    return judged(fit, stack, clean, model, noise), fit


def judged(fit: Fit, stack: Stack, clean: Measurement, model: str, noise: float) -> Recovery:
    """Compare a fit with the stack that it was made from."""
    settings, given = SETTINGS.get(model, {}), fit.metric.measurement
    f = make_model(model, fit.stack, **settings).f(clean.wo, clean.wi)
    noise_alone = fit.metric.error(make_model(model, stack, **settings).f(given.wo, given.wi)[:, : given.channels])
    parameters = fit.parameters
    truth = parameters.values(parameters.coordinates(stack))
    known = [(abs(v.value / t - 1.0), v.name) for v, t in zip(certainty(fit), truth) if v.determined]
    worst, name = max(known, default=(0.0, ""))
    shape, error = shape_error(f, clean.f, clean.wi[:, 2]), Metric(clean).error(f)
    return Recovery(fit.structure, noise, shape, error, fit.error, noise_alone, worst, name, len(known), fit.count, fit.evaluations)
