# SPDX-License-Identifier: GPL-3.0-or-later
"""A grid of lobe sets and of energies becomes a `LiveLobes`."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...errors import LaminaError
from ...material.stack import Stack
from ..axes import Axis, has_waves
from ..closure import unit_energy
from ..live_grid import DIGITS, MIN_ENERGY, LiveBase, LiveLobe, LiveLobes, LogEnergy, alpha_of, blended, unit_sizes
from ..view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes, knot_cosines


def grid_of(
    stack: Stack, axes: tuple[Axis, ...], nodes: dict[tuple[int, ...], TableLobes], energies: dict[str, LogEnergy], coefficients: np.ndarray | None
) -> LiveLobes:
    """A grid of the lobe sets at its nodes, which must have the same lobes, and of energies: "mirrors", "fitted", and over a base of a live color
    "through" and "back". Lobes with a frame are brushed; it is that of views of azimuth 0. Raises LaminaError when lobes differ.
    """
    size = tuple(axis.knots.count - axis.before for axis in axes)
    if len({len(lobe_set.tables) for lobe_set in nodes.values()}) != 1 or len(nodes) != np.prod(size):
        raise LaminaError("the lobe sets of a grid differ in their lobes")

    def gathered(number: int, part) -> np.ndarray:
        arrays = [part(nodes[index].tables[number]) for index in np.ndindex(size)]
        return np.stack(arrays).reshape(*size, KNOTS, -1)

    def before(values: np.ndarray, goes_on: int) -> np.ndarray:
        """With rows before the first of each axis: the first `goes_on` columns go on as they began, but no faster than to 0 where the axis has it; the rest stays."""
        for number, axis in enumerate(axes):
            first, second = (np.take(values, [i], number) for i in (0, 1))
            *lower, start, following = axis.knots.knots[: axis.before + 2]
            slope = (second - first) / (following - start) * (np.arange(values.shape[-1]) < goes_on)
            slope = np.minimum(slope, first / start) if lower and goes_on else slope
            values = np.concatenate([*(first + slope * (knot - start) for knot in lower), values], axis=number)
        return values.round(DIGITS)

    lobes = []
    for number, first in enumerate(nodes[(0,) * len(axes)].tables):
        if isinstance(first, DiffuseTable):
            lobes.append(LiveLobe(gathered(number, lambda table: table.weight), unit=np.ones((*unit_sizes(axes), KNOTS, 1))))
        elif not np.any(first.shape):
            lobes.append(LiveLobe(energies["mirrors"], first.distribution))
        else:
            shape = gathered(number, lambda table: np.concatenate([np.sqrt(table.shape[:, :2]), table.shape[:, 2:]], axis=1))
            shape = before(shape, 2)
            if first.fresnel is not None:
                lobes.append(LiveLobe(None, first.distribution, shape, first.fresnel, is_brushed=first.frame is not None))
                continue
            known: dict[tuple, np.ndarray] = {}
            unit = gathered(number, lambda table, known=known: _unit(table, known))
            units = _all_units(axes, lambda node, number=number: nodes[node].tables[number], shape, unit, known)
            energy = gathered(number, lambda table: table.weight) * unit
            lobes.append(LiveLobe(energy, first.distribution, shape, unit=units, is_brushed=first.frame is not None))
    fitted = [number for number, lobe in enumerate(lobes) if lobe.unit is not None]
    total = np.maximum(sum(lobes[number].energy for number in fitted), MIN_ENERGY)
    shares = [before(lobes[number].energy / total, 0) for number in fitted]
    # the last has what the others leave, as in shaders
    shares[-1:] = [np.maximum(1.0 - sum(shares[:-1], np.zeros_like(share)), 0.0).round(DIGITS) for share in shares[-1:]]
    for number, share in zip(fitted, shares):
        lobes[number] = replace(lobes[number], energy=share)
    base = LiveBase(energies["through"], energies["back"]) if "through" in energies else None
    return LiveLobes(stack, axes, tuple(lobes), energies["fitted"], coefficients, base)


def _all_units(axes: tuple[Axis, ...], table_at: Callable, shape: np.ndarray, fitted: np.ndarray, known_units: dict) -> np.ndarray:
    """The energies (..., KNOTS, 1) of a lobe of weight 1 at all knots of shapes (..., KNOTS, 3), of which those that were fitted are known, as is the table there.

    Beside an axis of waves, along which lobes keep their shapes, those at the fine knots of the other.
    """
    if has_waves(axes):
        return _fine_units(axes, table_at((0,) * len(axes)), shape, known_units)
    units = np.empty((*shape.shape[:-1], 1))
    for node in np.ndindex(*(axis.knots.count for axis in axes)):
        known = tuple(i - axis.before for i, axis in zip(node, axes))
        if min(known) >= 0:
            units[node] = fitted[known]
        else:
            units[node] = _unit(_shaped(table_at(tuple(max(i, 0) for i in known)), shape[node]), known_units)
    return units.round(DIGITS)


def _fine_units(axes: tuple[Axis, ...], table: GlossyTable, shape: np.ndarray, known_units: dict) -> np.ndarray:
    for number, axis in enumerate(axes):
        places = [(0, 0.0)] if axis.has_waves else list(zip(*axis.knots.place(axis.fine.knots)))
        rows = np.moveaxis(shape, number, 0)
        shape = np.stack([blended(rows, [place]) for place in places], axis=number)
    units = np.empty((*shape.shape[:-1], 1))
    for node in np.ndindex(shape.shape[:-2]):
        units[node] = _unit(_shaped(table, shape[node]), known_units)
    return units.round(DIGITS)


def _shaped(table: GlossyTable, shape: np.ndarray) -> GlossyTable:
    """The table with a shape (KNOTS, 3) of a `LiveLobe`."""
    return replace(table, shape=np.concatenate([alpha_of(shape[:, :2]), shape[:, 2:]], axis=1))


def _unit(table: GlossyTable, known: dict[tuple, np.ndarray]) -> np.ndarray:
    """Its energy (KNOTS, 1) at weight 1, which is `known` of shapes that others have too."""
    key = table.shape.tobytes(), table.frame
    if key not in known:
        known[key] = np.maximum(unit_energy(table.lobe(knot_cosines()), knot_cosines())[:, :1], 1e-3)
    return known[key]
