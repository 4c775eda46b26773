# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that follow live values: one or two axes, at whose knots the truth is fitted, each fit from its neighbour's, or the
color of a diffuse base, which needs no knots, or both."""

from collections.abc import Callable

import numpy as np

from ...material.place import Place
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack
from ..axes import REFLECTANCE_OFFSET, Axis, DepthAxis, MetalAxis, NumberAxis
from ..cache import truth_of
from ..live_grid import MIN_ENERGY, Energies, LiveLobes, grid_of
from ..samples import view_of
from ..view_table import BASE_COLOR, KNOTS, BaseColorTable, knot_cosines
from .energy import shares, top_lobe

MOST_AXES = 2
# Steps of energies' knots between two others, along one axis and of two.
_FINE, _CROSS = 3, 2
# Energies of a roughness are also known below the first of its knots.
_NARROW = (0.05, 0.1)
# Beside white, the color at which a rough diffuse base is right.
_SOME_COLOR = 0.3
# Knots by how many axes there are: two share out fewer, as a shader's text is limited. Of a roughness, below whose first the widths go on.
_ROUGHNESSES = {1: (0.2, 0.3, 0.4, 0.5, 0.62, 0.76, 0.9, 1.0), 2: (0.15, 0.27, 0.42, 0.65, 1.0)}
_DEPTHS = {1: (0.0, 0.15, 0.4, 0.8, 1.4, 2.2, 3.5, 6.0), 2: (0.0, 0.3, 0.8, 1.8, 5.0)}
# Of the top layer's index: at 1 the layer's surface is gone.
_INDICES = {1: (1.02, 1.1, 1.22, 1.36, 1.5, 1.7, 2.0, 2.5, 4.0), 2: (1.02, 1.25, 1.5, 1.9, 3.0)}
_SLOPES = {1: (0.0, 8.0, 16.0, 25.0, 36.0, 50.0, 70.0, 90.0), 2: (0.0, 15.0, 30.0, 50.0, 90.0)}
_REFLECTANCES = {1: (0.004, 0.03, 0.09, 0.2, 0.36, 0.55, 0.74, 0.9, 1.0), 2: (0.004, 0.08, 0.3, 0.65, 1.0)}
# Near 1 a metal's index is small, and reflections change fast.
_EDGES = {1: (0.0, 0.3, 0.55, 0.75, 0.88, 0.95, 0.985, 1.0), 2: (0.0, 0.45, 0.75, 0.93, 1.0)}


def follows(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether a bake follows these live values."""
    rest = _without_color(stack, live)
    return not rest or axes_of(stack, rest) is not None


def _without_color(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """The live values that need knots: all but the color of a diffuse base."""
    return tuple(place for place in live if place != BASE_COLOR) if _is_diffuse(stack) else live


def over_black(stack: Stack) -> Stack:
    """The stack over a black base."""
    return BASE_COLOR.with_value(stack, (0.0, 0.0, 0.0))


def base_of(truth, here: Stack, stack: Stack) -> BaseColorTable:
    """What a diffuse base of any color adds to the layers of `here`, whose base is black and whose truth is known; the color is that of `stack`.

    Light that meets a Lambert base has lost its direction: three numbers per view say all. A rough one keeps some, and they are
    those that are right at two colors.
    """
    layers = truth.layer_energies()
    back, escapes = layers.diffuse_below
    own, color = np.zeros((KNOTS, 3)), np.array(stack.base["color"])
    if OpticalStack.of(here).base.sigma_deg == 0.0:
        return BaseColorTable(own, layers.above(knot_cosines())[1] * escapes, np.broadcast_to(back, (KNOTS, 3)), color)
    views = np.stack([view_of(c) for c in knot_cosines()])
    some, all_ = (truth_of(BASE_COLOR.with_value(here, (c,) * 3)).albedo(views) - truth.albedo(views) for c in (_SOME_COLOR, 1.0))
    # of through c / (1 - back c)
    ratio = all_ * _SOME_COLOR / np.maximum(some, MIN_ENERGY)
    back = np.clip((ratio - 1.0) / (ratio - _SOME_COLOR), 0.0, 0.999)
    return BaseColorTable(own, all_ * (1.0 - back), back, color)


def in_tables(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values that tables over the view alone follow, as stock nodes have them."""
    return (BASE_COLOR,) if BASE_COLOR in live and _is_diffuse(stack) else ()


def _is_diffuse(stack: Stack) -> bool:
    return isinstance(OpticalStack.of(stack).base, DiffuseBase)


def axes_of(stack: Stack, live: tuple[Place, ...]) -> tuple[Axis, ...] | None:
    """The axes that follow these live values; None where a bake cannot: more than two, or others than these kinds."""
    makers: dict[tuple, tuple] = {}
    for place in live:
        kind, knots = _kind_of(place)
        if kind is None:
            return None
        # a tint and a thickness are one optical depth
        key = (place.layer, kind) if kind is DepthAxis else place
        makers[key] = (kind, (*(makers[key][1] if key in makers else ()), place), knots)
    if not 0 < len(makers) <= MOST_AXES:
        return None
    return tuple(_axis(kind, places, tuple(knots[len(makers)])) for kind, places, knots in makers.values())


def _axis(kind: type[Axis], live: tuple[Place, ...], knots: tuple[float, ...]) -> Axis:
    before = _NARROW if live[0].name == "roughness" else ()
    return kind(live, knots, (*before, *_split(knots, _FINE)), (*before[:1], *_split(knots, _CROSS)))


def _split(knots: tuple[float, ...], steps: int) -> tuple[float, ...]:
    """The knots with so many steps from one to the next."""
    places = np.arange((len(knots) - 1) * steps + 1) / steps
    return tuple(float(value) for value in np.interp(places, np.arange(len(knots)), knots))


def _kind_of(place: Place) -> tuple[type[Axis] | None, dict]:
    """The class of the axis that follows a live value, and its knots by how many axes there are."""
    name = place.name
    if name in ("tint", "thickness"):
        return DepthAxis, _DEPTHS
    if name == "reflectance":
        return MetalAxis, {count: np.log(np.array(knots) + REFLECTANCE_OFFSET).tolist() for count, knots in _REFLECTANCES.items()}
    if name == "edge_color":
        return MetalAxis, _EDGES
    if name == "roughness":
        return NumberAxis, _ROUGHNESSES
    if name == "sigma_deg":
        return NumberAxis, _SLOPES
    # what lies above a layer changes what its index does
    return (NumberAxis, _INDICES) if place == Place(0, "ior") else (None, {})


def bake_live(stack: Stack, live: tuple[Place, ...], glossy: int, make_baker: Callable, report: Callable[[float], None]) -> LiveLobes:
    """The grid of a stack over live values of which at least one needs knots.

    `make_baker` is `Baker`; `report` gets the share done and may raise to cancel.
    """
    axes = axes_of(stack, _without_color(stack, live))
    assert axes is not None, "see follows"
    over_color = BASE_COLOR in live
    ground = over_black(stack) if over_color else stack
    size = tuple(len(axis.knots) for axis in axes)
    center = tuple(n // 2 for n in size)
    order = sorted(np.ndindex(size), key=lambda node: sum(abs(a - b) for a, b in zip(node, center)))
    found, nodes = {}, {}
    for done, node in enumerate(order):
        here = ground
        for axis, i in zip(axes, node):
            here = axis.with_knot(here, axis.knots[i])
        truth = truth_of(here)
        baker = make_baker(here, truth)
        if not found:
            found[node] = baker.path(glossy)
        else:
            near = min(found, key=lambda other: sum(abs(a - b) for a, b in zip(node, other)))
            found[node] = baker.continued(found[near])
        nodes[node] = baker.lobe_set(found[node], keep=True)
        report(0.8 * (done + 1) / len(order))

    def energies(here: Stack) -> Energies:
        truth = truth_of(here)
        return Energies(*shares(truth, top_lobe(here) if found[center].plan else None), base_of(truth, here, stack) if over_color else None)

    along = []
    for axis in axes:
        here = ground
        for other, i in zip(axes, center):
            here = here if other is axis else other.with_knot(here, other.knots[i])
        along.append([energies(axis.with_knot(here, knot)) for knot in axis.fine])
    report(0.85)
    cross = {}
    if len(axes) == 2:
        first, second = axes
        cross = {
            (i, j): energies(second.with_knot(first.with_knot(ground, a), b)) for i, a in enumerate(first.cross) for j, b in enumerate(second.cross)
        }
    return grid_of(stack, axes, nodes, along, cross)
