# SPDX-License-Identifier: GPL-3.0-or-later
"""Features that tables over the view cannot hold: they know neither azimuths nor films' colors in a lobe."""

from dataclasses import replace
from types import MappingProxyType

from ...material.place import Place, in_words, places
from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM
from ...material.stack import LayerOrBase, Stack
from ...optics.interface import Microfacets

_FEATURES = (ANISOTROPY, THIN_FILM)


def needs_live(stack: Stack) -> str | None:
    """What a bake of the stack could not hold, in words; None where it can hold everything."""
    return in_words(not_bakeable(stack)) or None


def not_bakeable(stack: Stack) -> tuple[Place, ...]:
    """Features that tables over the view cannot hold."""
    return tuple(Place(i, feature.name) for i, element in places(stack) for feature in _FEATURES if element.has(feature))


def scatters(stack: Stack) -> bool:
    """Whether a medium of the stack scatters, which bakes alone know."""
    return any(layer.has(SCATTERING) for layer in stack.layers)


def bakeable(stack: Stack) -> Stack:
    """The stack without the features of `not_bakeable`; its surfaces are as rough as those that they had."""
    names = {p.name for feature in _FEATURES for p in feature.parameters}

    def plain(element: LayerOrBase) -> LayerOrBase:
        values = {k: v for k, v in element.values.items() if k not in names}
        if element.has(ANISOTROPY):
            values["roughness"] = Microfacets.of(element).alpha ** 0.5
        return replace(element, values=MappingProxyType(values))

    return replace(stack, layers=tuple(plain(layer) for layer in stack.layers), base=plain(stack.base)) if not_bakeable(stack) else stack
