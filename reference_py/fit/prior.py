# SPDX-License-Identifier: GPL-3.0-or-later
"""What is expected of values before data are seen: guesses lie there, and what the data do not determine stays there.

A weak pull towards usual values makes curved valleys (a tint against what is below it, the two colors of a metal) round,
so that the search does not run along them into a bound. A metal under one layer (number 9 of `lamina chart fit`, no noise): the
error left fell from .01 to .002, and what the data determine came from 23 to 3 % of the truth.
"""

from collections.abc import Callable, Sequence

import numpy as np

from .parameters import Parameters
from .solve import Ask, Search, Solution, side_by_side

# In the schema's units; a diffuse color comes from the data, and nothing pulls at it.
USUAL = {
    "ior": (1.2, 2.0),
    "roughness": (0.1, 0.8),
    "tint": (0.4, 1.0),
    "reflectance": (0.3, 0.95),
    "edge_color": (0.3, 1.0),
    "sigma_deg": (5.0, 40.0),
    "color": (0.5, 1.8),
    "scatter_color": (0.3, 0.95),
    "density": (0.2, 3.0),
    "scatter_g": (-0.2, 0.7),
}
# Residual per unit of a coordinate, as far as what is fitted can be trusted: the stand-in errs by percents, the model by
# half a percent, and what is polished is hardly pulled.
ROUGH, FINE, POLISHED = 0.4, 0.1, 0.02


def pulled(
    parameters: Parameters,
    pull: float,
    answers: Callable[[list[Ask]], Sequence[np.ndarray]],
    searches: Sequence[Search],
) -> list[Solution]:
    """`side_by_side` with the distance from usual values, times `pull`, as further residuals; solutions are without them."""
    center, rows = _center(parameters), pull * np.diag([float(p) for p in _pulls(parameters)])

    def with_pull(asks: list[Ask]) -> list[np.ndarray]:
        plain = answers([ask if ask.r is None else Ask(ask.x, ask.r[: -len(rows)]) for ask in asks])
        return [np.concatenate([own, rows @ (ask.x - center) if ask.r is None else rows]) for ask, own in zip(asks, plain)]

    return [Solution(found.x, found.residual[: -len(rows)], found.steps) for found in side_by_side(with_pull, searches)]


def _center(parameters: Parameters) -> np.ndarray:
    """(p,) coordinates of the middle of what is usual."""
    x = np.empty(parameters.size)
    for g in parameters.groups:
        x[list(g.index)] = g.coordinate(0.5 * sum(USUAL[g.parameter.name]))
    return x


def _pulls(parameters: Parameters) -> list[bool]:
    return [g.parameter.name != "color" for g in parameters.groups for _ in g.index]
