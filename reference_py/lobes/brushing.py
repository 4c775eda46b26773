# SPDX-License-Identifier: GPL-3.0-or-later
"""Which surfaces of a stack are brushed, along what, and the stack without that."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ..material.place import places
from ..material.schema import ANISOTROPY
from ..material.stack import LayerOrBase, Stack
from ..optics.interface import Microfacets


def has_brushing(stack: Stack) -> bool:
    """Whether a surface of the stack is anisotropic."""
    return any(element.has(ANISOTROPY) for _, element in places(stack))


def directions(stack: Stack) -> set[float]:
    """Directions of brushing in radians from the tangent, 0 to pi."""
    return {round(Microfacets.of(element).anisotropic.angle % np.pi, 9) for _, element in places(stack) if element.has(ANISOTROPY)}


def isotropic(stack: Stack) -> Stack:
    """The stack without anisotropy; its surfaces are as rough as those that they had."""
    names = {p.name for p in ANISOTROPY.parameters}

    def plain(element: LayerOrBase) -> LayerOrBase:
        if not element.has(ANISOTROPY):
            return element
        values = {k: v for k, v in element.values.items() if k not in names} | {"roughness": Microfacets.of(element).alpha ** 0.5}
        return replace(element, values=MappingProxyType(values))

    return replace(stack, layers=tuple(map(plain, stack.layers)), base=plain(stack.base))
