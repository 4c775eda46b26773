# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that cover part of the surface, in patches smaller than a pixel, and layers that hide what is below.

Light that meets such a stack meets one patch, which is an ordinary stack of just the layers that are there:
f = sum over the patches of share times f(stack of the patch). A clear layer of coverage c is there on c of what it may cover, and
takes its interface and its medium with it where it is not. An opaque layer is the base where it is there, under all
that lies above it, and what is below shows where it is not. So 0 and 1 are exact, and what is white stays white.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import MappingProxyType

from ..errors import LaminaError, Sentence
from .place import Place
from .schema import COVERAGE
from .stack import Layer, Stack

# The patches double with each clear layer that has a coverage; an opaque one adds as many as lie above it.
MAX_CLEAR, MAX_COVERED = 3, 8


@dataclass(frozen=True)
class Patch:
    """A part of the surface: the stack there, and which layers of the whole stack it has."""

    stack: Stack
    layers: tuple[int, ...]
    """Index in the whole stack of each layer of `stack`."""
    base: int | None
    """Index in the whole stack of the opaque layer that is the base of `stack`; None where that is the whole stack's."""
    covered: tuple[tuple[int, bool], ...]
    """The covered layers of the whole stack that decide about this patch, from the top, and whether each is there."""
    share: float
    """Of the surface."""

    def place(self, place: Place) -> Place | None:
        """A place of the whole stack in this patch; None where its element is not there."""
        if place.layer == self.base:
            return Place(None, place.name)
        return Place(self.layers.index(place.layer), place.name) if place.layer in self.layers else None

    def whole(self, place: Place) -> Place:
        """A place of this patch in the whole stack."""
        return Place(self.base if place.layer is None else self.layers[place.layer], place.name)


def covered_layers(stack: Stack) -> tuple[int, ...]:
    """Indices of the layers that have a coverage."""
    return tuple(i for i, layer in enumerate(stack.layers) if layer.has(COVERAGE))


def is_plain(stack: Stack) -> bool:
    """Whether a stack is its own one patch: no layer has a coverage or is opaque."""
    return not any(layer.has(COVERAGE) or layer.is_opaque for layer in stack.layers)


def patches(stack: Stack) -> tuple[Patch, ...]:
    """All patches of a stack, those with an upper layer before those without it, those of share 0 too; one where nothing is covered.

    Raises LaminaError for more covered layers than MAX_COVERED, or clear ones than MAX_CLEAR.
    """
    covered = covered_layers(stack)
    clear = [i for i in covered if not stack.layers[i].is_opaque]
    for found, most, what in ((clear, MAX_CLEAR, Sentence("clear layers")), (covered, MAX_COVERED, Sentence("layers"))):
        if len(found) > most:
            raise LaminaError(
                "{count} {what} have a coverage (layers {layers}); choose at most {most}",
                count=len(found),
                what=what,
                layers=", ".join(map(str, found)),
                most=most,
            )
    return tuple(_below(stack, 0, (), (), 1.0))


def _below(stack: Stack, index: int, kept: tuple[int, ...], covered: tuple[tuple[int, bool], ...], share: float) -> Iterator[Patch]:
    """The patches of what lies from layer `index` down, under the layers `kept`."""
    if index == len(stack.layers):
        yield _patch(stack, kept, None, covered, share)
        return
    layer = stack.layers[index]
    there, gone = covered, None
    if layer.has(COVERAGE):
        there, gone = (*covered, (index, True)), (*covered, (index, False))
    part = layer["coverage"] if layer.has(COVERAGE) else 1.0
    if layer.is_opaque:
        yield _patch(stack, kept, index, there, share * part)
    else:
        yield from _below(stack, index + 1, (*kept, index), there, share * part)
    if gone is not None:
        yield from _below(stack, index + 1, kept, gone, share * (1.0 - part))


def _patch(stack: Stack, kept: tuple[int, ...], base: int | None, covered: tuple[tuple[int, bool], ...], share: float) -> Patch:
    layers = tuple(_whole(stack.layers[i]) for i in kept)
    own = stack.base if base is None else stack.layers[base].as_base()
    return Patch(replace(stack, layers=layers, base=own), kept, base, covered, share)


def _whole(layer: Layer) -> Layer:
    values = {name: value for name, value in layer.values.items() if name != "coverage"}
    return replace(layer, values=MappingProxyType(values))
