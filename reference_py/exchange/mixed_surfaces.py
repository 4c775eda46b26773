# SPDX-License-Identifier: GPL-3.0-or-later
"""A `mix` of two surfaces of a MaterialX file, as one stack where layers with coverage say it exactly.

A share of an opaque layer, or of a coat, makes patches that are the two surfaces themselves. So it can be said where one has no layer, where both lie
under the same layers, and where one is the other with a coat more.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..errors import LaminaError, Sentence
from ..material.stack import Stack
from .conversion import Converted
from .report import LOST, Loss, Report


@dataclass(frozen=True)
class MixedSurfaces:
    """`share` of the second material, the rest of the first, each a `materialx.Material`, a `LayeredMaterial` or a mix again."""

    name: str
    first: Any
    second: Any
    share: float
    losses: tuple[Loss, ...] = ()
    """What reading it cost."""
    node: str = "mix"
    values: Mapping = field(default_factory=dict)
    """It has no inputs of its own."""
    images: Mapping = field(default_factory=dict)
    """Those of both are lost, and said."""

    def with_means(self, _means: Mapping) -> "MixedSurfaces":
        """Itself."""
        return self

    def places(self, _given: str, _converted: Converted) -> list[tuple[int, str]]:
        """None."""
        return []

    def to_stack(self, without: frozenset[str] = frozenset()) -> Converted:
        """The stack of both. Raises LaminaError where layers with coverage cannot say it."""
        parts = [part.to_stack(without=frozenset(part.images)) for part in (self.first, self.second)]
        data = _joined(*(part.stack.to_dict() for part in parts), self.share)
        if data is None:
            raise LaminaError(
                "{name}: a mix of two surfaces of unlike layers, {first} and {second}, which no stack has; known are one without layers, both under the same layers, and one that is the other with a coat more",
                name=self.name or "mix",
                first=_words(parts[0].stack),
                second=_words(parts[1].stack),
            )
        stack = Stack.from_dict(data | {"name": self.name, "source": "Converted from a mix of surfaces"}, self.name or "mix")
        told = [replace(loss, parameter=f"{where} {loss.parameter}") for where, part in zip(("bg", "fg"), parts) for loss in part.report.losses]
        images = [
            Loss(f"{where} images", ", ".join(sorted(part.images))[:60], LOST, Sentence("of surfaces that are mixed"))
            for where, part in self._parts
            if part.images
        ]
        worse = max((part.report.match for part in parts), key=lambda match: match.soft_light)
        return Converted(stack, {}, None, {}, Report((*self.losses, *images, *told), worse))

    @property
    def _parts(self) -> tuple:
        return ("bg", self.first), ("fg", self.second)


def _joined(first: dict, second: dict, share: float) -> dict | None:
    """Layers and base of both stacks' dicts, with `share` of the second; None where they are too unlike."""
    first, second = ({"layers": [_nameless(row) for row in stack["layers"]], "base": _nameless(stack["base"])} for stack in (first, second))
    if share in (0.0, 1.0) or first == second:
        return second if share else first
    for above, below, covered in ((second, first, share), (first, second, 1.0 - share)):
        layers, rest = above["layers"], below["layers"]
        if above["base"] == below["base"] and layers[1:] == rest and layers and "coverage" not in layers[0]:
            return {"layers": [layers[0] | {"coverage": covered}, *rest], "base": below["base"]}
        if not layers or layers == rest:
            return {"layers": [*layers, above["base"] | {"coverage": covered}, *rest[len(layers) :]], "base": below["base"]}
    return None


def _nameless(row: dict) -> dict:
    return {key: value for key, value in row.items() if key != "name"}


def _words(stack: Stack) -> str:
    return f"{len(stack.layers)} layers over {stack.base.kind}"
