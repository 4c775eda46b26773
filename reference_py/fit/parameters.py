# SPDX-License-Identifier: GPL-3.0-or-later
"""Which values of a stack are free, and how a vector in the unit cube becomes a stack.

Kinds, names and bounds come from the schema. Not free are `thickness`, since only tint ** thickness matters, and the
ways to give a metal other than by its colors. Colors and tints are the squares of their coordinates, as dark ones
matter like bright ones once f is compressed. The density of a medium that scatters is a share of all, as thicknesses
hide what is below, and its colors stand for the tint.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.schema import COLOR, DIELECTRIC, SCATTERING, SCHEMA, Kind, Parameter
from ..material.stack import Base, Layer, Stack

BASES = tuple(SCHEMA.bases)
_METAL_BY = ("reflectance", "edge_color")
_FIXED = ("thickness",)
_SCATTERING = [p for p in SCATTERING.parameters if p.name in ("scatter_color", "density", "scatter_g")]


@dataclass(frozen=True)
class Structure:
    """Count of dielectric layers, kind of base, and the distribution of every surface that has one, from the top."""

    layers: int
    base: str
    distributions: tuple[str, ...]
    cloudy: bool = False
    """Whether the medium above the base scatters."""

    @classmethod
    def of(cls, layers: int, base: str, distribution: str = "ggx", cloudy: bool = False) -> "Structure":
        """All surfaces alike. Raises LaminaError on an unknown base, and where no layer could be cloudy."""
        if cloudy and not layers:
            raise LaminaError("fit: without a layer nothing above the base is cloudy; choose layers 1 or more")
        kind = SCHEMA.base(base, "fit")
        surfaces = layers + any(p.name == "distribution" for p in kind.parameters)
        return cls(layers, base, (distribution,) * surfaces, cloudy)

    @property
    def name(self) -> Sentence:
        """In words, such as "2 layers over conductor"."""
        if self.layers == 1:
            return Sentence("1 cloudy layer over {base}", base=self.base) if self.cloudy else Sentence("1 layer over {base}", base=self.base)
        words = {"layers": self.layers, "base": self.base}
        return Sentence("{layers} cloudy layers over {base}", **words) if self.cloudy else Sentence("{layers} layers over {base}", **words)


@dataclass(frozen=True)
class Group:
    """One parameter of one element. A color has a coordinate per channel, each of which moves that channel alone."""

    where: Sentence
    parameter: Parameter
    index: tuple[int, ...]

    @property
    def is_color(self) -> bool:
        """Whether it has a coordinate per channel, the root of its value."""
        return self.parameter.type == COLOR

    @property
    def name(self) -> Sentence:
        """In words, such as "roughness of layer 0"."""
        return Sentence("{parameter} of {where}", parameter=self.parameter.name, where=self.where)

    @property
    def channel_names(self) -> list[Sentence]:
        """Of a color, such as "red tint of layer 0"."""
        words = {"parameter": self.parameter.name, "where": self.where}
        return [Sentence("{channel} {parameter} of {where}", channel=channel, **words) for channel in (Sentence("red"), Sentence("green"), Sentence("blue"))]

    @property
    def is_depth(self) -> bool:
        """Whether its coordinate is a share of all depths, up to what a slider has."""
        return self.parameter.name == "density"

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest value."""
        return self.parameter.minimum, self.parameter.slider_maximum if self.is_depth else self.parameter.maximum

    def coordinate(self, value):
        """Coordinates of values in the schema's units, limited to its range."""
        low, high = self.range
        value = np.clip(value, low, high)
        if self.is_depth:
            return value / (1.0 + value) * (1.0 + high) / high
        u = (value - low) / (high - low)
        return np.sqrt(u) if self.is_color else u

    def value(self, u):
        """The inverse of `coordinate`."""
        low, high = self.range
        if self.is_depth:
            share = u * high / (1.0 + high)
            return share / (1.0 - share)
        return low + (high - low) * (np.square(u) if self.is_color else u)

    def slope(self, u):
        """The derivative of `value`."""
        low, high = self.range
        if self.is_depth:
            share = high / (1.0 + high)
            return share / np.square(1.0 - u * share)
        return (high - low) * (2.0 * u if self.is_color else np.ones(len(u)))


@dataclass(frozen=True)
class Parameters:
    """The free values of a structure; `channels` is 3, or 1 for grey data."""

    structure: Structure
    channels: int

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The free parameters of the layers from the top, then of the base, with their places in the vector."""
        s = self.structure
        elements = [(Sentence("layer {number}", number=i), _free(DIELECTRIC)) for i in range(s.layers)]
        elements.append((Sentence("the base"), _free(SCHEMA.bases[s.base])))
        if s.cloudy:
            where, free = elements[-2]
            elements[-2] = where, [p for p in free if p.name != "tint"] + _SCATTERING
        groups, start = [], 0
        for where, free in elements:
            for parameter in free:
                size = self.channels if parameter.type == COLOR else 1
                groups.append(Group(where, parameter, tuple(range(start, start + size))))
                start += size
        return tuple(groups)

    @property
    def size(self) -> int:
        """Number of coordinates p."""
        return self.groups[-1].index[-1] + 1

    @property
    def names(self) -> list[Sentence]:
        """One name per coordinate."""
        return [name for group in self.groups for name in (group.channel_names if group.is_color and self.channels == 3 else [group.name])]

    def values(self, x: np.ndarray) -> np.ndarray:
        """(p,) values in the schema's units of coordinates (p,) in 0 to 1."""
        out = np.empty(len(x))
        for g in self.groups:
            out[list(g.index)] = g.value(x[list(g.index)])
        return out

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """(p,) derivative of `values`."""
        out = np.empty(len(x))
        for g in self.groups:
            out[list(g.index)] = g.slope(x[list(g.index)])
        return out

    def ranges(self) -> np.ndarray:
        """(p,) width of each value's range."""
        return np.concatenate([[g.range[1] - g.range[0]] * len(g.index) for g in self.groups])

    def coordinates(self, stack: Stack) -> np.ndarray:
        """The vector (p,) of a stack of this structure; the inverse of `stack`."""
        elements = {f"layer {i}": e for i, e in enumerate(stack.layers)} | {"the base": stack.base}
        x = np.empty(self.size)
        for g in self.groups:
            p = g.parameter
            if p.name not in elements[g.where]:
                raise LaminaError("fit: {where} has no {parameter}", where=g.where, parameter=p.name)
            x[list(g.index)] = g.coordinate(np.atleast_1d(elements[g.where][p.name])[: len(g.index)])
        return x

    def without_effect(self, old: "Parameters", x: np.ndarray) -> np.ndarray:
        """The vector (p,) of one layer more than `old` has at `x`, on top, that does nothing: of vacuum's index, smooth and clear."""
        values = {"ior": 1.0, "roughness": 0.0, "tint": 1.0}
        below = {(f"layer {int(g.where.split()[1]) + 1}" if g.where != "the base" else g.where, g.parameter.name): x[list(g.index)] for g in old.groups}
        result = np.empty(self.size)
        for g in self.groups:
            place = (g.where, g.parameter.name)
            result[list(g.index)] = below[place] if place in below else g.coordinate(values[g.parameter.name])
        return result

    def stack(self, x: np.ndarray, name: str = "", source: str = "") -> Stack:
        """The stack at coordinates (p,)."""
        elements = self._elements(x)
        for element in elements:
            element.update({name: value.tolist() for name, value in element.items() if isinstance(value, np.ndarray)})
        kinds = [DIELECTRIC.name] * self.structure.layers + [self.structure.base]
        *layers, base = ({"kind": kind, **element} for kind, element in zip(kinds, elements))
        return Stack.from_dict({"name": name, "source": source, "layers": layers, "base": base}, "fit")

    def together(self, x: np.ndarray) -> Stack:
        """The stacks at coordinates (B, p) as one, whose numbers are (B, 1) and colors (B, 1, 3): none is checked."""
        *layers, base = ({name: value if isinstance(value, str) else value[:, None] for name, value in e.items()} for e in self._elements(x))
        fixed = {name: DIELECTRIC.parameter(name).default for name in _FIXED}
        return Stack(tuple(Layer(DIELECTRIC.name, fixed | layer) for layer in layers), Base(self.structure.base, base))

    def _elements(self, x: np.ndarray) -> list[dict]:
        """What the layers from the top and the base have, by name: distributions, numbers (...), and colors (..., 3), at coordinates (..., p)."""
        s, x = self.structure, np.clip(x, 0.0, 1.0)
        elements: list[dict] = [{} for _ in range(s.layers + 1)]
        for element, distribution in zip(elements, s.distributions):
            element["distribution"] = distribution
        for g in self.groups:
            here = elements[-1] if g.where == "the base" else elements[int(g.where.split()[1])]
            value = g.value(x[..., g.index])
            here[g.parameter.name] = np.broadcast_to(value, (*value.shape[:-1], 3)) if g.is_color else value[..., 0]
        return elements


def _free(kind: Kind) -> list[Parameter]:
    other = {name for group in kind.alternatives if group != _METAL_BY for name in group}
    return [p for p in kind.parameters if not p.is_structural and p.name not in other and p.name not in _FIXED]
