# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that follow live values: up to three axes, at whose knots the truth is fitted, each fit from its neighbour's, or the
color of a diffuse base, which needs no knots, or both."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import reduce

import numpy as np

from ...material.place import Place, places
from ...material.schema import ANISOTROPY, DIELECTRIC, SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack
from ..axes import (
    HALF_DEPTH,
    Axis,
    AzimuthAxis,
    CoatedReflectanceAxis,
    DepthAxis,
    EdgeAxis,
    FilmAxis,
    IndexAxis,
    NumberAxis,
    ReflectanceAxis,
    Scale,
    ScatterColorAxis,
    ThicknessAxis,
    has_waves,
    of_reflectance,
)
from ..brushing import has_brushing
from ..live_grid import LiveLobes
from ..truth import truth_of
from ..view_table import BASE_COLOR, DiffuseTable, GlossyTable, TableLobes
from .bake import Baker, samples_of
from .base_ramp import with_ramp
from .black_and_white import over
from .brushed_bake import is_brushed
from .grid_energies import energies_of, told
from .lobe_order import in_one_order
from .make_grid import grid_of
from .side_by_side import groups, truth_of_all

MOST_AXES, _MOST_WITH_WAVES = 3, 2
# By how many axes there are: knots of shapes, as a shader's text is limited; and knots of energies, on the way between those that are computed, along one axis and of all together.
_KNOTS, _KNOTS_OF_ROUGHNESS = {1: 8, 2: 5, 3: 4}, {1: 8, 2: 5, 3: 5}
# Of a roughness beside other live values how many knots, the first of those that are fitted, and their bend, where shapes change fastest when it is low: of a base
# under layers, and of a surface with a film, of whose own light nothing is known. Below another narrow top there is too little else to fit.
_UNDER_LAYERS, _FILMED = (6, 0.1, 0.7), (6, 0.06, 1.0)
# Bends of scales of few knots: bright metals and indices near 1 change shapes fastest.
_BENDS_OF_FEW = {"reflectance": 1.8, "ior": 0.5}
# Of brushed surfaces, whose lobes need no fits and get flat towards grazing in their own way at each azimuth.
_KNOTS_OF_BRUSHED = {2: 13, 3: 8}
_FINE, _CROSS = 33, {1: 2, 2: 25, 3: 13}
# Values of an axis whose energies are computed, by how many axes there are; of what channels have alone, which takes less time, where such axes are several; and of a rough base's slopes, which do little.
_COMPUTED, _COMPUTED_FAST, _COMPUTED_SLOPES = {1: 13, 2: 9, 3: 7}, {1: 17, 2: 17, 3: 9}, {1: 13, 2: 7, 3: 5}
_FAST = (DepthAxis, ReflectanceAxis, ScatterColorAxis, ThicknessAxis)
# Of the reflectance of a metal under layers beside two values that take long: six more would take nearly a third longer, and lower the worst error by a twentieth.
_COMPUTED_REFLECTANCE = 11
# Shapes of lower roughness go on as they began; energies are known from there.
_ROUGHNESSES, _NARROWEST = (0.2, 1.0), 0.05
# At 1 the layer's surface is gone, and with a reflectance of 0 the metal.
_INDICES, _REFLECTANCES = (1.02, 4.0), (0.004, 0.999)
_DEEPEST, _DEEPEST_MEDIUM = 6.0, 30.0
# Of a film: in nm its thickness times its index, beyond which its colors are pale, a blue fringe being 225; and steps of its energies, and of how these depend on another value, from one that is computed to the next.
_THICKEST_PATH, _FILM_KNOTS, _FILM_FINE, _FILM_CROSS = 1600.0, 33, 4, 2
_MOST_FILM_INDEX = DIELECTRIC.parameter("film_ior").maximum
# Knots of how energies depend on a film and on another value, of numbers and of colors.
_CROSS_BESIDE_FILM = {False: 9, True: 13}
# The bend of a scale of energies (`Scale`) that change fastest where surfaces are narrow, tints thin, metals dark and indices near 1.
_BEND = 0.7
# Of the azimuth from a brushing: energies turn where a view is nearly across it. That of walks is known everywhere.
_AZIMUTH = AzimuthAxis((), *(Scale(0.0, 1.0, count, _BEND) for count in (6, 17, 9)))


def follows(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether a bake follows these live values."""
    if has_brushing(stack) and not is_brushed(stack):
        return not live
    rest = without_knots(stack, live)
    return not rest or axes_of(stack, rest) is not None


def without_knots(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """The live values that need knots: all but the color of a diffuse base and where a brushing turns."""
    free = {rotation_of(stack)} | ({BASE_COLOR} if _is_diffuse(stack) else set())
    return tuple(place for place in live if place not in free)


def rotation_of(stack: Stack) -> Place | None:
    """The rotation of a stack's brushing, which all that is made about it turns with; None where there is none, or two that would come apart."""
    found = [Place(i, "rotation") for i, element in places(stack) if element.has(ANISOTROPY)]
    return found[0] if len(found) == 1 and is_brushed(stack) else None


def in_tables(stack: Stack, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values that a bake follows, where it does not follow all: the color of a diffuse base alone."""
    if not live or follows(stack, live):
        return live
    return (BASE_COLOR,) if BASE_COLOR in live and follows(stack, (BASE_COLOR,)) else ()


def _is_diffuse(stack: Stack) -> bool:
    return isinstance(OpticalStack.of(stack).base, DiffuseBase)


def axes_of(stack: Stack, live: tuple[Place, ...]) -> tuple[Axis, ...] | None:
    """The axes that follow these live values; None where a bake cannot: more than MOST_AXES, or others than these kinds. Brushing takes one, the last."""
    groups: dict[tuple, tuple[Place, ...]] = {}
    for place in live:
        # a tint and a thickness are one optical depth
        key = (place.layer, "depth" if place.name in ("tint", "thickness") else place.name)
        groups[key] = (*groups.get(key, ()), place)
    # a density and a thickness would be one depth too, which no axis is
    count = len(groups) + has_brushing(stack)
    if not 0 < count <= MOST_AXES or any(name == "density" and (layer, "depth") in groups for layer, name in groups):
        return None
    axes = [_axis(stack, together, count) for together in groups.values()] + [_AZIMUTH] * has_brushing(stack)
    if None in axes:
        return None
    if not has_waves(axes):
        return tuple(axes)
    # of two axes of waves each would need as many knots
    return tuple(map(_beside_film, axes)) if count <= _MOST_WITH_WAVES and sum(axis.has_waves for axis in axes) == 1 else None


def _axis(stack: Stack, live: tuple[Place, ...], count: int) -> Axis | None:
    """The axis, one of so many, of live values of one place; None where there is none."""
    name = live[0].name
    if name == "scatter_color":
        return _axis_between(ScatterColorAxis, live, (0.0, 1.0), count)
    if name == "density" or (name in ("tint", "thickness") and live[0].element(stack).has(SCATTERING)):
        # a tint of a medium that scatters is no depth
        ends = (0.0, _DEEPEST_MEDIUM / (_DEEPEST_MEDIUM + 1.0))
        return _axis_between(ThicknessAxis, live, ends, count) if live[1:] == () and name != "tint" else None
    if name in ("tint", "thickness"):
        return _axis_between(DepthAxis, live, (0.0, _DEEPEST / (_DEEPEST + HALF_DEPTH)), count, _BEND)
    if name == "roughness":
        axis = _axis_between(NumberAxis, live, _ROUGHNESSES, count, _BEND)
        fine, cross = (replace(scale, low=_NARROWEST) for scale in (axis.fine, axis.cross))
        knots, before = _roughnesses(stack, live[0], count)
        return NumberAxis(live, knots, fine, cross, before)
    if name == "anisotropy" and live[0].element(stack).has(ANISOTROPY):
        axis = _axis_between(NumberAxis, live, (0.0, 1.0), count)
        return replace(axis, knots=replace(axis.knots, count=_KNOTS_OF_BRUSHED[count]))
    if name == "sigma_deg":
        return _axis_between(NumberAxis, live, (0.0, 90.0), count)
    if name == "reflectance":
        kind = CoatedReflectanceAxis if stack.layers else ReflectanceAxis
        return _axis_between(kind, live, tuple(map(float, of_reflectance(np.array(_REFLECTANCES)))), count, _BEND)
    if name in ("film_thickness", "film_ior"):
        film = live[0].element(stack)
        thickest = 0.0, _THICKEST_PATH / film["film_ior"]
        ends = thickest if name == "film_thickness" else (1.0, min(1.0 + _THICKEST_PATH / max(film["film_thickness"], 1.0), _MOST_FILM_INDEX))
        fine, cross = ((_film_knots(live[0]) - 1) * steps + 1 for steps in (_FILM_FINE, _FILM_CROSS))
        return FilmAxis(live, Scale(*ends, _FILM_KNOTS), Scale(*ends, fine), Scale(*ends, cross))
    if name == "edge_color":
        return _axis_between(EdgeAxis, live, (0.0, 1.0), count)
    return _axis_between(IndexAxis, live, tuple((n - 1.0) / (n + 1.0) for n in _INDICES), count, _BEND) if name == "ior" else None


def _roughnesses(stack: Stack, live: Place, count: int) -> tuple[Scale, int]:
    """Knots of shapes of a roughness, one axis of so many, and how many of them are not fitted: they reach down to the narrowest."""
    (low, high), bend = _ROUGHNESSES, 1.0
    fitted = (_KNOTS_OF_BRUSHED if has_brushing(stack) else _KNOTS_OF_ROUGHNESS)[count]
    if count > 1 and not has_brushing(stack):
        if live.layer is None and stack.layers:
            fitted, low, bend = _UNDER_LAYERS
        elif live.element(stack).has(THIN_FILM):
            fitted, low, bend = _FILMED
    before, first = 0, low
    while first > _NARROWEST:
        before += 1
        way = (before / (fitted + before - 1)) ** (1.0 / bend)
        first = (low - way * high) / (1.0 - way)
    return Scale(first, high, fitted + before, bend), before


def _axis_between(kind: type[Axis], live: tuple[Place, ...], ends: tuple[float, float], count: int, bend: float = 1.0) -> Axis:
    few = _BENDS_OF_FEW.get(live[0].name, 1.0) if count == MOST_AXES else 1.0
    return kind(live, Scale(*ends, _KNOTS[count], few), Scale(*ends, _FINE, bend), Scale(*ends, _CROSS[count], bend))


def _beside_film(axis: Axis) -> Axis:
    return axis if axis.has_waves else replace(axis, cross=replace(axis.cross, count=_CROSS_BESIDE_FILM[axis.is_color]))


def _film_knots(live: Place) -> int:
    """Of a film's thickness, how many energies are computed: the minima of a metal are the sharpest."""
    return (_FILM_KNOTS - 1) * (2 if live.layer is None else 1) + 1


def computed_of(axis: Axis, axes: tuple[Axis, ...]) -> Scale:
    """The values of one of the axes whose energies are computed."""
    count = len(axes)
    if isinstance(axis, AzimuthAxis):
        return axis.cross
    if isinstance(axis, FilmAxis):
        return replace(axis.cross, count=_film_knots(axis.live[0]))
    if axis.live[0].name == "sigma_deg":
        return replace(axis.cross, count=_COMPUTED_SLOPES[count])
    if not isinstance(axis, _FAST):
        return replace(axis.cross, count=_COMPUTED[count])
    is_one = sum(isinstance(other, _FAST) for other in axes) == 1
    if is_one and count == MOST_AXES and isinstance(axis, CoatedReflectanceAxis):
        return replace(axis.cross, count=_COMPUTED_REFLECTANCE)
    return replace(axis.cross, count=_COMPUTED_FAST[1 if is_one else count])


def _apart(node: tuple[int, ...], other: tuple[int, ...]) -> int:
    return sum(abs(a - b) for a, b in zip(node, other))


def _apart_by_channels(axes: tuple[Axis, ...], node: tuple[int, ...], shared: TableLobes) -> list[tuple[tuple[int, ...], TableLobes]]:
    """The nodes along an axis of waves, whose lobes have three channels each of those that share their shapes."""
    count = next(axis.knots.count for axis in axes if axis.has_waves)
    parts = [[replace(table, weight=weight) for weight in np.split(table.weight, count, axis=1)] for table in shared.tables]
    return [
        (tuple(number if axis.has_waves else i for axis, i in zip(axes, node)), TableLobes(tables)) for number, tables in enumerate(zip(*parts, strict=True))
    ]


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


def bake_live(stack: Stack, live: tuple[Place, ...], glossy: int, report: Callable[[float], None], albedos: np.ndarray | None = None) -> LiveLobes:
    """The grid of a stack over live values of which at least one needs knots.

    `report` gets the share done and may raise to cancel. `albedos` (..., KNOTS, 3) are those at all crossings of the values that `computed_of`
    names, where they are known of a bare surface without a mirror.
    """
    axes = axes_of(stack, without_knots(stack, live))
    assert axes is not None, "see follows"
    over_color = BASE_COLOR in live
    ground = over(stack, 0.0) if over_color else stack
    # along waves lobes share their shapes, which are fitted to the truth at all knots there
    waves = next((axis.knots.knots for axis in axes if axis.has_waves), None)
    knots = [np.median(waves, keepdims=True) if axis.has_waves else axis.knots.knots[axis.before :] for axis in axes]
    size = tuple(map(len, knots))
    center = tuple(n // 2 for n in size)
    order = sorted(np.ndindex(size), key=lambda node: _apart(node, center))
    found, bakers, nodes = {}, {}, {}
    has_media = any(isinstance(axis, ThicknessAxis) for axis in axes)

    def at(coordinates: Sequence[float]) -> Stack:
        return reduce(lambda here, part: part[0].at(here, part[1]), zip(axes, coordinates), ground)

    def tables(baker, node: tuple[int, ...]):
        return baker.lobe_set(found[node], keep=(GlossyTable, DiffuseTable))

    def coordinates(node: tuple[int, ...]) -> list[float]:
        return [float(values[i]) for values, i in zip(knots, node)]

    def bakers_in_order() -> Iterator[tuple[tuple[int, ...], Baker]]:
        """Nodes that differ in what each channel has alone one after the other, as they are asked at once."""
        if waves is None:
            stacks = [at(coordinates(node)) for node in order]
            for members, truth in groups(stacks):
                samples = samples_of(stacks[members[0]], truth)
                for i, f in zip(members, np.split(samples.f, len(members), axis=-1)):
                    yield order[i], Baker(stacks[i], truth_of(stacks[i]), samples=replace(samples, f=f))
            return
        for node in order:
            along = [at([wave if axis.has_waves else value for axis, value in zip(axes, coordinates(node))]) for wave in waves.tolist()]
            here, truth = at(coordinates(node)), truth_of_all(along)
            yield node, Baker(here, truth, samples=samples_of(here, truth))

    def wider(node: tuple[int, ...], near: tuple[int, ...]) -> tuple[float, ...]:
        """How many times as wide lobes begin as at a node nearby: where a surface is alone all get wider as it does. Along waves both are tried,
        as which lobe is which is not to change there.
        """
        ratio = float(np.prod([(a / b) ** 2 for a, b, axis in zip(coordinates(node), coordinates(near), axes) if axis.live[0].name == "roughness"]))
        if waves is not None and ratio != 1.0:
            return (1.0, ratio)
        return (1.0,) if stack.layers else (ratio,)

    for done, (node, baker) in enumerate(bakers_in_order()):
        if not found:
            found[node] = baker.path(glossy)
        else:
            near = min(found, key=lambda other: (_apart(node, other), order.index(other)))
            found[node] = baker.continued(found[near], wider(node, near))
        if has_media:
            bakers[node] = baker
        else:  # whose truth takes memory
            nodes[node] = tables(baker, node)
        report(0.7 * (done + 1) / len(order))
    for axis, last in zip(axes, size):
        if isinstance(axis, ThicknessAxis):
            _better_from(tuple(n - 1 if other is axis else n // 2 for other, n in zip(axes, size)), bakers, found, glossy)
    nodes |= {node: tables(baker, node) for node, baker in bakers.items()}
    if waves is not None:
        nodes = {own: part for node, shared in nodes.items() for own, part in _apart_by_channels(axes, node, shared)}
    nodes = in_one_order(nodes)
    report(0.8)
    computed = [computed_of(axis, axes) for axis in axes]
    if albedos is None:
        energies = energies_of(axes, computed, at, bool(found[center].plan), over_color)
    else:
        energies = told(axes, computed, {"mirrors": np.zeros_like(albedos), "fitted": albedos})
    lobes = grid_of(stack, axes, nodes, *energies)
    return with_ramp(lobes) if over_color else lobes
