# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that cover part of the surface, in patches smaller than a pixel.

Light that meets such a stack meets one patch, which is a stack of just the layers that are there:
f = sum over the subsets of the covered layers of prod(c or 1 - c) f(stack of the subset). So 0 and 1 are exact, and
what is white stays white. A layer that is not there takes its interface and its medium with it.
"""

from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType

from ..errors import LaminaError
from .place import Place
from .schema import COVERAGE
from .stack import Layer, Stack

MAX_COVERED = 3


@dataclass(frozen=True)
class Patch:
    """A part of the surface: the stack there, and which layers of the whole stack it has."""

    stack: Stack
    layers: tuple[int, ...]
    """Index in the whole stack of each layer of `stack`."""
    covered: tuple[tuple[int, bool], ...]
    """Every covered layer of the whole stack, and whether it is there."""
    share: float
    """Of the surface."""

    def place(self, place: Place) -> Place | None:
        """A place of the whole stack in this patch; None where its layer is not there."""
        if place.layer is None:
            return place
        return Place(self.layers.index(place.layer), place.name) if place.layer in self.layers else None


def covered_layers(stack: Stack) -> tuple[int, ...]:
    """Indices of the layers that have a coverage."""
    return tuple(i for i, layer in enumerate(stack.layers) if layer.has(COVERAGE))


def patches(stack: Stack) -> tuple[Patch, ...]:
    """All patches of a stack, the one with every layer first, those of share 0 too; one patch where nothing is covered.

    Raises LaminaError for more than MAX_COVERED covered layers, as the patches double with each.
    """
    covered = covered_layers(stack)
    if len(covered) > MAX_COVERED:
        raise LaminaError(f"{len(covered)} layers have a coverage (layers {', '.join(map(str, covered))}); choose at most {MAX_COVERED}")
    return tuple(_patch(stack, dict(zip(covered, there))) for there in product((True, False), repeat=len(covered)))


def _patch(stack: Stack, there: dict[int, bool]) -> Patch:
    kept = tuple(i for i in range(len(stack.layers)) if there.get(i, True))
    share = 1.0
    for i, is_there in there.items():
        share *= stack.layers[i]["coverage"] if is_there else 1.0 - stack.layers[i]["coverage"]
    layers = tuple(_whole(stack.layers[i]) for i in kept)
    return Patch(replace(stack, layers=layers), kept, tuple(there.items()), share)


def _whole(layer: Layer) -> Layer:
    values = {name: value for name, value in layer.values.items() if name != "coverage"}
    return replace(layer, values=MappingProxyType(values))
