# SPDX-License-Identifier: GPL-3.0-or-later
"""Which surfaces of a stack are brushed, along what, and the stack without that."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ..material.place import Place, places
from ..material.schema import ANISOTROPY
from ..material.stack import LayerOrBase, Stack
from ..optics.interface import Microfacets

_NAMES = {p.name for p in ANISOTROPY.parameters}


def has_brushing(stack: Stack) -> bool:
    """Whether a surface of the stack is anisotropic."""
    return any(element.has(ANISOTROPY) for _, element in places(stack))


def directions(stack: Stack) -> set[float]:
    """Directions of brushing in radians from the tangent, 0 to pi."""
    return {round(Microfacets.of(element).anisotropic.angle % np.pi, 9) for _, element in places(stack) if element.has(ANISOTROPY)}


def isotropic(stack: Stack) -> Stack:
    """The stack without anisotropy; its surfaces are as rough as those that they had."""

    def plain(element: LayerOrBase) -> LayerOrBase:
        return _without(element, roughness=Microfacets.of(element).alpha ** 0.5) if element.has(ANISOTROPY) else element

    return replace(stack, layers=tuple(map(plain, stack.layers)), base=plain(stack.base))


def without_idle(stack: Stack, live: tuple[Place, ...] = ()) -> tuple[Stack, tuple[Place, ...]]:
    """The stack without anisotropies of 0, which are none, unless they are of the live values; and these without rotations that turn nothing."""
    idle = [i for i, element in places(stack) if element.has(ANISOTROPY) and element["anisotropy"] == 0.0 and Place(i, "anisotropy") not in live]
    if not idle:
        return stack, live
    layers = tuple(_without(layer) if i in idle else layer for i, layer in enumerate(stack.layers))
    plain = replace(stack, layers=layers, base=_without(stack.base) if None in idle else stack.base)
    return plain, tuple(place for place in live if place.layer not in idle or place.name not in _NAMES)


def _without(element: LayerOrBase, **values) -> LayerOrBase:
    return replace(element, values=MappingProxyType({k: v for k, v in element.values.items() if k not in _NAMES} | values))
