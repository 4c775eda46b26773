# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks that differ in what each channel has alone, as one stack of as many channels: its truth takes little longer than that of one.

Indices and roughnesses are the same in all channels; depths, colors, films and what media scatter are not.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...material.place import places
from ...material.schema import CONDUCTOR, SCATTERING, THIN_FILM
from ...material.stack import Base, Layer, Stack
from ...optics.bases import conductor_index
from ...optics.scattering import albedo_of_color
from ..truth import truth_of

# Stacks of which truths are asked at once, which bounds memory; of films more, as their interfaces are told by few of them.
_AT_ONCE, _FILMS_AT_ONCE = 12, 36
_FILM = tuple(parameter.name for parameter in THIN_FILM.parameters)
_BASE_COLORS = ("color", "eta", "k", *_FILM)
_LAYER_COLORS = ("tint", "extinction", "scatter_albedo", *_FILM)


def in_groups(stacks: Sequence[Stack], of: Callable) -> list:
    """`of(truth, count)` gives a result for each of `count` stacks that a truth, of 3 channels for each, knows at once; all results in the order of the stacks."""
    results: list = [None] * len(stacks)
    for members, truth in groups(stacks):
        for i, result in zip(members, of(truth, len(members))):
            results[i] = result
    return results


def groups(stacks: Sequence[Stack]) -> Iterator[tuple[list[int], Any]]:
    """Numbers of stacks that differ in what each channel has alone, and a truth of 3 channels for each of these; first that of the first stack."""
    resolved = [_resolved(stack) for stack in stacks]
    alike: dict[tuple, list[int]] = {}
    for i, stack in enumerate(resolved):
        alike.setdefault(_shared(stack), []).append(i)
    for members in alike.values():
        at_once = _FILMS_AT_ONCE if any(_film(element) for _, element in places(resolved[members[0]])) else _AT_ONCE
        for start in range(0, len(members), at_once):
            some = members[start : start + at_once]
            yield some, truth_of(_joined([resolved[i] for i in some]))


def truth_of_all(stacks: Sequence[Stack]):
    """A truth of 3 channels for each of stacks that differ in what each channel has alone."""
    return truth_of(_joined([_resolved(stack) for stack in stacks]))


def _resolved(stack: Stack) -> Stack:
    """The stack with all that its channels have alone as values of channels."""
    return replace(stack, layers=tuple(map(_layer, stack.layers)), base=_base(stack.base))


def _layer(layer: Layer) -> Layer:
    thickness, values = layer["thickness"], dict(layer.values)
    values |= {"thickness": 1.0, "tint": tuple(np.asarray(layer["tint"], float) ** thickness)}
    if layer.has(SCATTERING):
        if "density" in layer:
            color = values.pop("scatter_color")
            values |= {"extinction": (values.pop("density"),) * len(color), "scatter_albedo": albedo_of_color(tuple(color), layer["scatter_g"])}
        values["extinction"] = tuple(thickness * np.asarray(values["extinction"], float))
    return replace(layer, values=values | _film(layer))


def _base(base: Base) -> Base:
    if base.kind != CONDUCTOR.name:
        return base
    eta, k = conductor_index(base)
    values = {name: value for name, value in base.values.items() if name not in ("metal", "reflectance", "edge_color")}
    return replace(base, values=values | {"eta": tuple(eta), "k": tuple(k)} | _film(base))


def _film(element: Layer | Base) -> dict:
    return {name: (element[name],) for name in _FILM if element.has(THIN_FILM)}


def _shared(stack: Stack) -> tuple:
    """Equal for stacks that may be joined."""
    layers = tuple((layer.kind, *((name, value) for name, value in sorted(layer.values.items()) if name not in _LAYER_COLORS)) for layer in stack.layers)
    base = tuple((name, value) for name, value in sorted(stack.base.values.items()) if name not in _BASE_COLORS)
    return layers, base


def _joined(stacks: Sequence[Stack]) -> Stack:
    first = stacks[0]

    def joined(elements, names):
        values = {name: tuple(np.concatenate([element[name] for element in elements])) for name in names if name in elements[0]}
        return replace(elements[0], values=elements[0].values | values)

    layers = tuple(joined(own, _LAYER_COLORS) for own in zip(*(stack.layers for stack in stacks)))
    return replace(first, layers=layers, base=joined([stack.base for stack in stacks], _BASE_COLORS))
