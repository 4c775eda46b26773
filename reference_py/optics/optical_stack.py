# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack resolved, once, into optical terms. The one place that asks which kind a layer or a base is.

`LAYERS` and `BASES` name the class of each kind. Models and methods say by `supports` which classes they compute, which distributions
and which features; what one does not know is refused here, in one line that names who does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import LaminaError
from ..material.schema import ANISOTROPY, CONDUCTOR, DIELECTRIC, LAMBERT, OREN_NAYAR, SCATTERING, THIN_FILM, Feature
from ..material.stack import Base, Layer, Stack
from .bases import ConductorBase, DiffuseBase
from .interface import Interface
from .microfacet import BECKMANN, GGX, is_specular
from .spectral import SpectralStack

LAYERS: dict[str, Any] = {DIELECTRIC.name: Interface}
BASES: dict[str, Any] = {LAMBERT.name: DiffuseBase, OREN_NAYAR.name: DiffuseBase, CONDUCTOR.name: ConductorBase}
# Features that change what a model computes. Coverage makes patches, and normals are the renderer's.
_OPTICAL = (ANISOTROPY, THIN_FILM, SCATTERING)


@dataclass(frozen=True)
class Support:
    """What a model or method computes: classes of layers and bases, names of distributions, features.

    None stands for all that has the methods it calls.
    """

    layers: tuple[type, ...] = (Interface,)
    bases: tuple[type, ...] | None = (DiffuseBase, ConductorBase)
    distributions: tuple[str, ...] | None = (GGX, BECKMANN)
    features: tuple[Feature, ...] = ()
    spectral: bool = True
    """Whether a model's colour axis may have any number of channels, rather than RGB, which methods and lobe sets have alone."""


# Who supports what: by role, "model", "method" or "lobe set", and by name.
USERS: dict[str, dict[str, Support]] = {}


def supports(role: str, **what) -> Callable[[Any], Any]:
    """Decorates a class that has a `name`: states its role, "model" or "lobe set", and its `Support`, as keywords of that."""

    def decorate(cls: Any) -> Any:
        cls.role, cls.support = role, Support(**what)
        USERS.setdefault(role, {})[cls.name] = cls.support
        return cls

    return decorate


@dataclass(frozen=True, eq=False, repr=False)
class OpticalStack:
    """Interfaces from the top, vacuum above the first, each with the medium below it; and the base.

    Of a stack with opaque layers each patch has one (`material.coverage`).
    """

    interfaces: tuple[Interface, ...]
    base: DiffuseBase | ConductorBase

    @classmethod
    def of(cls, stack: Stack, user=None) -> "OpticalStack":
        """Resolve a stack for a model or method, a class or an instance decorated by `supports`.

        Raises LaminaError naming the layer or base, its kind, distribution or feature, and who knows it; a value that is NaN, and spectra.
        """
        elements = [*((f"layer {i}", e) for i, e in enumerate(stack.layers)), ("base", stack.base)]
        for where, element in elements:
            kind = _class_of(element, where, BASES if element is stack.base else LAYERS)
            _require_numbers(where, element)
            if user is not None:
                _require(user, where, element, kind, "bases" if element is stack.base else "layers")
        interfaces, n = [], 1.0
        for layer in stack.layers:
            interfaces.append(LAYERS[layer.kind].of(layer, n))
            n = interfaces[-1].n_below
        base = BASES[stack.base.kind].of(stack.base, n)
        for i, interface in enumerate(interfaces):
            if interface.tau.shape[-1] != base.channels:
                raise LaminaError(
                    "layer {number} has {count} channels and the base {channels}; choose one number for all (optics.spectral)",
                    number=i,
                    count=interface.tau.shape[-1],
                    channels=base.channels,
                )
        is_rgb = base.channels == 3 and not isinstance(stack, SpectralStack)
        if user is not None and not is_rgb and not (user.role == "model" and user.support.spectral):
            able = ", ".join(name for name, support in USERS["model"].items() if support.spectral)
            raise LaminaError(
                "{role} {user} knows RGB alone, and this stack has {channels} spectral channels; choose model {able}",
                role=user.role,
                user=user.name,
                channels=base.channels,
                able=able,
            )
        return cls(tuple(interfaces), base)

    @property
    def channels(self) -> int:
        """Length of the colour axis: 3 for RGB, the number of wavelengths for a stack of `spectral`."""
        return self.base.channels

    def rough_surfaces(self) -> list[tuple[str, float]]:
        """(distribution, alpha) of every surface that does something and is not smooth, from the top: where f can be narrow."""
        facets = [s.facets for s in self.interfaces if not s.does_nothing] + ([self.base.facets] if self.base.facets else [])
        return [(f.distribution, f.alpha) for f in facets if not is_specular(f.alpha)]

    def round_trip(self) -> np.ndarray:
        """(channels,) what two perpendicular crossings of all media leave."""
        return np.exp(-2.0 * sum((s.tau for s in self.interfaces), np.zeros(self.channels)))


def rough_surfaces(stack: Stack) -> list[tuple[str, float]]:
    """`OpticalStack.rough_surfaces` of a stack."""
    return OpticalStack.of(stack).rough_surfaces()


def _class_of(element: Layer | Base, where: str, classes: dict[str, Any]) -> Any:
    if isinstance(element, Layer) and element.is_opaque:
        raise LaminaError(
            "{where} is an opaque {kind}: such a stack is several patches, each one of its own; see registry.make_model", where=where, kind=element.kind
        )
    if element.kind not in classes:
        raise LaminaError("{where}: the kind {kind} has no optics; choose {choices}", where=where, kind=element.kind, choices=", ".join(classes))
    return classes[element.kind]


def _require_numbers(where: str, element: Layer | Base) -> None:
    """Raises LaminaError for a value that is NaN: one that no schema has checked."""
    for name, value in element.values.items():
        if not isinstance(value, str) and np.any(np.isnan(value)):
            raise LaminaError("{where}: {name} is {value!r}, which has a NaN; choose numbers", where=where, name=name, value=value)


def _require(user, where: str, element: Layer | Base, kind: type, place: str) -> None:
    wanted = [(f"{'base' if place == 'bases' else 'layer'} {element.kind}", lambda s: getattr(s, place) is None or issubclass(kind, getattr(s, place)))]
    if "distribution" in element:
        name = element["distribution"]
        wanted.append((f"distribution {name}", lambda s: s.distributions is None or name in s.distributions))
    wanted += [(feature.name, lambda s, f=feature: f in s.features) for feature in _OPTICAL if element.has(feature)]
    for what, knows in wanted:
        if not knows(user.support):
            able = ", ".join(name for name, support in USERS[user.role].items() if knows(support))
            words = {"role": user.role, "user": user.name, "what": what, "where": where}
            if able:
                raise LaminaError("{role} {user} knows no {what}, which {where} has; choose {able}", able=able, **words)
            raise LaminaError("{role} {user} knows no {what}, which {where} has; no {role} does", **words)
