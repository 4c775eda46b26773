# SPDX-License-Identifier: GPL-3.0-or-later
"""The material as the user means it: immutable, validated, JSON in and out."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from types import MappingProxyType
from typing import Self, TypeVar

from ..atomic import write_text
from ..errors import LaminaError, Sentence
from . import tint_spectrum
from .json_input import parse_json, read_text
from .masks import KEY as MASKS
from .masks import Mask, masks_of
from .schema import COVERAGE, DIELECTRIC, ILLUMINANTS, SCHEMA, SCHEMA_VERSION, Feature, Kind, Schema

MAX_LAYERS = 64
_COVERAGE = {p.name for p in COVERAGE.parameters}


def _frozen(mapping: Mapping) -> Mapping:
    return MappingProxyType(dict(mapping))


@dataclass(frozen=True)
class _Part:
    """Its kind, its values by parameter name, the keys we do not know, and the masks that say where a value lies, by parameter name."""

    kind: str
    values: Mapping
    unknown: Mapping = field(default_factory=lambda: _frozen({}))
    masks: Mapping[str, Mask] = field(default_factory=lambda: _frozen({}))

    def __getitem__(self, name: str):
        return self.values[name]

    def __contains__(self, name: str) -> bool:
        return name in self.values

    def has(self, feature: Feature) -> bool:
        """Whether it has an optional feature."""
        return feature.parameters[0].name in self.values

    def with_values(self, **values) -> Self:
        """A copy with some values replaced; not validated until it enters a Stack by `Stack.from_dict`."""
        return replace(self, values=_frozen({**self.values, **values}))

    def to_dict(self) -> dict:
        """Kind, values, masks and unknown keys as plain JSON types."""
        known = {k: list(v) if isinstance(v, tuple) else v for k, v in self.values.items()}
        drawn = {MASKS: {name: mask.to_dict() for name, mask in self.masks.items()}} if self.masks else {}
        return {"kind": self.kind, **known, **drawn, **self.unknown}


class Layer(_Part):
    """A layer: the interface at its top and the medium below that, or, of a base's kind, an opaque one that hides what is below."""

    @property
    def is_opaque(self) -> bool:
        """Whether nothing below it is seen where it is."""
        return SCHEMA.is_opaque(self.kind)

    def as_base(self) -> "Base":
        """The base that an opaque layer is where it is there."""
        values, masks = (_frozen({k: v for k, v in part.items() if k not in _COVERAGE}) for part in (self.values, self.masks))
        return Base(self.kind, values, self.unknown, masks)


class Base(_Part):
    """The opaque base."""


LayerOrBase = TypeVar("LayerOrBase", Layer, Base)


@dataclass(frozen=True)
class Stack:
    """Layers from the top over an opaque base."""

    layers: tuple[Layer, ...]
    base: Base
    name: str = ""
    source: str = ""
    unknown: Mapping = field(default_factory=lambda: _frozen({}))

    @classmethod
    def from_dict(cls, data, where: str = "stack", schema: Schema = SCHEMA) -> "Stack":
        """Validate a plain dictionary. Missing keys take the schema's defaults, unknown keys are kept.

        Keys of a version-1 stack that meant nothing then and would now are kept under another name, "coverage_v1". Without
        a base the lowest layer is it, where that is opaque and covers all.
        Raises LaminaError naming `where`, the key, the value and the choices.
        """
        if not isinstance(data, Mapping):
            raise LaminaError("{where}: a stack is a JSON object with 'layers' and 'base', not {type}", where=where, type=type(data).__name__)
        version = data.get("schema_version", SCHEMA_VERSION)
        if isinstance(version, bool) or not isinstance(version, int) or version < 1:
            raise LaminaError(
                "{where}: schema_version {version!r} is no version; this Lamina reads 1 to {newest}", where=where, version=version, newest=SCHEMA_VERSION
            )
        if version > SCHEMA_VERSION:
            raise LaminaError(
                "{where}: schema_version {version} is newer than this Lamina, which reads 1 to {newest}", where=where, version=version, newest=SCHEMA_VERSION
            )
        layers = data.get("layers", [])
        if not isinstance(layers, (list, tuple)):
            raise LaminaError("{where}: 'layers' must be a list, not {type}", where=where, type=type(layers).__name__)
        if len(layers) > MAX_LAYERS:
            raise LaminaError("{where}: {count} layers are too many; choose at most {most}", where=where, count=len(layers), most=MAX_LAYERS)
        for key in ("name", "source"):
            if not isinstance(data.get(key, ""), str):
                raise LaminaError("{where}: {key} must be text, not {data!r}", where=where, key=key, data=data[key])
        known = {"schema_version", "name", "source", "layers", "base"}
        parts = tuple(_part(Layer, d, Sentence("{where}: layer {number}", where=where, number=i), schema.layer, version) for i, d in enumerate(layers))
        if "base" in data:
            base = _part(Base, data["base"], Sentence("{where}: base", where=where), schema.base, version)
        else:
            *parts, base = _with_lowest_as_base(parts, where, schema)
        illuminant = data.get(tint_spectrum.ILLUMINANT, ILLUMINANTS[0])
        clear = [
            (layer, base, illuminant, "tint" in d, Sentence("{where}: layer {number}", where=where, number=i))
            for i, (layer, d) in enumerate(zip(parts, layers))
        ]
        return cls(
            layers=tuple(tint_spectrum.with_tint(*each) if "tint" in each[0] else each[0] for each in clear),
            base=base,
            name=data.get("name", ""),
            source=data.get("source", ""),
            unknown=_frozen({k: v for k, v in data.items() if k not in known}),
        )

    def to_dict(self) -> dict:
        """Plain JSON types, unknown keys included; the inverse of `from_dict`."""
        return {
            "schema_version": SCHEMA_VERSION,
            "name": self.name,
            "source": self.source,
            "layers": [layer.to_dict() for layer in self.layers],
            "base": self.base.to_dict(),
            **self.unknown,
        }

    def unknown_keys(self) -> list[str]:
        """One sentence per key that is kept but has no effect. `name` of a layer or the base is a label."""
        spectral = [layer for layer in self.layers if tint_spectrum.spectrum_of(layer)]
        known = ("layers", "base", "name", "source", "schema_version", tint_spectrum.ILLUMINANT)
        messages = [_no_effect("stack", key, known) for key in self.unknown if not (spectral and key == tint_spectrum.ILLUMINANT)]
        named = [(f"layer {i}", e, SCHEMA.layers[e.kind]) for i, e in enumerate(self.layers)]
        for where, element, kind in [*named, ("base", self.base, SCHEMA.bases[self.base.kind])]:
            for key in element.unknown:
                if key == tint_spectrum.KEY and element.kind == DIELECTRIC.name:
                    if element not in spectral:
                        messages.append(f"{where}: {key} is kept and has no effect, as the layer has a tint of its own; leave tint out")
                elif key != "name":
                    messages.append(_no_effect(where, key, [p.name for p in kind.all_parameters]))
        return messages

    @classmethod
    def from_json(cls, text: str, where: str = "stack") -> "Stack":
        """The stack of a JSON text. Raises LaminaError on what is no JSON or no valid stack."""
        return cls.from_dict(parse_json(text, where), where)

    def to_json(self) -> str:
        """JSON text for people to read, with a newline at its end."""
        return _json_text(self.to_dict()) + "\n"

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Stack":
        """Read a stack file. Raises LaminaError when it cannot be read or is not a valid stack."""
        return cls.from_json(read_text(path, "stack file"), str(path))

    def save(self, path: str | os.PathLike) -> None:
        """Write the stack as JSON, whole or not at all. Raises LaminaError when the path is not writable."""
        write_text(path, self.to_json())


def _with_lowest_as_base(layers: tuple[Layer, ...], where: str, schema: Schema) -> tuple[Layer | Base, ...]:
    """The layers with the lowest as the base. Raises LaminaError where that does not hide what would be below."""
    advice = Sentence("choose one of {choices}", choices=", ".join(schema.bases))
    if not layers:
        raise LaminaError("{where}: the stack is empty, it has no 'base'; {advice}", where=where, advice=advice)
    lowest = layers[-1]
    if not lowest.is_opaque:
        raise LaminaError("{where}: there is no 'base', and the lowest layer, {kind}, is clear; {advice}", where=where, kind=lowest.kind, advice=advice)
    if lowest.has(COVERAGE) and lowest["coverage"] < 1.0:
        raise LaminaError(
            "{where}: there is no 'base', and the lowest layer, {kind}, covers {coverage:g} of the surface; {advice}",
            where=where,
            kind=lowest.kind,
            coverage=lowest["coverage"],
            advice=advice,
        )
    return (*layers[:-1], lowest.as_base())


def _no_effect(where: str, key: str, known) -> str:
    close = get_close_matches(key.lower(), known, 1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{where}: unknown key {key!r} is kept and has no effect{hint}"


def _json_text(value, indent: str = "") -> str:
    """JSON with two spaces of indent and every list of plain numbers on one line: people read stack files too."""
    inner = indent + "  "
    if isinstance(value, dict) and value:
        rows = [f"{inner}{json.dumps(k, ensure_ascii=False)}: {_json_text(v, inner)}" for k, v in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(v, (dict, list)) for v in value):
        return "[\n" + ",\n".join(inner + _json_text(v, inner) for v in value) + f"\n{indent}]"
    return json.dumps(value, ensure_ascii=False)


def _part(part: type[LayerOrBase], data, where: str, kind_of, version: int) -> LayerOrBase:
    if not isinstance(data, Mapping):
        raise LaminaError("{where}: must be a JSON object with a 'kind', not {data!r}", where=where, data=data)
    kind: Kind = kind_of(data.get("kind"), where)
    if version == 1:
        new = {p.name for feature in kind.features for p in feature.parameters}
        data = {f"{key}_v1" if key in new else key: value for key, value in data.items()}
    names = _given_names(kind, data, where)
    values = {p.name: p.check(data.get(p.name, p.default), where) for p in kind.all_parameters if p.name in names}
    known = {"kind", MASKS} | {p.name for p in kind.all_parameters}
    drawn = masks_of(data.get(MASKS, {}), (p for p in kind.all_parameters if p.name in values), where)
    return part(kind.name, _frozen(values), _frozen({k: v for k, v in data.items() if k not in known}), drawn)


def _given_names(kind: Kind, data: Mapping, where: str) -> set[str]:
    """The parameters that this element uses: of the kind's alternatives just the one that is given, of its features those."""
    names = _without_alternatives(kind, data, where)
    for feature in kind.features:
        if any(p.name in data for p in feature.parameters):
            names |= _without_alternatives(feature, data, where)
    return names


def _without_alternatives(owner: Kind | Feature, data: Mapping, where: str) -> set[str]:
    names, alternatives = {p.name for p in owner.parameters}, owner.alternatives
    if not alternatives:
        return names
    given = [group for group in alternatives if any(name in data for name in group)]
    if len(given) > 1:
        options = " or ".join(owner.given_choices)
        both = " and ".join("+".join(group) for group in given)
        raise LaminaError("{where}: {both} exclude each other; choose {options}", where=where, both=both, options=options)
    chosen = given[0] if given else alternatives[0]
    missing = [name for name in chosen if name not in data]
    if given and missing:
        raise LaminaError("{where}: {names} go together; {missing} is missing", where=where, names="+".join(chosen), missing=", ".join(missing))
    return names - {name for group in alternatives if group is not chosen for name in group}
