# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose normal a lobe is about, in stacks whose layers or base have normals of their own.

A lobe is one of a surface that its element's normal is the normal of: weights, widths and tilt are read at the view's angle to it. Where
all elements have one normal that is exact. Where they differ, light crosses the layers above as if these were inclined alike.
"""

from collections.abc import Sequence
from dataclasses import replace

from ..material.place import Place
from ..material.schema import NORMAL
from ..material.stack import Stack

# What a fitted lobe is: what the top reflects, what comes from below it, and diffuse light.
TOP, BELOW, DIFFUSE = "top", "below", "diffuse"


def normal_place(stack: Stack, layer: int | None) -> Place | None:
    """The own normal of a layer, or of the base for None; None where it has the surface's."""
    place = Place(layer, NORMAL.parameters[0].name)
    return place if place.element(stack).has(NORMAL) else None


def has_own_normals(stack: Stack) -> bool:
    """Whether any element has its own: then what the top reflects needs a lobe of its own."""
    return any(element.has(NORMAL) for element in (*stack.layers, stack.base))


def normals_of_fits(stack: Stack, lobes: Sequence[str]) -> list[Place | None]:
    """The own normals that fitted lobes, each TOP, BELOW or DIFFUSE, are about.

    What comes from below is of a rough base where there is one, else of the lowest layer.
    """
    last = len(stack.layers) - 1
    base_shines = "roughness" in stack.base
    layer_of = {TOP: 0 if stack.layers else None, BELOW: None if base_shines or not stack.layers else last, DIFFUSE: None}
    return [normal_place(stack, layer_of[lobe]) for lobe in lobes]


def about_own_normals(stack: Stack, lobes: list, layers: int) -> list:
    """Lobes, one of each of the first `layers` and then those of the base, each about the normal of its element."""
    return [replace(lobe, normal=normal_place(stack, i if i < layers else None)) for i, lobe in enumerate(lobes)]
