# SPDX-License-Identifier: GPL-3.0-or-later
"""What exporters get of a stack: Principled values, kept by content, as they take up to a second to solve."""

from dataclasses import dataclass

import numpy as np

from ..lobes.cache import cached, get, stack_key
from ..material.schema import COVERAGE
from ..material.stack import Stack
from .matching import ColorMap
from .principled import EXPORTED, NAME, exported_values, to_principled
from .slots import from_stack


@dataclass(frozen=True)
class HandOver:
    """Values by socket name and `owners`, both as in Converted; what is not named is at its default.

    `error` is the mean difference in uniform light over the mean albedo; None where the base color is not solved yet.
    `colors` maps textures of the base color; None unless asked for and solved.
    """

    values: dict
    owners: dict[str, int]
    error: float | None = None
    colors: ColorMap | None = None

    def packed(self) -> dict:
        """All of it as JSON's types, for `unpacked`."""
        colors = self.colors and {"p": [list(map(float, p)) for p in (self.colors.p0, self.colors.p1, self.colors.p2)], "most": float(self.colors.most)}
        values = {name: [float(v) for v in value] if isinstance(value, tuple) else float(value) for name, value in self.values.items()}
        return {"values": values, "owners": self.owners, "error": self.error, "colors": colors}


def unpacked(data: dict) -> HandOver:
    """What `packed` gave."""
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in data["values"].items()}
    colors = data["colors"] and ColorMap(*map(np.array, data["colors"]["p"]), data["colors"]["most"])
    return HandOver(values, dict(data["owners"]), data["error"], colors)


def key_of(stack: Stack, textured: bool) -> str:
    """Names the hand-over of a stack by content."""
    shares = [f"{layer[COVERAGE.parameters[0].name]:.5g}" if layer.has(COVERAGE) else "" for layer in stack.layers]
    return f"{NAME} exported, films in its color {textured:d} {stack_key(stack)} {' '.join(shares)}"


def provisional(stack: Stack) -> HandOver:
    """At once: every value but the base color as it will be; that one is the stack's own, too bright under a coat, and without the color of a film."""
    placed = from_stack(stack, NAME, EXPORTED)
    return HandOver(exported_values(placed.slots), placed.owners)


def cached_hand_over(stack: Stack, textured: bool) -> HandOver | None:
    """The solved one, if it was asked for before."""
    return get(key_of(stack, textured), unpacked)


def solved(stack: Stack, textured: bool) -> HandOver:
    """With the base color solved, and, where `textured`, with a map for textures of it. Raises LaminaError."""

    def make() -> HandOver:
        converted = to_principled(stack, textured, exported=True)
        return HandOver(converted.values, converted.owners, converted.report.match.soft_light, converted.colors)

    return cached(key_of(stack, textured), make, HandOver.packed, unpacked)


def put(stack: Stack, textured: bool, packed: dict) -> None:
    """Keep what a worker solved."""
    cached(key_of(stack, textured), lambda: unpacked(packed), HandOver.packed, unpacked)
