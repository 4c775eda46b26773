# SPDX-License-Identifier: GPL-3.0-or-later
"""Features that tables over the view cannot hold: they know neither azimuths, nor films' colors in a lobe, nor normals."""

from dataclasses import replace
from types import MappingProxyType

from ...material.schema import ANISOTROPY, NORMAL, THIN_FILM
from ...material.stack import Element, Stack
from ...optics.interface import Microfacets

_UNBAKED = (ANISOTROPY, THIN_FILM, NORMAL)


def needs_live(stack: Stack) -> str | None:
    """What a bake of the stack could not hold, in words; None where it can hold everything."""
    return ", ".join(f"the {name} of {'the base' if i < 0 else f'layer {i}'}" for i, name in unbaked(stack)).replace("_", " ") or None


def unbaked(stack: Stack) -> tuple[tuple[int, str], ...]:
    """Features that tables over the view cannot hold, as (index of the layer or -1, name)."""
    elements = [*enumerate(stack.layers), (-1, stack.base)]
    return tuple((i, feature.name) for i, element in elements for feature in _UNBAKED if element.has(feature))


def without_unbaked(stack: Stack) -> Stack:
    """The stack without the features of `unbaked`; its surfaces are as rough as those that they had."""
    names = {p.name for feature in _UNBAKED for p in feature.parameters}

    def plain(element: Element) -> Element:
        values = {k: v for k, v in element.values.items() if k not in names}
        if element.has(ANISOTROPY):
            values["roughness"] = Microfacets.of(element).alpha ** 0.5
        return replace(element, values=MappingProxyType(values))

    return replace(stack, layers=tuple(plain(layer) for layer in stack.layers), base=plain(stack.base)) if unbaked(stack) else stack
