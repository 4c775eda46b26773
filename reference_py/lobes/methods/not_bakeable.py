# SPDX-License-Identifier: GPL-3.0-or-later
"""Features that tables over the view cannot hold: most anisotropy, and films on a rough top where normals differ, as that has no lobe apart."""

from collections.abc import Iterable
from dataclasses import replace
from types import MappingProxyType

from ...material.place import Place, in_words, places
from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM, Feature
from ...material.stack import Stack
from ...optics.interface import Microfacets, film_of
from ..baked import is_brushed
from ..brushing import isotropic
from ..own_normals import has_own_normals


def needs_live(stack: Stack) -> str | None:
    """What a bake of the stack could not hold, in words; None where it can hold everything."""
    return in_words(not_bakeable(stack)) or None


def not_bakeable(stack: Stack) -> tuple[Place, ...]:
    """Features that tables over the view cannot hold."""
    return tuple(Place(i, feature.name) for i, _ in places(stack) for feature in _lost(stack, i))


def _lost(stack: Stack, i: int | None) -> list[Feature]:
    """Of the features of a layer, or of the base for None, those that tables cannot hold."""
    element = stack.base if i is None else stack.layers[i]
    lost = [ANISOTROPY] if element.has(ANISOTROPY) and not is_brushed(stack) else []
    # of rough tops those with a dielectric's curve alone have a closure apart, with a normal of its own
    is_rough_film = i == 0 and film_of(element) is not None and not Microfacets.of(element).is_specular
    return [*lost, THIN_FILM] if is_rough_film and has_own_normals(stack) else lost


def beyond_bakes(stack: Stack, live: Iterable[Place]) -> str:
    """Which live values no bake follows, and which features of `not_bakeable` it does not hold, in words; the stack is without these."""
    where = tuple(dict.fromkeys(live))
    gone = [place for place in where if place.name in (ANISOTROPY.name, THIN_FILM.name) and place.name not in place.element(stack)]
    there = [place for place in where if place not in gone]
    return " or ".join(f"{verb} {in_words(places)}" for verb, places in (("hold", gone), ("follow", there)) if places)


def scatters(stack: Stack) -> bool:
    """Whether a medium of the stack scatters, which bakes alone know."""
    return any(layer.has(SCATTERING) for layer in stack.layers)


def has_film(stack: Stack) -> bool:
    """Whether a surface of the stack has a thin film, which the method analytic does not know."""
    return any(element.has(THIN_FILM) for _, element in places(stack))


def bakeable(stack: Stack) -> Stack:
    """The stack without the features of `not_bakeable`; its surfaces are as rough as those that they had."""
    lost = {place.name for place in not_bakeable(stack)}
    plain = isotropic(stack) if ANISOTROPY.name in lost else stack
    if THIN_FILM.name not in lost:
        return plain
    names = {p.name for p in THIN_FILM.parameters}
    top = plain.layers[0]
    return replace(plain, layers=(replace(top, values=MappingProxyType({k: v for k, v in top.values.items() if k not in names})), *plain.layers[1:]))
