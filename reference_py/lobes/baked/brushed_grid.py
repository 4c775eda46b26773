# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of layers with brushed surfaces that follow live values: grids over these and over the azimuth of the view from the brushing.

Lobes are those of `analytic`, with the energies that `adding` gives the stack without brushing, times what walks say that brushing makes of them. This changes slowly
with live values too, so that walks at a few of them are fitted together.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from itertools import product

import numpy as np

from ...material.place import Place
from ...material.stack import Stack
from ...optics.frame import spherical
from ...optics.interface import Microfacets
from ..analytic.brushed import BrushedLobes
from ..axes import Axis, Scale
from ..brushing import directions, isotropic
from ..closure import unit_energy
from ..live_grid import LiveLobes
from ..lobe import DielectricCurve, GlossyLobe
from ..tabulate import tables_of
from ..view_table import BASE_COLOR, KNOTS, GlossyTable, TableLobes, knot_cosines, weight_at
from .black_and_white import light_of, over
from .brushed_bake import plain, ratios
from .grid_energies import NAMES, stacks_of, told
from .live import axes_of, computed_of, rotation_of, without_knots
from .make_grid import grid_of
from .side_by_side import in_groups

# Polynomials in the way along an axis: what brushing does has a most at a middle roughness, and bends where facets are as wide as can be. Those of several axes
# multiply to no higher degree.
_DEGREE = 6
# Of a roughness, values whose energies are computed, by how many axes there are: where brushed facets are as wide as can be along it they bend.
_COMPUTED = {2: 17, 3: 9}
# Rings of directions and places on each, of the energy that a top has: its error is below 1e-3.
_RULE = (64, 16)
# The base whose lobes share what comes from below over a black one: of that a Lambert lobe would have nothing.
_DARK = 0.02
# No energy is scaled by more, nor by less than the inverse.
_MOST = 4.0


def bake_brushed(stack: Stack, live: tuple[Place, ...], report: Callable[[float], None]) -> LiveLobes:
    """The grid of a stack of which `is_brushed` is true over live values that `follows` allows; `report` gets the share done and may raise to cancel."""
    axes = axes_of(stack, without_knots(stack, live))
    assert axes is not None, "see follows"
    over_color, (*given, turn) = BASE_COLOR in live, axes
    ground, dark = (over(stack, grey) if over_color else stack for grey in (0.0, _DARK))
    angle = directions(stack).pop()

    def at(coordinates: Sequence[float], ground: Stack = ground) -> Stack:
        return reduce(lambda here, part: part[0].at(here, part[1]), zip(given, coordinates), ground)

    nodes = {}
    knots = [axis.knots.knots[axis.before :] for axis in given]
    for node in np.ndindex(*map(len, knots)):
        tables = _one_mirror([plain(table) for table in tables_of(BrushedLobes(at([float(values[i]) for values, i in zip(knots, node)], dark)))])
        for number, psi in enumerate(np.arccos(turn.knots.knots)):
            nodes[(*node, number)] = TableLobes(tuple(_seen(table, angle, psi) for table in tables))
    sampled = [replace(axis.cross, count=_COMPUTED[len(axes)]) if _is_roughness(axis) else computed_of(axis, axes) for axis in axes]
    grid = grid_of(stack, axes, nodes, *_energies(axes, sampled, stacks_of(sampled[:-1], at), over_color, report))
    return replace(grid, rotation=rotation_of(stack) if rotation_of(stack) in live else None)


def _one_mirror(tables: list) -> list:
    """The tables without the mirrors after the first, which has the energy of all."""
    mirrors = [table for table in tables if isinstance(table, GlossyTable) and table.is_mirror]
    return [table for table in tables if not any(table is other for other in mirrors[1:])]


def _seen(table, angle: float, psi: float):
    """A table as views of an azimuth psi from the brushing have it, which is at `angle`."""
    table = replace(table, weight=weight_at(table.weight, knot_cosines(), angle + psi, table.axis), axis=None)
    return table if getattr(table, "frame", None) is None else replace(table, frame=-psi)


def _energies(axes: tuple[Axis, ...], sampled: list[Scale], stacks: list[Stack], over_color: bool, report: Callable[[float], None]):
    """What `grid_of` takes of energies, of brushed stacks at the knots of all `sampled` scales but the last, which is of the azimuth."""
    turned, size = sampled[-1].knots, tuple(scale.count for scale in sampled[:-1])
    views = spherical(np.arccos(knot_cosines()), 0.0)

    def of(truth, count: int) -> list[np.ndarray]:
        parts = [truth.albedo(views), truth.specular_albedo(knot_cosines()), *(light_of(truth) if over_color else ())]
        return np.split(np.stack(parts), count, axis=-1)

    level, mirrors, *light = np.moveaxis(np.array(in_groups([isotropic(stack) for stack in stacks], of)), 0, 1)
    terms = _terms(size)
    turns = np.clip(ratios(stacks, level, terms, turned, lambda share: report(0.2 + (0.3 if over_color else 0.7) * share)), 1.0 / _MOST, _MOST)
    total = level[:, None] * turns
    top = np.stack([[_top(stack, float(psi)) for psi in np.arccos(turned)] for stack in stacks])
    found = [np.broadcast_to(mirrors[:, None], total.shape), np.maximum(total - mirrors[:, None] - top, 0.0)]
    if over_color:
        through, back = light
        from_base = through / (1.0 - back)
        white = [over(stack, 1.0) for stack in stacks]
        over_white = (level + from_base)[:, None] * ratios(white, level + from_base, terms, turned, lambda share: report(0.5 + 0.4 * share))
        found += [np.maximum(over_white - total, 0.0) * (1.0 - back[:, None]), np.broadcast_to(back[:, None], total.shape)]
    return told(axes, sampled, {name: values.reshape(*size, len(turned), KNOTS, 3) for name, values in zip(NAMES, found)})


def _is_roughness(axis: Axis) -> bool:
    return any(place.name == "roughness" for place in axis.live)


def _terms(size: tuple[int, ...]) -> np.ndarray:
    """Polynomials at all crossings of even places on the ways along axes, (n, m)."""
    ways = [np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), _DEGREE) for count in size]
    chosen = [degrees for degrees in product(range(_DEGREE + 1), repeat=len(size)) if sum(degrees) <= _DEGREE]
    return np.array([[np.prod([way[i, d] for way, i, d in zip(ways, node, degrees)]) for degrees in chosen] for node in np.ndindex(*size)])


def _top(stack: Stack, psi: float) -> np.ndarray:
    """The energy (KNOTS, 1) of what a rough top reflects, for views of an azimuth from the brushing; a mirror and no layer have none here."""
    if not stack.layers:
        return np.zeros((KNOTS, 1))
    layer = stack.layers[0]
    facets = Microfacets.of(layer)
    if facets.is_specular:
        return np.zeros((KNOTS, 1))
    if facets.anisotropic is None:
        return _top_energy(facets.distribution, facets.alpha, facets.alpha, float(layer["ior"]), 0.0)
    return _top_energy(facets.distribution, facets.anisotropic.alpha_x, facets.anisotropic.alpha_y, float(layer["ior"]), psi)


@lru_cache(maxsize=256)
def _top_energy(distribution: str, alpha_x: float, alpha_y: float, ior: float, psi: float) -> np.ndarray:
    ones = np.ones(KNOTS)
    lobe = GlossyLobe(distribution, np.ones(3), alpha_x * ones, alpha_y * ones, fresnel=DielectricCurve(ior), frame=-psi)
    return unit_energy(lobe, knot_cosines(), rule=_RULE)[:, :1]
