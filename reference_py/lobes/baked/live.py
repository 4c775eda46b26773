# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that follow live values: one or two axes, at whose knots the truth is fitted, each fit from its neighbour's, or the
color of a diffuse base, which needs no knots, or both."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...material.place import Place
from ...material.schema import SCATTERING
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack
from ..analytic.brushed import has_brushing
from ..axes import (
    HALF_DEPTH,
    Axis,
    DepthAxis,
    EdgeAxis,
    FilmAxis,
    IndexAxis,
    NumberAxis,
    ReflectanceAxis,
    Scale,
    ScatterColorAxis,
    ThicknessAxis,
    of_reflectance,
)
from ..cache import stack_key
from ..live_grid import Energies, LiveLobes, grid_of
from ..truth import truth_of
from ..view_table import BASE_COLOR, DiffuseTable, GlossyTable
from .black_and_white import base_of, over
from .knot_energies import shares, top_lobe

MOST_AXES = 2
# Knots of shapes, by how many axes there are: a shader's text is limited. Energies have so many steps from one to the next, along one
# axis and of two.
_KNOTS = {1: 8, 2: 5}
_FINE, _CROSS = 3, 2
# The same of a metal's colors and of a medium that scatters: what its depth does depends on its color.
_FINER, _FINER_CROSS = 4, 3
# Shapes of lower roughness go on as they began; energies are known from there.
_ROUGHNESSES, _NARROWEST = (0.2, 1.0), 0.05
# At 1 the layer's surface is gone, and with a reflectance of 0 the metal.
_INDICES, _REFLECTANCES = (1.02, 4.0), (0.004, 0.999)
_DEEPEST, _DEEPEST_MEDIUM = 6.0, 30.0
# Of a film: in nm its thickness times its index, beyond which its colors are pale, a blue fringe being 225; and steps of its energies from one that is computed to the next.
_THICKEST_PATH, _FILM_KNOTS, _FILM_FINE = 1600.0, 33, 4


def follows(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether a bake follows these live values. Beside brushed surfaces none is followed."""
    if has_brushing(stack):
        return not live
    rest = _without_color(stack, live)
    return not rest or axes_of(stack, rest) is not None


def _without_color(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """The live values that need knots: all but the color of a diffuse base."""
    return tuple(place for place in live if place != BASE_COLOR) if _is_diffuse(stack) else live


def in_tables(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values that a bake follows, where it does not follow all: the color of a diffuse base alone."""
    if not live or follows(stack, live):
        return live
    return () if has_brushing(stack) else (BASE_COLOR,) if BASE_COLOR in live and _is_diffuse(stack) else ()


def _is_diffuse(stack: Stack) -> bool:
    return isinstance(OpticalStack.of(stack).base, DiffuseBase)


def axes_of(stack: Stack, live: tuple[Place, ...]) -> tuple[Axis, ...] | None:
    """The axes that follow these live values; None where a bake cannot: more than two, or others than these kinds."""
    groups: dict[tuple, tuple[Place, ...]] = {}
    for place in live:
        # a tint and a thickness are one optical depth
        key = (place.layer, "depth" if place.name in ("tint", "thickness") else place.name)
        groups[key] = (*groups.get(key, ()), place)
    # a density and a thickness would be one depth too, which no axis is
    if not 0 < len(groups) <= MOST_AXES or any(name == "density" and (layer, "depth") in groups for layer, name in groups):
        return None
    axes = [_axis(stack, places, len(groups)) for places in groups.values()]
    return None if None in axes else tuple(axes)


def _axis(stack: Stack, live: tuple[Place, ...], count: int) -> Axis | None:
    """The axis, one of so many, of live values of one place; None where there is none."""
    name = live[0].name
    if name == "scatter_color":
        return _even(ScatterColorAxis, live, (0.0, 1.0), count, _FINER, _FINER_CROSS)
    if name == "density" or (name in ("tint", "thickness") and live[0].element(stack).has(SCATTERING)):
        # a tint of a medium that scatters is no depth
        ends = (0.0, _DEEPEST_MEDIUM / (_DEEPEST_MEDIUM + 1.0))
        return _even(ThicknessAxis, live, ends, count, _FINER, _FINER_CROSS) if live[1:] == () and name != "tint" else None
    if name in ("tint", "thickness"):
        return _even(DepthAxis, live, (0.0, _DEEPEST / (_DEEPEST + HALF_DEPTH)), count)
    if name == "roughness":
        axis = _even(NumberAxis, live, _ROUGHNESSES, count)
        step = 1.0 / axis.knots.per_unit
        before = int(np.ceil(axis.knots.low / step))
        knots = Scale(axis.knots.low - before * step, axis.knots.high, axis.knots.count + before)
        fine, cross = (Scale(_NARROWEST, scale.high, scale.count + 2) for scale in (axis.fine, axis.cross))
        return NumberAxis(live, knots, fine, cross, before)
    if name == "sigma_deg":
        return _even(NumberAxis, live, (0.0, 90.0), count)
    if name == "reflectance":
        return _even(ReflectanceAxis, live, tuple(map(float, of_reflectance(np.array(_REFLECTANCES)))), count, _FINER, _FINER_CROSS)
    if name == "film_thickness":
        # a second axis would need as many bakes for each of its knots; the minima of a metal are the sharpest
        computed = 2 if live[0].layer is None else 1
        ends, steps = (0.0, _THICKEST_PATH / live[0].element(stack)["film_ior"]), _FILM_KNOTS - 1
        return FilmAxis(live, *(Scale(*ends, steps * finer + 1) for finer in (1, computed * _FILM_FINE, computed))) if count == 1 else None
    if name == "edge_color":
        return _even(EdgeAxis, live, (0.0, 1.0), count, _FINER, _FINER_CROSS)
    return _even(IndexAxis, live, tuple((n - 1.0) / (n + 1.0) for n in _INDICES), count) if name == "ior" else None


def _even(kind: type[Axis], live: tuple[Place, ...], ends: tuple[float, float], count: int, fine: float = _FINE, cross: float = _CROSS) -> Axis:
    steps = _KNOTS[count] - 1
    return kind(live, *(Scale(*ends, int(steps * finer) + 1) for finer in (1, fine, cross)))


def _apart(node: tuple[int, ...], other: tuple[int, ...]) -> int:
    return sum(abs(a - b) for a, b in zip(node, other))


def _better_from(start: tuple[int, ...], bakers: dict, found: dict, glossy: int) -> None:
    """Fits that a node begins by itself, and its neighbours go on from it, as far as these are closer than what was found.

    What a deep medium shows is not what shows through a thin one, and fits that begin at the one do not find the other.
    """
    own, plan, kind = bakers[start].path(glossy), found[start].plan, found[start].path.distributions
    if (own.plan, own.path.distributions) != (plan, kind) or own.path.mixtures.error.sum() >= found[start].path.mixtures.error.sum():
        return
    found[start], fresh, left = own, [start], set(found) - {start}
    while fresh:
        node = fresh.pop(0)
        for other in [other for other in sorted(left) if _apart(node, other) == 1]:
            left.remove(other)
            continued = bakers[other].continued(found[node])
            if continued.path.mixtures.error.sum() < found[other].path.mixtures.error.sum():
                found[other] = continued
                fresh.append(other)


def _between(known: list[Energies], stride: int) -> list[Energies]:
    """Energies at even knots and at `stride` - 1 between two of them, by cubic splines."""
    mirrors, fitted = (np.maximum(_spline(np.stack([getattr(point, name) for point in known]), stride), 0.0) for name in ("mirrors", "fitted"))
    tables = [point.base for point in known if point.base is not None]
    if not tables:
        return [Energies(*point) for point in zip(mirrors, fitted)]
    light = (np.maximum(_spline(np.stack([getattr(table, name) for table in tables]), stride), 0.0) for name in ("through", "back"))
    return [Energies(*point, replace(tables[0], through=through, back=back)) for *point, through, back in zip(mirrors, fitted, *light)]


def _spline(values: np.ndarray, stride: int) -> np.ndarray:
    """Natural cubic splines through values (n, ...) at even knots, at these and at `stride` - 1 between two of them."""
    count, rows = len(values), values.reshape(len(values), -1)
    bend = np.zeros_like(rows)
    equations = 4.0 * np.eye(count - 2) + np.eye(count - 2, k=1) + np.eye(count - 2, k=-1)
    bend[1:-1] = np.linalg.solve(equations, rows[:-2] - 2.0 * rows[1:-1] + rows[2:])
    t = np.arange(stride)[:, None] / stride
    cells = [(1.0 - t) * a + t * b + ((1.0 - t) ** 3 - (1.0 - t)) * c + (t**3 - t) * d for a, b, c, d in zip(rows, rows[1:], bend, bend[1:])]
    return np.concatenate([*cells, rows[-1:]]).reshape(-1, *values.shape[1:])


def bake_live(stack: Stack, live: tuple[Place, ...], glossy: int, make_baker: Callable, report: Callable[[float], None]) -> LiveLobes:
    """The grid of a stack over live values of which at least one needs knots.

    `make_baker` is `Baker`; `report` gets the share done and may raise to cancel.
    """
    axes = axes_of(stack, _without_color(stack, live))
    assert axes is not None, "see follows"
    over_color = BASE_COLOR in live
    ground = over(stack, 0.0) if over_color else stack
    knots = [axis.knots.knots[axis.before :] for axis in axes]
    size = tuple(map(len, knots))
    center = tuple(n // 2 for n in size)
    order = sorted(np.ndindex(size), key=lambda node: _apart(node, center))
    found, bakers, truths = {}, {}, {}

    for done, node in enumerate(order):
        here = ground
        for axis, at, i in zip(axes, knots, node):
            here = axis.at(here, at[i])
        truth = truths[stack_key(here)] = truth_of(here)
        bakers[node] = make_baker(here, truth)
        if not found:
            found[node] = bakers[node].path(glossy)
        else:
            near = min(found, key=lambda other: _apart(node, other))
            found[node] = bakers[node].continued(found[near])
        report(0.7 * (done + 1) / len(order))
    for axis, last in zip(axes, size):
        if isinstance(axis, ThicknessAxis):
            _better_from(tuple(n - 1 if other is axis else n // 2 for other, n in zip(axes, size)), bakers, found, glossy)
    nodes = {node: baker.lobe_set(found[node], keep=(GlossyTable, DiffuseTable)) for node, baker in bakers.items()}
    report(0.8)

    def energies(here: Stack) -> Energies:
        # shapes and energies have knots in common; more truths would take too much memory
        truth = truths.get(stack_key(here)) or truth_of(here)
        return Energies(*shares(truth, top_lobe(here) if found[center].plan else None), base_of(truth, here, stack) if over_color else None)

    along = []
    for axis in axes:
        here = ground
        for other, at, i in zip(axes, knots, center):
            here = here if other is axis else other.at(here, at[i])
        points = [energies(axis.at(here, knot)) for knot in (axis.cross if axis.has_waves else axis.fine).knots]
        along.append(_between(points, _FILM_FINE) if axis.has_waves else points)
    report(0.85)
    cross = {}
    if len(axes) == 2:
        first, second = axes
        cross = {(i, j): energies(second.at(first.at(ground, a), b)) for i, a in enumerate(first.cross.knots) for j, b in enumerate(second.cross.knots)}
    return grid_of(stack, axes, nodes, along, cross)
