# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that follow live values: one or two parameters, at whose knots the truth is fitted, each fit from its neighbour's, or the
color of a Lambert base, which needs no knots, or both."""

from collections.abc import Callable

import numpy as np

from ...material.place import Place
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack
from ..cache import truth_of
from ..live_grid import Axis, LiveLobes, grid_of
from ..view_table import BASE_COLOR, KNOTS, BaseColorTable, knot_cosines

MOST_AXES = 2
# Knots of a live roughness; below the first the widths go on, see `grid`. Two axes share out fewer.
_ROUGHNESSES = {1: (0.2, 0.3, 0.4, 0.5, 0.62, 0.76, 0.9, 1.0), 2: (0.15, 0.27, 0.42, 0.65, 1.0)}
# Knots of a live thickness, as optical depths of its mean color, and without end.
_DEPTHS = {1: (0.0, 0.15, 0.4, 0.8, 1.4, 2.2, 3.5, 6.0), 2: (0.0, 0.3, 0.8, 1.8, 5.0)}


def follows(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether a bake follows these live values."""
    rest = _without_color(stack, live)
    return not rest or axes_of(stack, rest) is not None


def _without_color(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """The live values that need knots: all but the color of a Lambert base."""
    return tuple(place for place in live if place != BASE_COLOR) if _is_lambert(stack) else live


def over_black(stack: Stack) -> Stack:
    """The stack over a black base."""
    return BASE_COLOR.with_value(stack, (0.0, 0.0, 0.0))


def base_of(truth, stack: Stack) -> BaseColorTable:
    """What a Lambert base of any color adds to layers whose truth is known: light that meets such a base has lost its direction."""
    layers = truth.layer_energies()
    back, escapes = layers.diffuse_below
    return BaseColorTable(np.zeros((KNOTS, 3)), layers.above(knot_cosines())[1] * escapes, back, np.array(stack.base["color"]))


def in_tables(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values that tables over the view alone follow, as stock nodes have them."""
    return (BASE_COLOR,) if BASE_COLOR in live and _is_lambert(stack) else ()


def _is_lambert(stack: Stack) -> bool:
    base = OpticalStack.of(stack).base
    return isinstance(base, DiffuseBase) and base.sigma_deg == 0.0


def axes_of(stack: Stack, live: tuple[Place, ...]) -> tuple[Axis, ...] | None:
    """The axes that follow these live values; None where a bake cannot: more than two, or others than these kinds."""
    if not 0 < len(live) <= MOST_AXES or any(place.name not in ("roughness", "thickness") for place in live):
        return None
    return tuple(Axis(place, _knots(stack, place, len(live))) for place in live)


def _knots(stack: Stack, place: Place, count: int) -> tuple[float, ...]:
    if place.name == "roughness":
        return _ROUGHNESSES[count]
    depths = np.array(_DEPTHS[count])
    mean = float(np.mean(OpticalStack.of(place.with_value(stack, 1.0)).interfaces[place.layer].tau))
    # a clear medium has no depth: any two knots will do
    return tuple(depths / mean) if mean > 0.0 else (0.0, 1.0)


def bake_live(stack: Stack, live: tuple[Place, ...], glossy: int, make_baker: Callable, report: Callable[[float], None]) -> LiveLobes:
    """The grid of a stack over live values of which at least one needs knots.

    `make_baker` is `Baker`; `report` gets the share done and may raise to cancel.
    """
    axes = axes_of(stack, _without_color(stack, live))
    assert axes is not None, "see follows"
    over_color = BASE_COLOR in live
    size = tuple(len(axis.knots) for axis in axes)
    center = tuple(n // 2 for n in size)
    order = sorted(np.ndindex(size), key=lambda node: sum(abs(a - b) for a, b in zip(node, center)))
    found, nodes, bases = {}, {}, {}
    for done, node in enumerate(order):
        here = over_black(stack) if over_color else stack
        for axis, i in zip(axes, node):
            here = axis.parameter.with_value(here, axis.knots[i])
        truth = truth_of(here)
        baker = make_baker(here, truth)
        if not found:
            found[node] = baker.path(glossy)
        else:
            near = min(found, key=lambda other: sum(abs(a - b) for a, b in zip(node, other)))
            found[node] = baker.continued(found[near])
        nodes[node] = baker.lobe_set(found[node], keep=True)
        if over_color:
            bases[node] = base_of(truth, stack)
        report((done + 1) / len(order))
    return grid_of(stack, axes, nodes, bases)
