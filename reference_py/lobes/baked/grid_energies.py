# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of a grid of lobes: known at all crossings of a few values of the axes, by cubic curves between, and told by sums and few modes."""

from collections.abc import Callable, Sequence
from functools import reduce

import numpy as np

from ...material.stack import Stack
from ..axes import Axis, Scale, has_waves
from ..live_grid import COEFFICIENT_DIGITS, DIGITS, FLOOR, LogEnergy
from ..view_table import KNOTS
from .black_and_white import light_of
from .knot_energies import shares, top_lobe
from .side_by_side import in_groups

# Modes together are off by no more than this in the root mean square over the grid, of a logarithm or, with waves, of an energy, and they are this many at most.
_CLOSE, _CLOSE_WAVES, _MOST_MODES = 0.002, 0.0004, 15
# Views beyond this knot are within ten degrees of the horizon, where energies are followed less closely.
_SEEN, _UNSEEN_WEIGHT = 9, 0.3
NAMES = ("mirrors", "fitted", "through", "back")


def energies_of(
    axes: tuple[Axis, ...], sampled: Sequence[Scale], at: Callable[[Sequence[float]], Stack], has_top: bool, over_color: bool
) -> tuple[dict[str, LogEnergy], np.ndarray | None]:
    """(energies by name as in `grid_of`, coefficients) of the stacks `at` all crossings of the knots of `sampled`, one scale for each axis.

    `has_top`: a lobe that is exact for the top has its own energy; `over_color`: the base is black, and what one of a color adds is asked too.
    """
    stacks = stacks_of(sampled, at)

    def of(truth, count: int) -> list[np.ndarray]:
        parts = [*shares(truth, top_lobe(truth.stack) if has_top else None), *(light_of(truth) if over_color else ())]
        return np.split(np.stack(parts), count, axis=-1)

    size = tuple(scale.count for scale in sampled)
    found = np.moveaxis(np.array(in_groups(stacks, of)).reshape(*size, -1, KNOTS, 3), len(size), 0)
    return told(axes, sampled, dict(zip(NAMES, found)))


def stacks_of(sampled: Sequence[Scale], at: Callable[[Sequence[float]], Stack]) -> list[Stack]:
    """Those at all crossings of the knots of scales, the last one's the nearest to each other."""
    return [at([float(scale.knots[i]) for scale, i in zip(sampled, node)]) for node in np.ndindex(*(scale.count for scale in sampled))]


def told(axes: tuple[Axis, ...], sampled: Sequence[Scale], energies: dict[str, np.ndarray]) -> tuple[dict[str, LogEnergy], np.ndarray | None]:
    """What `energies_of` gives, of energies (..., KNOTS, 3) by name at the crossings of the knots of `sampled`."""
    names, found = tuple(energies), np.array(list(energies.values()))
    is_log = not has_waves(axes)
    parts = [_apart(axes, sampled, np.log(values + FLOOR) if is_log else values) for values in found]
    if len(axes) == 1:
        return {name: LogEnergy(along, is_log=is_log) for name, (along, _) in zip(names, parts)}, None
    coefficients, modes = _modes(np.stack([left for _, left in parts], axis=len(axes)), _CLOSE if is_log else _CLOSE_WAVES)
    return {name: LogEnergy(along, own, is_log) for name, (along, _), own in zip(names, parts, modes)}, coefficients


def _apart(axes: tuple[Axis, ...], sampled: Sequence[Scale], values: np.ndarray) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """A table along each axis, (fine, KNOTS, 3), whose sum is nearest to values (..., KNOTS, 3), and what they leave at the cross knots."""
    numbers = range(len(axes))
    mean = values.mean(axis=tuple(numbers))
    along = [values.mean(axis=tuple(n for n in numbers if n != number)) - (mean if number else 0.0) for number in numbers]
    tables = tuple(_between(table, 0, scale, axis.fine).round(DIGITS) for table, scale, axis in zip(along, sampled, axes))
    left = reduce(lambda part, number: _between(part, number, sampled[number], axes[number].cross), numbers, values)
    for number, (table, axis) in enumerate(zip(tables, axes)):
        cell, way = axis.fine.place(axis.cross.knots)
        way = way[:, None, None]
        row = table[cell] * (1.0 - way) + table[cell + 1] * way
        left = left - row.reshape([-1 if n == number else 1 for n in numbers] + [KNOTS, 3])
    return tables, left


def _modes(left: np.ndarray, close: float) -> tuple[np.ndarray, np.ndarray]:
    """(coefficients (..., n), modes (energies, n, KNOTS, 3)) whose products are nearest to what energies leave, (..., energies, KNOTS, 3).

    n is a multiple of three, as shaders read colors.
    """
    size, seen = left.shape[:-3], np.where(np.arange(KNOTS) < _SEEN, _UNSEEN_WEIGHT, 1.0)[:, None]
    rows = (left * seen).reshape(int(np.prod(size)), -1)
    strength, vectors = np.linalg.eigh(rows.T @ rows)
    order = np.argsort(strength)[::-1]
    lost = np.sqrt(np.maximum(np.sum(strength) - np.cumsum(strength[order]), 0.0) / rows.size)
    wanted = int(np.argmax(lost <= close)) + 1 if np.any(lost <= close) else len(order)
    count = min(3 * -(-wanted // 3), _MOST_MODES)
    vectors = vectors[:, order[:count]]
    scale = np.max(np.abs(vectors), axis=0)
    modes = (vectors / scale).T.reshape(count, *left.shape[-3:]) / seen
    return (rows @ vectors * scale).reshape(*size, count).round(COEFFICIENT_DIGITS), np.moveaxis(modes, 1, 0).round(DIGITS)


def _between(values: np.ndarray, number: int, known: Scale, wanted: Scale) -> np.ndarray:
    """Values at the knots `wanted` of an axis, by cubic curves through those at the knots `known`."""
    curves = _cubic(known.count, known.way(wanted.knots) * (known.count - 1))
    return np.moveaxis(np.tensordot(curves, values, (1, number)), 0, number)


def _cubic(count: int, places: np.ndarray) -> np.ndarray:
    """What of each of `count` values, at least 4, a cubic spline has at places (n,), 0 at the first: (n, count). Its ends are those of the cubics next to them."""
    each = np.eye(count)
    bends = 4.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    right = 6.0 * (2.0 * -each + np.eye(count, k=1) + np.eye(count, k=-1))
    for end, step in ((0, 1), (count - 1, -1)):
        bends[end], right[end] = 0.0, 0.0
        bends[end, [end, end + step, end + 2 * step]] = 1.0, -2.0, 1.0
    bends = np.linalg.solve(bends, right)
    cell = np.minimum(places.astype(int), count - 2)
    b = (places - cell)[:, None]
    a = 1.0 - b
    return a * each[cell] + b * each[cell + 1] + ((a**3 - a) * bends[cell] + (b**3 - b) * bends[cell + 1]) / 6.0
