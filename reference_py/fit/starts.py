# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the search begins: many guesses are looked at, few are followed."""

from collections.abc import Sequence

import numpy as np

from .forward import Forward
from .metric import rms
from .parameters import Parameters
from .prior import USUAL

_GUESSES, _SAME = 32, 0.06


def best_starts(forward: Forward, count: int, rng: np.random.Generator, known: Sequence[tuple[Parameters, np.ndarray, int]] = ()) -> list[np.ndarray]:
    """The `count` guesses (p,) of least error that are not alike, best first.

    `known`: parameters and coordinates of simpler fits, and the number of layers to put on top of them; what they know is
    taken over into half of the guesses.
    """
    parameters = forward.parameters
    diffuse = np.clip(np.pi * np.median(forward.metric.measurement.f, axis=0), 1e-3, 0.9)
    guesses = [_guess(parameters, diffuse, rng) for _ in range(_GUESSES // (2 if known else 1))]
    for old, x, above in known:
        guesses += [_taken_over(old, x, above, parameters, _guess(parameters, diffuse, rng)) for _ in range(_GUESSES // (2 * len(known)))]
    errors = [rms(value - forward.target) for value in forward.compressed_at(np.array(guesses))]
    chosen: list[np.ndarray] = []
    for i in np.argsort(errors):
        if all(are_apart(guesses[i], other) for other in chosen):
            chosen.append(guesses[i])
        if len(chosen) == count:
            break
    return chosen


def are_apart(x: np.ndarray, other: np.ndarray) -> bool:
    """Whether coordinates (p,) are different places to begin."""
    return bool(np.sqrt(np.mean(np.square(x - other))) > _SAME)


def _taken_over(old: Parameters, x: np.ndarray, above: int, new: Parameters, guess: np.ndarray) -> np.ndarray:
    """`guess` with the values of a simpler fit, whose layers lie below `above` new ones."""
    places = {(g.where, g.parameter.name): list(g.index) for g in new.groups}
    for g in old.groups:
        where = g.where if g.where == "the base" else f"layer {int(g.where.split()[1]) + above}"
        if (where, g.parameter.name) in places:
            guess[places[where, g.parameter.name]] = x[list(g.index)]
    return guess


def _guess(parameters: Parameters, diffuse: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    x = np.empty(parameters.size)
    for g in parameters.groups:
        low, high = USUAL[g.parameter.name]
        value = low + (high - low) * rng.random()
        x[list(g.index)] = g.coordinate(value * diffuse if g.parameter.name == "color" else value)
    return x
