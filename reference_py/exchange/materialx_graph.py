# SPDX-License-Identifier: GPL-3.0-or-later
"""What an input of a MaterialX node is: numbers, followed through graphs of constants, or an image, or neither.

Colors come out as linear Rec.709, by the color space of the nearest element that names one; outside the gamut they are
negative. Nodes that are followed: `FUNCTIONS`, and those that pass one input on.
"""

from dataclasses import dataclass, replace
from math import isfinite
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import LaminaError, Sentence
from ..optics.colour import is_known, to_linear_rec709
from .materialx_document import LINKS, Document
from .materialx_functions import FUNCTIONS, ONE, OUTPUTS, ZERO, placed
from .materialx_image import Image, lying, made_of

_COUNTS = {"float": 1, "integer": 1, "boolean": 1, "vector2": 2, "vector3": 3, "vector4": 4, "color3": 3, "color4": 4}
_IMAGES = ("image", "tiledimage", "hextiledimage", "gltf_image", "gltf_colorimage", "UsdUVTexture")
_NORMALS = {"normalmap": "in", "gltf_normalmap": "file", "hextilednormalmap": "file"}
_PASSED = {"constant": "value", "dot": "in", "convert": "in", "gltf_texture_factor": "in"}
# One way through a graph, and all of them: each image follows its placement at several places.
_MOST_STEPS, _MOST_IN_ALL = 200, 4000
_CIRCLE = Sentence("its graph is too large, or runs in a circle")
# Nodes that give uv, of which Blender takes those that are active.
_COORDINATES = ("texcoord", "geompropvalue", "UsdPrimvarReader")
_CHANNELS = {f"{before}{letter}": index for before in ("", "out") for letters in ("rgba", "xyzw") for index, letter in enumerate(letters)}


@dataclass(frozen=True)
class Unread:
    """An input that is neither, and why."""

    why: Sentence


class Absent(Unread):
    """An input that says nothing: without a value, or a frame of the surface's own."""


class _Neither(Exception):
    def __init__(self, why: Sentence):
        super().__init__(why)
        self.why = why


class _NoValue(_Neither):
    """Of an input without one; `frame` names the surface's own frame that it is then."""

    def __init__(self, frame: str):
        super().__init__(Sentence("is computed by {kind}", kind=frame) if frame else Sentence("is a {kind} without a value", kind="number"))
        self.frame = frame


class Graph:
    """Follows inputs of one file. `unknown` are the names of color spaces that were met and not known: read as linear Rec.709.

    `notes` are what the last value that was asked for is not quite, `unit` that of its numbers, where the file says one.
    """

    def __init__(self, document: Document):
        self._document = document
        self.unknown: set[str] = set()
        self.unit = ""
        self.notes: list[Sentence] = []
        self._steps = self._all_steps = 0
        self._uv: np.ndarray | None = None

    def value(self, element: Element) -> np.ndarray | Image | Unread:
        """Of an input; also of an output, or a node with a value of its own."""
        self._steps, self._all_steps, self.notes = 0, 0, []
        try:
            self.unit = ""
            return self._followed(element)
        except _NoValue as nothing:
            return Absent(nothing.why)
        except _Neither as neither:
            return Unread(neither.why)

    def node(self, element: Element) -> tuple[Element, str] | None:
        """The node that an input is linked to, through outputs of graphs, and the name of the node's output; None without one."""
        try:
            return self._linked(element, 0)
        except _Neither:  # a circle
            return None

    def _linked(self, element: Element, depth: int) -> tuple[Element, str] | None:
        """`node`, which raises _Neither for a circle."""
        if depth > _MOST_STEPS:
            raise _Neither(_CIRCLE)
        document, depth = self._document, depth + 1
        scope = document.parent(element) if element.tag == "output" else document.parent(document.parent(element))
        if name := element.get("nodegraph"):
            graph = document.named(name, scope)
            return None if graph is None else self._output(graph, element.get("output", ""), depth)
        if name := element.get("nodename"):
            node = document.named(name, scope)
            if node is not None and node.tag == "nodegraph":
                return self._output(node, element.get("output", ""), depth)
            return None if node is None else (node, element.get("output", ""))
        if element.get("interfacename"):
            given = document.interface(element)
            return None if given is None else self._linked(given, depth)
        if name := element.get("output"):
            return self._output(document.root, name, depth)
        return None

    def output(self, graph: Element, name: str) -> tuple[Element, str] | None:
        """The node that an output of a graph is linked to, the first one without a name, and the name of the node's output."""
        try:
            return self._output(graph, name, 0)
        except _Neither:
            return None

    def _output(self, graph: Element, name: str, depth: int) -> tuple[Element, str] | None:
        outputs = [child for child in graph if child.tag == "output"]
        output = next((o for o in outputs if o.get("name") == name), outputs[0] if outputs and not name else None)
        return None if output is None else self._linked(output, depth)

    def _step(self) -> None:
        self._steps += 1
        self._all_steps += 1
        if self._steps > _MOST_STEPS or self._all_steps > _MOST_IN_ALL:
            raise _Neither(_CIRCLE)

    def _followed(self, element: Element) -> np.ndarray | Image:
        self._step()
        if element.get("interfacename"):
            given = self._document.interface(element)
            if given is not None:
                return self._followed(given)
        if any(element.get(key) for key in LINKS):
            found = self._linked(element, 0)
            if found is None:
                name = next(element.get(k) for k in LINKS if element.get(k))[:60]
                raise _Neither(Sentence("is linked to {name}, which is not in the file", name=name))
            result = self._of_node(*found)
            return self._swizzled(result, element.get("channels", ""), element.get("type", "")) if element.get("channels") else result
        if not element.get("value", "").strip() and element.get("type", "") in ("", *_COUNTS):
            return self._without_value(element.get("defaultgeomprop", ""))
        return self.own_value(element)

    def _without_value(self, property_: str) -> np.ndarray:
        """Of an input that has none but what a mesh says: uv where an image is placed."""
        if not property_.startswith("UV"):
            raise _NoValue(property_)
        if self._uv is None:
            raise _Neither(Sentence("is computed by {kind}", kind="texcoord"))
        return self._uv

    def own_value(self, element: Element) -> np.ndarray:
        """The numbers that an element holds. Raises LaminaError for what is none."""
        kind, text = element.get("type", ""), element.get("value", "")
        self.unit = element.get("unit", self.unit)
        where = f"{self._document.where}: {element.get('name', '')}"
        count = _COUNTS.get(kind)
        if count is None:
            raise _Neither(Sentence("has the type {kind}", kind=kind or "none"))
        if kind == "boolean":
            return np.full(1, float(text.strip().lower() == "true"))
        try:
            numbers = np.array([float(part) for part in text.split(",")])
        except ValueError:
            numbers = np.zeros(0)
        if len(numbers) != count or not all(map(isfinite, numbers)):
            raise LaminaError(
                "{where} is {text!r}; choose {wanted}", where=where, text=text[:40], wanted=("one number", "two", "three numbers", "four numbers")[count - 1]
            )
        return self._linear(element, numbers) if kind.startswith("color") else numbers

    def _linear(self, element: Element, numbers: np.ndarray) -> np.ndarray:
        space = self._document.nearest(element, "colorspace")
        if not is_known(space):
            self.unknown.add(space)
            return numbers
        return np.concatenate([to_linear_rec709(numbers[:3], space), numbers[3:]])

    def _of_node(self, node: Element, output: str) -> np.ndarray | Image:
        kind = node.tag
        if kind in _COORDINATES and self._uv is not None and node.get("type", "") in ("vector2", "float2"):
            return self._uv
        if kind == "geompropvalue" and (default := self._optional(node, "default")) is not None:
            self.notes.append(Sentence("is computed by {kind}; the value that the file has for where there is none stands in", kind=kind))
            return default
        if kind in _IMAGES:
            return self._image(node, output)
        if kind in _NORMALS:
            return self._normal(node)
        if kind in _PASSED:
            result = self._optional(node, _PASSED[kind])
            if result is None:
                raise _Neither(Sentence("is a {kind} without a value", kind=kind))
            if kind == "gltf_texture_factor":
                return self._computed(node, "multiply", {"in1": "in", "in2": "factor"})
            return result if isinstance(result, Image) else _as_type(result, node.get("type", ""))
        if kind.startswith("separate"):
            return self._channel(self._optional(node, "in"), _CHANNELS.get(output, 0))
        if kind == "swizzle":
            given, wanted = self._optional(node, "in"), input_of(node, "channels")
            if given is None or wanted is None:
                raise _Neither(Sentence("is a channel of nothing"))
            return self._swizzled(given, wanted.get("value", ""), node.get("type", ""))
        if kind not in FUNCTIONS:
            with self._document.inside(node) as graph:
                found = None if graph is None else self.output(graph, output)
                if found is not None:
                    return self._of_node(*found)
            raise _Neither(Sentence("is computed by {kind}", kind=kind))
        result = self._computed(node, kind)
        if kind in OUTPUTS and not isinstance(result, Image):
            names = OUTPUTS[kind]
            return np.split(result, len(names))[names.index(output) if output in names else 0]
        return result

    def _computed(self, node: Element, kind: str, names: dict[str, str] | None = None) -> np.ndarray | Image:
        """Of a function of its inputs, `names` by which it knows them: numbers, or an image where they are affine in it."""
        followed: dict[str, np.ndarray | Image] = {}
        images: dict[Image, Image] = {}

        def at(values: np.ndarray) -> np.ndarray:
            def inputs(name: str, default: np.ndarray) -> np.ndarray:
                if name not in followed:
                    given = self._optional(node, (names or {}).get(name, name))
                    plain = self._uv if name == "texcoord" and self._uv is not None else default
                    followed[name] = plain if given is None else given
                found = followed[name]
                if not isinstance(found, Image):
                    return found
                images.setdefault(found.plain, found.plain)
                return found.at(values[: found.width])

            result = np.atleast_1d(FUNCTIONS[kind](inputs))
            return result if kind in OUTPUTS else _as_type(result, node.get("type", ""))

        probe = np.full(4, 0.5)
        try:
            result = at(probe)
            if not images:
                return result
            if len(images) == 1 and not next(iter(images)).is_normal:
                image = next(iter(images))
                made = made_of(image, at)
                if made is not None:
                    return made
        except ValueError:  # numbers of channels that do not fit
            pass
        if not images:
            raise _Neither(Sentence("is computed by {kind}", kind=kind))
        first, second = followed.get("in1"), followed.get("in2")
        if kind == "multiply" and isinstance(first, Image) and isinstance(second, Image) and not (first.is_normal or second.is_normal):
            kept, other = (second, first) if first.width == 1 < second.width else (first, second)
            self.notes.append(Sentence("the image {file} multiplies it too, which is left out", file=other.file))
            return kept
        raise _Neither(Sentence("is computed from the image {file}", file=next(iter(images)).file))

    def _normal(self, node: Element) -> Image:
        kind = node.tag
        image = self._image(node, "") if _NORMALS[kind] == "file" else self._optional(node, _NORMALS[kind])
        if not isinstance(image, Image):
            raise _Neither(Sentence("is a {kind} without an image", kind=kind))
        scale = self._optional(node, "scale" if kind == "normalmap" else "normal_scale" if kind == "hextilednormalmap" else "")
        strength = float(scale[0]) if isinstance(scale, np.ndarray) else 1.0
        return as_normal(image, strength)

    def _swizzled(self, found: np.ndarray | Image, channels: str, kind: str) -> np.ndarray | Image:
        """Channels by their letters, 0 and 1; of an image one, or all as they are."""
        if isinstance(found, Image):
            if channels in ("rgb", "xyz", "rgba", "xyzw") and found.channel is None:
                return found
            if len(set(channels)) == 1 and channels[0] in _CHANNELS:
                return found.of_channel(_CHANNELS[channels[0]])
            raise _Neither(Sentence("is computed from the image {file}", file=found.file))
        known = {**{name: found[min(index, len(found) - 1)] for name, index in _CHANNELS.items()}, "0": 0.0, "1": 1.0}
        if not channels or any(letter not in known for letter in channels):
            raise _Neither(Sentence("is a channel of nothing"))
        return _as_type(np.array([known[letter] for letter in channels]), kind)

    def _optional(self, node: Element, name: str) -> np.ndarray | Image | None:
        """An input of a node; None where it has none of the name, or one without a value."""
        given = input_of(node, name)
        try:
            return None if given is None else self._followed(given)
        except _NoValue as nothing:
            if nothing.frame:
                raise _Neither(nothing.why) from None
            return None

    def _channel(self, found: np.ndarray | Image | None, index: int) -> np.ndarray | Image:
        if found is None:
            raise _Neither(Sentence("is a channel of nothing"))
        return found.of_channel(index) if isinstance(found, Image) else found[min(index, len(found) - 1)][None]

    def _image(self, node: Element, output: str) -> Image:
        file = input_of(node, "file")
        while file is not None and file.get("interfacename"):
            self._step()
            file = self._document.interface(file)
        if file is None or not file.get("value"):
            raise _Neither(Sentence("is an image without a file"))
        kind, is_usd, is_gltf = node.get("type", ""), node.tag == "UsdUVTexture", node.tag == "gltf_colorimage"
        is_color = kind.startswith("color") or (is_usd and output in ("", "rgb", "rgba")) or is_gltf
        channel = _CHANNELS.get(output) if is_usd else 3 if is_gltf and output == "outa" else None
        space = self._document.nearest(file, "colorspace") if is_color else file.get("colorspace", "")
        name = file.get("value", "").replace("\\", "/")
        if not name.startswith("/") and name[1:2] != ":":
            name = self._document.prefixed(file, "fileprefix") + name
        count = (4 if output == "rgba" else 3) if is_usd or is_gltf else _COUNTS.get(kind, 3)
        tiling, turn, shift = self._placement(node)
        image = Image(name, space, False, tiling, None, turn, shift, count=count)
        default = self._optional(node, "fallback" if is_usd else "default")
        if isinstance(default, np.ndarray):
            image = replace(image, default=tuple(map(float, default)))
        if node.tag in ("gltf_image", "gltf_colorimage", "UsdUVTexture"):
            more = self._optional(node, "scale" if is_usd else "color" if is_gltf else "factor"), self._optional(node, "bias") if is_usd else None
            scale, offset = (value if isinstance(value, np.ndarray) else default for value, default in zip(more, (ONE, ZERO)))
            image = replace(image, scale=tuple(map(float, scale)), offset=tuple(map(float, offset)))
        return image if channel is None else image.of_channel(channel)

    def _placement(self, node: Element) -> tuple[tuple[float, float], float, tuple[float, float]]:
        """Tiling, turn and shift of an image's node; where its coordinates are others, `notes` say so."""
        given = next((name for name in ("texcoord", "st") if input_of(node, name) is not None), "")

        def numbers(name: str, default: tuple[float, float]) -> np.ndarray:
            found = self._optional(node, name)
            return np.broadcast_to(found, 2) if isinstance(found, np.ndarray) else np.array(default)

        def at(uv: np.ndarray) -> np.ndarray:
            self._uv, self._steps = uv, steps
            found = uv if (linked := self._optional(node, given)) is None else linked
            if isinstance(found, Image):
                raise _Neither(Sentence("is computed from the image {file}", file=found.file))
            if node.tag in ("tiledimage", "hextiledimage", "hextilednormalmap"):
                found = found * numbers("uvtiling" if node.tag == "tiledimage" else "tiling", (1, 1)) - numbers("uvoffset", (0, 0))
                return found / numbers("realworldimagesize", (1, 1)) * numbers("realworldtilesize", (1, 1))
            if node.tag.startswith("gltf_"):
                size, shift = numbers("scale", (1, 1)), numbers("offset", (0, 0))
                back = 1.0 / np.where(size == 0.0, 1.0, size)
                return placed(found, numbers("pivot", (0, 1)), back, -float(numbers("rotate", (0, 0))[0]), shift * (-1.0, 1.0), False)
            return found

        steps, former, self._uv = self._steps, self._uv, None
        try:
            why, found = Sentence("is bent"), lying(at)
        except _Neither as neither:
            why, found = neither.why, None
        finally:
            self._uv, self._steps = former, steps
        if found is None:
            self.notes.append(Sentence("the place of its image {why}: it lies on the plain UVs", why=why))
        return found or ((1.0, 1.0), 0.0, (0.0, 0.0))


def as_normal(image: Image, strength: float = 1.0) -> Image:
    """An image that holds normals in tangent space."""
    return replace(image, space="", is_normal=True, channel=None, scale=(1.0,), offset=(0.0,), strength=strength)


def input_of(node: Element, name: str) -> Element | None:
    """The input of a node by name; None without one."""
    return next((child for child in node if child.tag == "input" and child.get("name") == name), None)


def _as_type(numbers: np.ndarray, kind: str) -> np.ndarray:
    """Numbers of another count: one is repeated, those beyond are left out."""
    count = _COUNTS.get(kind, len(numbers))
    if len(numbers) == 1:
        return np.repeat(numbers, count)
    return np.concatenate([numbers, np.ones(max(count - len(numbers), 0))])[:count]
