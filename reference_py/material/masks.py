# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks: where on a surface a value lies, by a generator of patterns that Blender draws. The models know the value alone, as the mean.

In a stack's layer or base: "masks": {"coverage": {"generator": "edges", "amount": 0.15}}; what is missing takes the defaults below.
Lengths are shares of the object's largest dimension, so that one preset suits a thimble and a tower.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..errors import LaminaError, Sentence
from .schema import FLOAT, Parameter

KEY = "masks"
_GENERATOR = "generator"


@dataclass(frozen=True)
class Generator:
    """A way to draw a mask, and the values that it takes."""

    name: str
    label: str
    help: str
    parameters: tuple[Parameter, ...]
    value: str = "coverage"
    """The parameter that it is made for."""


@dataclass(frozen=True)
class Mask:
    """A generator with all its values."""

    generator: Generator
    values: Mapping[str, float]

    def to_dict(self) -> dict:
        """As in a stack's JSON."""
        return {_GENERATOR: self.generator.name, **self.values}


def _number(name: str, default: float, label: str, text: str, minimum: float = 0.0, maximum: float = 1.0) -> Parameter:
    return Parameter(name, FLOAT, default, label, text, minimum, maximum)


def _drawn(name: str, label: str, text: str, amount: float, scale: float, *more: Parameter, value: str = "coverage") -> Generator:
    """A generator with what all of them take."""
    return Generator(name, label, text, (
        _number("amount", amount, "Amount", "Share of the surface that the mask takes where nothing draws it, and, of what settles, where the surface faces up; 0 is nowhere"),
        _number("scale", scale, "Scale", "How often the pattern comes along the object's largest dimension", 0.01, 1000.0),
        *more,
        _number("softness", 0.12, "Softness", "How gradually the mask ends; 0 is cut with a knife", 0.0, 50.0),
        _number("seed", 0.0, "Seed", "Another pattern of the same kind", 0.0, 1000.0),
        _number("low", 0.0, "Low", "Value where the mask is not"),
        _number("high", 1.0, "High", "Value where the mask is"),
    ), value)  # fmt: skip


def _pull(text: str, default: float) -> Parameter:
    return _number("pull", default, "Pull", text, 0.0, 100.0)


GENERATORS = MappingProxyType({g.name: g for g in (
    _drawn("patches", "Patches", "Patches of all sizes, anywhere", 0.3, 3.0),
    _drawn("edges", "Worn Edges", "Chips where the form has edges, and some elsewhere. For EEVEE and OptiX use Bake Masks", 0.08, 5.0,
           _pull("How strongly edges draw the mask", 4.0),
           _number("width", 0.02, "Width", "How far from an edge it is drawn, of the object's largest dimension", 0.0001, 1.0)),
    _drawn("cavities", "Dirt in Cavities", "In corners, grooves and wherever little light gets to. For EEVEE and OptiX use Bake Masks", 0.08, 4.0,
           _pull("How strongly cavities draw the mask", 4.0),
           _number("width", 0.15, "Width", "How far the walls of a cavity may be, of the object's largest dimension", 0.0001, 1.0)),
    _drawn("settled", "Settled from Above", "On what faces up, as dust and snow lie", 0.7, 5.0, _pull("How strictly the mask keeps to what faces up", 3.0)),
    _drawn("drips", "Drips from Above", "Streaks down the object's Z on what is upright, as rain and rust leave them", 0.2, 9.0,
           _number("length", 8.0, "Length", "How many times longer than wide a streak is", 1.0, 100.0)),
    _drawn("fingerprints", "Fingerprints", "Prints of fingertips with their ridges; made for a roughness or a thin film", 0.35, 5.0,
           _number("ridges", 9.0, "Ridges", "Ridges from the middle of a print to its rim", 1.0, 100.0), value="roughness"),
)})  # fmt: skip


def can_be_masked(parameter: Parameter) -> bool:
    """Whether a mask may give a parameter: a number from 0 to 1."""
    return parameter.type == FLOAT and (parameter.minimum, parameter.maximum) == (0.0, 1.0)


def generator_of(name, where: str) -> Generator:
    """The generator of a name. Raises LaminaError with the choices."""
    if not isinstance(name, str) or name not in GENERATORS:
        raise LaminaError("{where}: unknown generator {name!r}; choose {choices}", where=where, name=name, choices=", ".join(GENERATORS))
    return GENERATORS[name]


def masks_of(data, parameters: Iterable[Parameter], where: str) -> Mapping[str, Mask]:
    """The masks of an element by the names of its parameters, of what its key KEY holds. Raises LaminaError naming what is wrong and the choices."""
    if not isinstance(data, Mapping):
        raise LaminaError('{where}: masks are a JSON object such as {{"coverage": {{"generator": "edges"}}}}, not {data!r}', where=where, data=data)
    able = [p.name for p in parameters if can_be_masked(p)]
    found = {}
    for name, values in data.items():
        if name not in able:
            raise LaminaError("{where}: {name!r} takes no mask; choose {choices}", where=where, name=name, choices=", ".join(able) or "none: nothing here does")
        found[name] = _mask_of(values, Sentence("{where}: mask of {name}", where=where, name=name))
    return MappingProxyType(found)


def _mask_of(data, where: str) -> Mask:
    if not isinstance(data, Mapping):
        raise LaminaError("{where}: must be a JSON object with a 'generator', not {data!r}", where=where, data=data)
    generator = generator_of(data.get(_GENERATOR), where)
    known = [p.name for p in generator.parameters]
    for key in data:
        if key != _GENERATOR and key not in known:
            raise LaminaError("{where}: unknown key {key!r}; choose {choices}", where=where, key=key, choices=", ".join(known))
    return Mask(generator, MappingProxyType({p.name: p.check(data.get(p.name, p.default), where) for p in generator.parameters}))
