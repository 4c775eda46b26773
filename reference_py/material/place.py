# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a value or a feature of a stack is."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from ..errors import Sentence, joined
from .schema import SCHEMA
from .stack import Base, Layer, Stack


@dataclass(frozen=True)
class Place:
    """A parameter or feature, by name, of a layer, counted from the top, or of the base, where `layer` is None."""

    layer: int | None
    name: str

    @property
    def where(self) -> str:
        """In words: "layer 0", "the base"."""
        return Sentence("the base") if self.layer is None else Sentence("layer {number}", number=self.layer)

    def __str__(self) -> str:
        return f"the {self.name.replace('_', ' ')} of {self.where}"

    def element(self, stack: Stack) -> Layer | Base:
        """The layer or base that it is in."""
        return stack.base if self.layer is None else stack.layers[self.layer]

    def value(self, stack: Stack):
        """The value of the parameter there."""
        return self.element(stack)[self.name]

    def with_value(self, stack: Stack, value) -> Stack:
        """The stack with another value there."""
        element = self.element(stack).with_values(**{self.name: value})
        if self.layer is None:
            return replace(stack, base=element)
        return replace(stack, layers=tuple(element if i == self.layer else layer for i, layer in enumerate(stack.layers)))

    def pair(self) -> list:
        """As JSON has it: the layer's index, or -1 for the base, and the name."""
        return [-1 if self.layer is None else self.layer, self.name]

    @classmethod
    def of_pair(cls, index: int, name: str) -> "Place":
        """The place of a `pair`."""
        return cls(None if int(index) < 0 else int(index), str(name))


def places(stack: Stack) -> list[tuple[int | None, Layer | Base]]:
    """The layers from the top and the base, each with the `layer` of its places."""
    return [*enumerate(stack.layers), (None, stack.base)]


def in_words(where: Iterable[Place]) -> str:
    """Places in words: "the roughness of layer 0, the tint of layer 1"."""
    return ", ".join(map(str, where))


def named(stack: Stack, where: Iterable[Place]) -> Sentence:
    """Places in the words of a layer's own name, else of its kind: "the roughness of Varnish, the tint of Dielectric"."""
    return joined(Sentence("the {value} of {element}", value=place.name.replace("_", " "), element=_title(stack, place)) for place in where)


def _title(stack: Stack, place: Place) -> str:
    name = place.element(stack).unknown.get("name")
    if isinstance(name, str) and name:
        return name
    return place.where if place.layer is None else Sentence(SCHEMA.layers[stack.layers[place.layer].kind].label)
