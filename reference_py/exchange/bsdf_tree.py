# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs of MaterialX's BSDF nodes as trees: leaves that scatter light, and what puts them together.

Inputs and defaults are those of the node definitions of MaterialX 1.39. A leaf's roughness is (alpha_x, alpha_y).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.schema import DIELECTRIC as SCHEMA_DIELECTRIC
from ..optics.microfacet import GGX
from .materialx_document import Document
from .materialx_graph import Absent, Graph, Unread, input_of
from .materialx_image import Image
from .report import APPROXIMATED, LOST, Loss, shown

SURFACE = "surface"
"""The node that makes a surface of a BSDF."""
DISTRIBUTION = "lamina_distribution"
DIELECTRIC, CONDUCTOR, SCHLICK = "dielectric_bsdf", "conductor_bsdf", "generalized_schlick_bsdf"
OREN_NAYAR, BURLEY, SUBSURFACE, SHEEN, TRANSLUCENT = "oren_nayar_diffuse_bsdf", "burley_diffuse_bsdf", "subsurface_bsdf", "sheen_bsdf", "translucent_bsdf"
_WHITE, _FILM = (1.0, 1.0, 1.0), {"thinfilm_thickness": 0.0, "thinfilm_ior": 1.5}
_SMOOTH = (0.05, 0.05)
DEFAULTS: dict[str, dict] = {
    DIELECTRIC: {"weight": 1.0, "tint": _WHITE, "ior": 1.5, "roughness": _SMOOTH, **_FILM},
    CONDUCTOR: {"weight": 1.0, "ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770), "roughness": _SMOOTH, **_FILM},
    SCHLICK: {"weight": 1.0, "color0": _WHITE, "color82": _WHITE, "color90": _WHITE, "exponent": 5.0, "roughness": _SMOOTH, **_FILM},
    OREN_NAYAR: {"weight": 1.0, "color": (0.18,) * 3, "roughness": 0.0, "energy_compensation": 0.0},
    BURLEY: {"weight": 1.0, "color": (0.18,) * 3, "roughness": 0.0},
    SUBSURFACE: {"weight": 1.0, "color": (0.18,) * 3, "radius": _WHITE, "anisotropy": 0.0},
    TRANSLUCENT: {"weight": 1.0, "color": _WHITE},
    SHEEN: {"weight": 1.0, "color": _WHITE, "roughness": 0.3},
}
# Inputs that are limited, and to what; all others are shares.
_LIMITS = {"ior": (0.0, 100.0), "extinction": (0.0, 100.0), "thinfilm_ior": (1.0, 100.0), "thinfilm_thickness": (0.0, 1e9), "exponent": (0.0, 100.0)}
_LIMITS |= {"radius": (0.0, 1e9), "anisotropy": (-1.0, 1.0)}
# Inputs that change nothing of the amount of light.
_WORDS = ("distribution", "mode")
_ROUGH = ("roughness_anisotropy", "glossiness_anisotropy")
_EMITTING = {"multiply": ("in1",), "generalized_schlick_edf": ("base",), "layer": ("base",), "add": ("in1", "in2"), "mix": ("bg", "fg")}
_MOST_NODES = 200
_EVEN = 0.5


@dataclass(frozen=True)
class Leaf:
    """One BSDF by its node's kind and name. `values` are complete; `mode` of a dielectric is R, T or RT; `turn` of the tangent is in turns.

    `images` feed inputs; one of "roughness" holds a roughness, whose square alpha is.
    """

    kind: str
    name: str
    values: Mapping
    mode: str = "R"
    turn: float = 0.0
    images: Mapping = field(default_factory=dict)
    distribution: str = GGX
    """Of facets. MaterialX has one; others are an attribute of the node, which its renderers pass over."""

    @property
    def alpha(self) -> float:
        """That of the isotropic surface that stands for it, of as much variance of slopes."""
        return float(np.sqrt(np.mean(np.square(self.values["roughness"]))))


@dataclass(frozen=True)
class Layered:
    """One over the other."""

    top: "Tree"
    base: "Tree"


@dataclass(frozen=True)
class Mixed:
    """`share` of the second, the rest of the first; `image` says where."""

    first: "Tree"
    second: "Tree"
    share: float
    image: Image | None = None
    name: str = "mix"


@dataclass(frozen=True)
class Added:
    """The sum of both."""

    first: "Tree"
    second: "Tree"


@dataclass(frozen=True)
class Scaled:
    """One times a color (3,); `medium`, where the color is a power of a constant, is that and the exponent."""

    bsdf: "Tree"
    color: tuple
    medium: tuple[tuple, float] | None = None


Tree = Leaf | Layered | Mixed | Added | Scaled


class TreeReader:
    """Reads the tree below an input of a document. What reading costs is in `losses`."""

    def __init__(self, document: Document, folder: Path | None = None):
        """`folder`: what files of images are below."""
        self._document, self.graph, self._folder = document, Graph(document), folder
        self.losses: list[Loss] = []
        self._nodes = 0

    def tree(self, given: Element | None) -> Tree | None:
        """Of an input of type BSDF; None where nothing is linked. Raises LaminaError for nodes that are not known."""
        found = self.graph.node(given) if given is not None else None
        if found is None:
            return None
        self._nodes += 1
        if self._nodes > _MOST_NODES:
            raise LaminaError("{where}: its graph of BSDFs is too large, or runs in a circle", where=self._document.where)
        node, _ = found
        name, inputs = node.get("name", node.tag), {tag: input_of(node, tag) for tag in ("top", "base", "bg", "fg", "mix", "in1", "in2")}
        if node.tag == "layer":
            return self._layered(node, inputs)
        if node.tag == "mix":
            share, image = self._share(name, inputs["mix"])
            return self._joined(lambda a, b: Mixed(a, b, share, image, name), inputs["bg"], inputs["fg"], node)
        if node.tag == "add":
            return self._joined(Added, inputs["in1"], inputs["in2"], node)
        if node.tag == "multiply":
            scaled = self._required(inputs["in1"], node)
            return self._scaled(name, scaled, inputs["in2"])
        if node.tag not in DEFAULTS:
            raise LaminaError(
                "{where}: {name} is {tag}, which no stack has; known are layer, mix, add, multiply, {choices}",
                where=self._document.where,
                name=name,
                tag=node.tag,
                choices=", ".join(DEFAULTS),
            )
        return self._leaf(node)

    def emission(self, given: Element | None) -> np.ndarray:
        """Radiance (3,) of an input of type EDF, along the normal; what cannot be read counts as 1."""
        found = self.graph.node(given) if given is not None else None
        if found is None:
            return np.zeros(3)
        self._nodes += 1
        if self._nodes > _MOST_NODES:
            raise LaminaError("{where}: its graph of light is too large, or runs in a circle", where=self._document.where)
        node, _ = found
        if node.tag in ("multiply", "generalized_schlick_edf", "layer", "add", "mix"):
            inner = [self.emission(input_of(node, name)) for name in _EMITTING[node.tag]]
            if node.tag == "mix":
                share = self._number(input_of(node, "mix"), 0.0)
                return (1.0 - share) * inner[0] + share * inner[1]
            factor = {"multiply": "in2", "generalized_schlick_edf": "color0"}.get(node.tag)
            return sum(inner) * (self._number(input_of(node, factor), 1.0) if factor else 1.0)
        return np.broadcast_to(self._number(input_of(node, "color"), 1.0), 3)

    def value(self, where: str, given: Element) -> np.ndarray | Image | Unread:
        """Of an input; what it is not quite is in `losses`."""
        found = self.graph.value(given)
        self._note(where)
        return found

    def _note(self, where: str) -> None:
        self.losses += [Loss(where, Sentence("linked"), APPROXIMATED, note) for note in dict.fromkeys(self.graph.notes)]

    def _number(self, given: Element | None, default: float) -> np.ndarray:
        """(1,) or (3,) of an input, or the default."""
        value = self.graph.value(given) if given is not None else None
        return value[:3] if isinstance(value, np.ndarray) else np.full(1, default)

    def _required(self, given: Element | None, node: Element) -> Tree:
        found = self.tree(given)
        if found is None:
            raise LaminaError(
                "{where}: {name}, a {tag}, lacks the BSDF of one of its inputs", where=self._document.where, name=node.get("name", node.tag), tag=node.tag
            )
        return found

    def _joined(self, join, first: Element | None, second: Element | None, node: Element) -> Tree:
        """Of two, or, as an input that nothing is linked to is black, of black and one."""
        a, b = self.tree(first), self.tree(second)
        if a is None and b is None:
            raise LaminaError("{where}: {name}, a {tag}, has no BSDF", where=self._document.where, name=node.get("name", node.tag), tag=node.tag)
        return join(a or _BLACK, b or _BLACK)

    def _layered(self, node: Element, inputs: Mapping) -> Tree:
        below = self.graph.node(inputs["base"]) if inputs["base"] is not None else None
        top = self._required(inputs["top"], node)
        if below is not None and below[0].get("type") == "VDF":
            self._lose(f"{node.get('name')} base", below[0].tag, Sentence("a medium without a depth: only light that goes through it would show it"))
            return top
        base = self.tree(inputs["base"])
        return top if base is None else Layered(top, base)

    def _share(self, name: str, given: Element | None) -> tuple[float, Image | None]:
        found = self.value(f"{name} mix", given) if given is not None else np.zeros(1)
        if isinstance(found, Image):
            return _EVEN, self._placed(found)
        if isinstance(found, Absent):
            return 0.0, None
        if isinstance(found, Unread):
            self._lose(f"{name} mix", Sentence("linked"), Sentence("{why}; an even mix stands in", why=found.why))
            return _EVEN, None
        return float(np.clip(found[0], 0.0, 1.0)), None

    def _scaled(self, name: str, scaled: Tree, given: Element | None) -> Tree:
        found = self.value(f"{name} in2", given) if given is not None else np.ones(1)
        if isinstance(found, Absent):
            return scaled
        if isinstance(found, (Image, Unread)):
            self._lose(
                f"{name} in2",
                Sentence("image {file}", file=found.file) if isinstance(found, Image) else Sentence("linked"),
                Sentence("a BSDF is scaled by a constant alone; it is left as it is"),
            )
            return scaled
        color = np.broadcast_to(found[:3] if len(found) > 1 else found, 3)
        kept = np.clip(color, 0.0, 1.0)
        if np.any(np.abs(kept - color) > 1e-6):
            self.losses.append(Loss(f"{name} in2", tuple(color), APPROXIMATED, Sentence("limited to {kept}", kept=shown(kept))))
        return Scaled(scaled, tuple(map(float, kept)), self._medium(given))

    def _medium(self, given: Element | None) -> tuple[tuple, float] | None:
        """Color and exponent of a power of constants."""
        found = self.graph.node(given) if given is not None else None
        if found is None or found[0].tag != "power":
            return None
        below, exponent = (self.graph.value(i) if (i := input_of(found[0], name)) is not None else None for name in ("in1", "in2"))
        if not isinstance(below, np.ndarray) or not isinstance(exponent, np.ndarray) or len(below) < 3:
            return None
        return tuple(map(float, np.clip(below[:3], 0.0, 1.0))), max(float(exponent[0]), 0.0)

    def _leaf(self, node: Element) -> Leaf:
        kind, name = node.tag, node.get("name", node.tag)
        values, images, mode, turn = dict(DEFAULTS[kind]), {}, "R", 0.0
        for given in node:
            parameter = given.get("name", "")
            if given.tag != "input" or parameter in _WORDS:
                continue
            if parameter == "scatter_mode":
                mode = given.get("value", "R")
            elif parameter == "tangent":
                turn = self._turn(given)
            elif parameter == "normal":
                if isinstance(image := self.value(f"{name} normal", given), Image):
                    images["normal"] = self._placed(image)
            elif parameter not in values:
                self._lose(f"{name} {parameter}", given.get("value", Sentence("linked")), Sentence("a stack has no place for it"))
            else:
                found = self._roughness(given) if parameter == "roughness" and kind in (DIELECTRIC, CONDUCTOR, SCHLICK) else self.graph.value(given)
                self._note(f"{name} {parameter}")
                if isinstance(found, Image):
                    images[parameter] = self._placed(found)
                elif isinstance(found, Unread) and not isinstance(found, Absent):
                    self._lose(
                        f"{name} {parameter}",
                        Sentence("linked"),
                        Sentence("{why}; its default, {value}, stands in", why=found.why, value=shown(values[parameter])),
                    )
                elif isinstance(found, np.ndarray):
                    values[parameter] = self._limited(f"{name} {parameter}", parameter, found, values[parameter])
        return Leaf(kind, name, values, mode, turn, images, self._distribution(node))

    def _roughness(self, given: Element) -> np.ndarray | Image | Unread:
        """Of a BSDF that has two: an image of the roughness that the usual node makes them of stays an image."""
        found = self.graph.node(given)
        if found is not None and found[0].tag == _ROUGH[0] and (rough := input_of(found[0], "roughness")) is not None:
            image = self.graph.value(rough)
            if isinstance(image, Image):
                return image
        value = self.graph.value(given)
        return Unread(Sentence("is an image of the square of a roughness")) if isinstance(value, Image) else value

    @staticmethod
    def _distribution(node: Element) -> str:
        given = node.get(DISTRIBUTION, GGX)
        return given if given in SCHEMA_DIELECTRIC.parameter("distribution").choices else GGX

    def _placed(self, image: Image) -> Image:
        return image if self._folder is None else replace(image, file=str(self._folder / image.file))

    def _turn(self, given: Element) -> float:
        """Turns of a tangent that `rotate3d` turns about the normal by a constant."""
        found = self.graph.node(given)
        if found is None or found[0].tag != "rotate3d" or (amount := input_of(found[0], "amount")) is None:
            return 0.0
        degrees = self.graph.value(amount)
        return float(degrees[0]) / 360.0 % 1.0 if isinstance(degrees, np.ndarray) else 0.0

    def _limited(self, where: str, parameter: str, found: np.ndarray, default):
        count = len(default) if isinstance(default, tuple) else 1
        value = np.broadcast_to(found[:count], count) if len(found) in (1, count, 4) else None
        if value is None:
            raise LaminaError(
                "{where}: {parameter} has {count} numbers; choose {wanted}", where=self._document.where, parameter=where, count=len(found), wanted=count
            )
        kept = within(parameter, value)
        if np.any(np.abs(kept - value) > 1e-6):
            self.losses.append(Loss(where, tuple(value), APPROXIMATED, Sentence("out of its range; limited to {kept}", kept=shown(kept))))
        return tuple(map(float, kept)) if isinstance(default, tuple) else float(kept[0])

    def _lose(self, where: str, value, why: Sentence) -> None:
        self.losses.append(Loss(where, value, LOST, why))


def within(given: str, value: np.ndarray) -> np.ndarray:
    """A leaf's value in the range of its input."""
    return np.clip(value, *_LIMITS.get(given, (0.0, 1.0)))


_BLACK = Leaf(OREN_NAYAR, "black", DEFAULTS[OREN_NAYAR] | {"color": (0.0, 0.0, 0.0)})


def every_part(tree: Tree) -> Iterator[Tree]:
    """The tree and all below it; what is linked twice is there as often."""
    yield tree
    for part in _parts(tree):
        yield from every_part(part)


def images_of(tree: Tree) -> dict[str, Image]:
    """By what they feed: the node's name and the input."""
    found = {}
    for part in every_part(tree):
        if isinstance(part, Leaf):
            found |= {f"{part.name} {given}": image for given, image in part.images.items()}
        elif isinstance(part, Mixed) and part.image is not None:
            found[f"{part.name} mix"] = part.image
    return found


def mapped(tree: Tree, change: Callable[[Tree], Tree]) -> Tree:
    """A copy with every part as `change` makes it, from the leaves on."""
    if isinstance(tree, Scaled):
        return change(replace(tree, bsdf=mapped(tree.bsdf, change)))
    if isinstance(tree, Layered):
        return change(Layered(mapped(tree.top, change), mapped(tree.base, change)))
    if isinstance(tree, (Mixed, Added)):
        return change(replace(tree, first=mapped(tree.first, change), second=mapped(tree.second, change)))
    return change(tree)


def without_nothing(part: Tree) -> Tree:
    """For `mapped`: a mix of all and none, and a factor of white, are what they leave."""
    if isinstance(part, Mixed) and part.image is None and part.share in (0.0, 1.0):
        return part.second if part.share else part.first
    return part.bsdf if isinstance(part, Scaled) and min(part.color) == 1.0 else part


def _parts(tree: Tree) -> tuple["Tree", ...]:
    if isinstance(tree, Leaf):
        return ()
    if isinstance(tree, Scaled):
        return (tree.bsdf,)
    return (tree.top, tree.base) if isinstance(tree, Layered) else (tree.first, tree.second)
