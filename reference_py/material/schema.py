# SPDX-License-Identifier: GPL-3.0-or-later
"""Every parameter of every layer and base kind, once.

Panel, node sockets, OSL signature, Stack validation and JSON are all derived from `SCHEMA`.
A default or a range is written here and nowhere else.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from types import MappingProxyType

from ..errors import LaminaError, Sentence, joined

SCHEMA_VERSION = 4

# Light by which spectra become colors: daylight, lamp light, equal energy; the first unless a stack names another.
ILLUMINANTS = ("D65", "A", "E")

FLOAT, COLOR, VECTOR, CHOICE = "float", "color", "vector", "choice"


# Of parameters, features and kinds there is one each, so they are compared by identity: a save does that some hundred thousand times.
@dataclass(frozen=True, eq=False)
class Parameter:
    """One parameter. Values of type float, color and vector live in sockets; a choice is structure."""

    name: str
    type: str
    default: object
    label: str
    help: str
    minimum: float = 0.0
    maximum: float = 1.0
    unit: str = ""
    choices: tuple[str, ...] = ()
    look: str = ""
    """What it does to the look and what is usual, for those who drag it; empty where `help` says that."""

    soft_maximum: float | None = None
    """Where a slider ends, if not at `maximum`: what is typed may be more."""

    @property
    def slider_maximum(self) -> float:
        """The largest value that is dragged to."""
        return self.maximum if self.soft_maximum is None else self.soft_maximum

    @property
    def tooltip(self) -> str:
        """What Blender says of it under the mouse."""
        return self.look or self.help

    @property
    def is_structural(self) -> bool:
        """Whether it changes the shader's text, and so has no socket."""
        return self.type == CHOICE

    @property
    def osl_name(self) -> str:
        """CamelCase name, as OSL shader parameters are written."""
        return "".join(part.capitalize() for part in self.name.split("_"))

    @property
    def allowed(self) -> Sentence:
        """The values that it takes, in words."""
        if self.type == CHOICE:
            return joined(self.choices)
        return self._bounds if self.type == FLOAT else Sentence("[r, g, b], each {bounds}", bounds=self._bounds)

    def check(self, value, where: str):
        """Return the value in canonical form (float, tuple of three floats, or str).

        Raises LaminaError naming `where`, the parameter, the value and what is allowed.
        """
        if self.type == CHOICE:
            if not isinstance(value, str) or value not in self.choices:
                raise LaminaError("{where}: unknown {name} {value!r}; choose {allowed}", where=where, name=self.name, value=value, allowed=self.allowed)
            return value
        if self.type == FLOAT:
            return self._check_number(value, where, self.name)
        if not isinstance(value, (list, tuple)) or len(value) != 3:
            raise LaminaError("{where}: {name} must be three numbers [r, g, b], not {value!r}", where=where, name=self.name, value=value)
        return tuple(self._check_number(v, where, f"{self.name}[{i}]") for i, v in enumerate(value))

    def _check_number(self, value, where: str, name: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise LaminaError("{where}: {name} must be a number, not {value!r}; {allowed}", where=where, name=name, value=value, allowed=self._in_bounds)
        try:
            number = float(value)
        except OverflowError:
            number = float("inf")
        if not isfinite(number) or not self.minimum <= number <= self.maximum:
            shown = f"{number:g}" if isinstance(value, float) else str(value)[:24]
            raise LaminaError("{where}: {name} is {shown}; {allowed}", where=where, name=name, shown=shown, allowed=self._in_bounds)
        return number

    @property
    def _in_bounds(self) -> Sentence:
        return Sentence("choose {bounds}", bounds=self._bounds)

    @property
    def _bounds(self) -> Sentence:
        words = {"least": self.minimum, "most": self.maximum}
        if self.unit:
            return Sentence("{least:g} to {most:g} {unit}", unit=Sentence(self.unit), **words)
        return Sentence("{least:g} to {most:g}", **words)


class _WithAlternatives:
    """What may have groups of parameters of which a stack gives exactly one group."""

    parameters: tuple[Parameter, ...]
    alternatives: tuple[tuple[str, ...], ...]

    @property
    def given_choices(self) -> tuple[str, ...]:
        """Names of the alternatives, such as "metal" and "eta+k"."""
        return tuple("+".join(group) for group in self.alternatives)

    def given_label(self, choice: str) -> str:
        """What an alternative gives, in words: "IOR and Extinction"."""
        return " and ".join(p.label for name in choice.split("+") for p in self.parameters if p.name == name)

    def given_by(self, choice: str) -> tuple[Parameter, ...]:
        """The parameters of what is given by a choice: that alternative's first, then those that belong to none."""
        either = {name for group in self.alternatives for name in group}
        chosen = (p for name in choice.split("+") for p in self.parameters if p.name == name)
        return (*chosen, *(p for p in self.parameters if p.name not in either))

    def not_given_by(self, choice: str) -> tuple[Parameter, ...]:
        """The parameters of the other alternatives."""
        given = self.given_by(choice)
        return tuple(p for p in self.parameters if p not in given)


@dataclass(frozen=True, eq=False)
class Feature(_WithAlternatives):
    """Something that a layer or base may have: it has it where a stack gives any of the feature's parameters.

    It is structure: it changes the generated shader's text, and what lacks it pays nothing for it. `alternatives` are as a kind's.
    """

    name: str
    label: str
    help: str
    parameters: tuple[Parameter, ...]
    alternatives: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Kind(_WithAlternatives):
    """A kind of layer or base: its own parameters, and those of its optional features, in socket order.

    Node interfaces are append-only: new parameters go to the end, and nodes keep the order in which they got them.
    `alternatives` names groups of parameters of which a stack gives exactly one group.
    """

    name: str
    label: str
    help: str
    parameters: tuple[Parameter, ...]
    alternatives: tuple[tuple[str, ...], ...] = ()
    features: tuple[Feature, ...] = ()

    @cached_property
    def all_parameters(self) -> tuple[Parameter, ...]:
        """The kind's parameters, then those of its features."""
        return (*self.parameters, *(p for feature in self.features for p in feature.parameters))

    def parameter(self, name: str) -> Parameter:
        """The parameter of a name, which must be the kind's own or a feature's."""
        return next(p for p in self.all_parameters if p.name == name)

    @cached_property
    def sockets(self) -> tuple[Parameter, ...]:
        """The parameters whose values live in node sockets."""
        return tuple(p for p in self.all_parameters if not p.is_structural)

    @cached_property
    def structure(self) -> tuple[Parameter, ...]:
        """The parameters that change the generated shader's text."""
        return tuple(p for p in self.parameters if p.is_structural)


@dataclass(frozen=True)
class Schema:
    """The kinds of layers and of bases, by name. A layer of a base's kind is opaque: it hides what is below."""

    layers: Mapping[str, Kind]
    bases: Mapping[str, Kind]

    def is_opaque(self, kind: str) -> bool:
        """Whether a layer of a kind hides what is below."""
        return kind in self.bases

    def layer(self, kind, where: str) -> Kind:
        """The kind of a layer. Raises LaminaError on an unknown one, naming `where` and the choices."""
        return _pick(self.layers, kind, where, "layer kind")

    def base(self, kind, where: str) -> Kind:
        """The kind of a base. Raises LaminaError on an unknown one, naming `where` and the choices."""
        return _pick(self.bases, kind, where, "base kind")


def _pick(kinds: Mapping[str, Kind], kind, where: str, what: str) -> Kind:
    if not isinstance(kind, str) or kind not in kinds:
        raise LaminaError("{where}: unknown {what} {kind!r}; choose {choices}", where=where, what=what, kind=kind, choices=", ".join(kinds))
    return kinds[kind]


METALS = (
    "aluminium",
    "brass",
    "chromium",
    "copper",
    "gold",
    "iron",
    "nickel",
    "platinum",
    "silver",
    "titanium",
    "tungsten",
)

_ROUGHNESS = Parameter(
    "roughness",
    FLOAT,
    0.0,
    "Roughness",
    "Square root of the microfacet distribution's alpha; 0 is perfectly smooth",
    look="How blurred reflections are: 0 is a mirror, 0.1 polished, 0.3 satin, 0.6 matt",
)
_DISTRIBUTION = Parameter(
    "distribution",
    CHOICE,
    "ggx",
    "Distribution",
    "Statistics of the microfacets: GGX has long tails, Beckmann is a Gaussian of slopes",
    choices=("ggx", "beckmann"),
    look="How highlights end: GGX in a wide soft glow, Beckmann sooner",
)
ROTATION = Parameter(
    "rotation",
    FLOAT,
    0.0,
    "Rotation",
    "Turns the tangent about the normal; 1 is a full turn",
    unit="turns",
    look="Turns the stretched highlights; 1 is a full turn",
)
ANISOTROPY = Feature(
    "anisotropy",
    "Anisotropy",
    "Facets that are rougher along one direction of the surface, as brushing leaves them",
    (
        Parameter(
            "anisotropy",
            FLOAT,
            0.0,
            "Anisotropy",
            "How much rougher along the tangent than across: the alphas' ratio is 1 - 0.9 anisotropy",
            look="Stretches highlights along one direction: 0 is even, 0.7 strongly brushed",
        ),
        ROTATION,
    ),
)
THIN_FILM = Feature(
    "thin_film",
    "Thin Film",
    "A film on the interface, so thin that light interferes in it",
    (
        Parameter(
            "film_thickness",
            FLOAT,
            0.0,
            "Film Thickness",
            "Thickness of the film; 0 is no film",
            maximum=2000.0,
            soft_maximum=1000.0,
            unit="nm",
            look="Colors that change with the angle, as on soap or oil: 0 is no film, 200 to 600 are the most colorful",
        ),
        Parameter(
            "film_ior",
            FLOAT,
            1.33,
            "Film IOR",
            "Absolute index of refraction of the film",
            minimum=1.0,
            maximum=4.0,
            look="How strong the film's colors are: water 1.33, oil 1.45, oxides of metals 2 and more",
        ),
    ),
)
COVERAGE = Feature(
    "coverage",
    "Coverage",
    "A layer that is only on part of the surface, in patches smaller than a pixel",
    (
        Parameter(
            "coverage",
            FLOAT,
            1.0,
            "Coverage",
            "Share of the surface that has the layer: link a mask; where it is 0 the layer is gone, its medium too",
            look="How much of the surface has the layer: 1 is all of it; give it a mask for dirt, wear and patches",
        ),
    ),
)
NORMAL = Feature(
    "normal",
    "Normal",
    "A normal of its own, such as a normal map or bumps give",
    (
        Parameter(
            "normal",
            VECTOR,
            (0.0, 0.0, 0.0),
            "Normal",
            "Normal in world space to link; zero is the surface's own. The reference models ignore it",
            minimum=-1.0,
            maximum=1.0,
            look="Bumps of this layer alone: link a Normal Map or a Bump node",
        ),
    ),
)

SCATTERING = Feature(
    "scattering",
    "Scattering",
    "A cloudy medium, such as milk glass, paint or dust",
    (
        Parameter(
            "scatter_g",
            FLOAT,
            0.0,
            "Forwardness",
            "Mean cosine of the scattering angle: above 0 light goes on, below 0 back",
            minimum=-0.99,
            maximum=0.99,
            look="Where the cloudy medium sends light: 0 everywhere, above 0 onward as milk and dust do, below 0 back",
        ),
        Parameter(
            "scatter_color",
            COLOR,
            (0.8, 0.8, 0.8),
            "Scatter Color",
            "Color of a very thick layer, without interface and tint; 1 absorbs nothing",
            look="Color of the cloudy medium where the layer hides what is below",
        ),
        Parameter(
            "density",
            FLOAT,
            1.0,
            "Density",
            "Optical depth of the scattering medium per unit of thickness; 0 is a clear one",
            maximum=1000.0,
            soft_maximum=10.0,
            look="How cloudy the layer is at thickness 1: 0 is clear, 1 a veil, 10 hides nearly all that is below",
        ),
        Parameter(
            "extinction",
            VECTOR,
            (1.0, 1.0, 1.0),
            "Scatter Extinction",
            "Optical depth per unit of thickness, scattering and absorption together, RGB; the tint's comes on top",
            maximum=1000.0,
            soft_maximum=10.0,
            look="How soon the cloudy medium stops red, green and blue light: 0 is clear, 10 hides nearly all that is below",
        ),
        Parameter(
            "scatter_albedo",
            COLOR,
            (0.9, 0.9, 0.9),
            "Scattered Share",
            "Single-scattering albedo: share of the extinction that is scattered; 1 absorbs nothing",
            look="How bright the cloudy medium is: 1 loses no light, 0.9 is clearly darker",
        ),
    ),
    alternatives=(("scatter_color", "density"), ("extinction", "scatter_albedo")),
)

_COLOR = Parameter(
    "color",
    COLOR,
    (0.8, 0.8, 0.8),
    "Color",
    "Share of light that the opaque base reflects, linear RGB",
    look="Color of the surface in white light; real ones lie between 0.03, soot, and 0.9, fresh snow",
)

DIELECTRIC = Kind(
    "dielectric",
    "Dielectric",
    "A clear or tinted medium below a smooth or rough interface",
    (
        Parameter(
            "ior",
            FLOAT,
            1.5,
            "IOR",
            "Absolute index of refraction of the medium below the interface",
            minimum=1.0,
            maximum=4.0,
            soft_maximum=2.5,
            look="How strongly the layer reflects: water 1.33, varnish and plastic 1.5, diamond 2.42",
        ),
        _ROUGHNESS,
        Parameter(
            "tint",
            COLOR,
            (1.0, 1.0, 1.0),
            "Tint",
            "Color left of white light after one perpendicular crossing of unit thickness",
            look="Color of the layer's body at thickness 1, crossed once: what shows has crossed twice and is deeper",
        ),
        Parameter(
            "thickness",
            FLOAT,
            1.0,
            "Thickness",
            "Thickness of the medium, in units of the tint's crossing",
            maximum=1000.0,
            soft_maximum=2.0,
            look="How deep the tint becomes: 0 is clear, 1 the tint itself, 2 the tint twice over",
        ),
        _DISTRIBUTION,
    ),
    features=(COVERAGE, ANISOTROPY, THIN_FILM, NORMAL, SCATTERING),
)
LAMBERT = Kind("lambert", "Lambert", "An ideally diffuse, opaque base", (_COLOR,), features=(NORMAL,))
OREN_NAYAR = Kind(
    "oren_nayar",
    "Oren-Nayar",
    "A rough diffuse, opaque base that scatters back to the light",
    (
        _COLOR,
        Parameter(
            "sigma_deg",
            FLOAT,
            20.0,
            "Slope Deviation",
            "Standard deviation of the facets' inclination (Oren and Nayar 1994)",
            maximum=90.0,
            unit="degrees",
            look="How flat and dusty the surface looks: 0 is smooth paper, 20 clay, 40 dust",
        ),
    ),
    features=(NORMAL,),
)
CONDUCTOR = Kind(
    "conductor",
    "Conductor",
    "A metal: named, or given by its complex index, or by reflectance and edge color",
    (
        Parameter(
            "eta",
            VECTOR,
            (0.2, 0.92, 1.1),
            "IOR",
            "Real part n of the absolute complex index, per RGB channel",
            minimum=0.01,
            maximum=20.0,
            soft_maximum=5.0,
            look="First half of the metal's index, for red, green and blue: most metals lie between 0.1 and 3",
        ),
        Parameter(
            "k",
            VECTOR,
            (3.9, 2.45, 2.14),
            "Extinction",
            "Imaginary part k of the absolute complex index, per RGB channel",
            maximum=20.0,
            soft_maximum=10.0,
            look="Second half of the metal's index: more is brighter; most metals lie between 2 and 8",
        ),
        Parameter(
            "reflectance",
            COLOR,
            (0.9, 0.7, 0.5),
            "Reflectance",
            "Reflectance of the metal at normal incidence in air",
            maximum=0.999,
            look="Color of the metal seen straight on: 0.5 is dark iron, 0.95 silver",
        ),
        Parameter(
            "edge_color",
            COLOR,
            (0.95, 0.9, 0.85),
            "Edge Color",
            "Edge tint g of Gulbrandsen 2014: 1 gives the smallest n that has the reflectance",
            look="Color of the metal at grazing angles; near white is usual",
        ),
        _ROUGHNESS,
        Parameter("metal", CHOICE, "aluminium", "Metal", "Metal whose measured index is used", choices=METALS, look="Metal whose measured color is used"),
        _DISTRIBUTION,
    ),
    alternatives=(("metal",), ("eta", "k"), ("reflectance", "edge_color")),
    features=(ANISOTROPY, THIN_FILM, NORMAL),
)

_BASES = (LAMBERT, OREN_NAYAR, CONDUCTOR)

SCHEMA = Schema(
    layers=MappingProxyType({k.name: k for k in (DIELECTRIC, *(replace(kind, features=(COVERAGE, *kind.features)) for kind in _BASES))}),
    bases=MappingProxyType({k.name: k for k in _BASES}),
)
