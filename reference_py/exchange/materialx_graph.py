# SPDX-License-Identifier: GPL-3.0-or-later
"""What an input of a MaterialX node is: numbers, followed through graphs of constants, or an image, or neither.

Colors come out as linear Rec.709, by the color space of the nearest element that names one; outside the gamut they are
negative. Nodes that are followed: `FUNCTIONS`, and those that pass one input on.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import LaminaError, Sentence
from ..optics.colour import artist_index, is_known, to_linear_rec709
from .materialx_document import Document

_COUNTS = {"float": 1, "integer": 1, "boolean": 1, "vector2": 2, "vector3": 3, "vector4": 4, "color3": 3, "color4": 4}
_LINKS = ("nodename", "nodegraph", "interfacename")
_IMAGES = ("image", "tiledimage", "hextiledimage", "gltf_image", "gltf_colorimage", "UsdUVTexture")
_NORMALS = {"normalmap": "in", "gltf_normalmap": "file", "hextilednormalmap": "file"}
_PASSED = {"constant": "value", "dot": "in", "convert": "in", "gltf_texture_factor": "in"}
_MOST_STEPS = 200
_ZERO, _ONE = np.zeros(1), np.ones(1)


@dataclass(frozen=True)
class Image:
    """An image of a file. `space` is its color space's name, empty for data; `tiling` how often it repeats along u and v."""

    file: str
    space: str
    is_normal: bool = False
    tiling: tuple[float, float] = (1.0, 1.0)
    channel: int | None = None
    """The one that is taken, 0 to 3; None for all."""


@dataclass(frozen=True)
class Unread:
    """An input that is neither, and why."""

    why: Sentence


def _mix(inputs) -> np.ndarray:
    bg, fg, share = inputs("bg", _ZERO), inputs("fg", _ZERO), inputs("mix", _ZERO)
    return bg + share * (fg - bg)


def _divided(inputs) -> np.ndarray:
    below = inputs("in2", _ONE)
    return inputs("in1", _ZERO) / np.where(below == 0.0, 1.0, below)


def _extract(inputs) -> np.ndarray:
    values, index = inputs("in", _ZERO), int(inputs("index", _ZERO)[0])
    return values[min(max(index, 0), len(values) - 1)][None]


def _widths(roughness: np.ndarray, inputs) -> np.ndarray:
    """alpha along and across, their product roughness^4."""
    alpha, aspect = roughness[0] ** 2, (1.0 - min(max(float(inputs("anisotropy", _ZERO)[0]), 0.0), 0.98)) ** 0.5
    return np.array([min(alpha / aspect, 1.0), alpha * aspect])


def _open_widths(inputs) -> np.ndarray:
    """alpha along and across, the mean of their squares roughness^4."""
    ratio = 1.0 - inputs("anisotropy", _ZERO)[0]
    along = inputs("roughness", _ZERO)[0] ** 2 * (2.0 / (1.0 + ratio**2)) ** 0.5
    return np.array([along, ratio * along])


def _dual(inputs) -> np.ndarray:
    both = inputs("roughness", np.zeros(2))[:2]
    return np.square(np.where(both < 0.0, both[0], both))


def _artistic(inputs) -> np.ndarray:
    """Index and extinction, one after the other."""
    reflectance = np.clip(inputs("reflectivity", np.array([0.944, 0.776, 0.373])), 0.0, 0.999)
    return np.concatenate(artist_index(reflectance, np.clip(inputs("edge_color", np.array([0.998, 0.981, 0.751])), 0.0, 1.0)))


def _if(holds: Callable) -> Callable:
    """The first of two where two values are so, else the second."""
    return lambda i: i("in1", _ZERO) if holds(i("value1", _ONE)[0], i("value2", _ZERO)[0]) else i("in2", _ZERO)


FUNCTIONS: dict[str, Callable] = {
    "add": lambda i: i("in1", _ZERO) + i("in2", _ZERO), "subtract": lambda i: i("in1", _ZERO) - i("in2", _ZERO),
    "multiply": lambda i: i("in1", _ZERO) * i("in2", _ONE), "divide": _divided, "mix": _mix,
    "power": lambda i: np.maximum(i("in1", _ZERO), 0.0) ** i("in2", _ONE),
    "min": lambda i: np.minimum(i("in1", _ZERO), i("in2", _ZERO)), "max": lambda i: np.maximum(i("in1", _ZERO), i("in2", _ZERO)),
    "clamp": lambda i: np.clip(i("in", _ZERO), i("low", _ZERO), i("high", _ONE)), "invert": lambda i: i("amount", _ONE) - i("in", _ZERO),
    "sqrt": lambda i: np.sqrt(np.maximum(i("in", _ZERO), 0.0)), "absval": lambda i: np.abs(i("in", _ZERO)), "extract": _extract,
    "combine2": lambda i: np.concatenate([i(f"in{n}", _ZERO)[:1] for n in (1, 2)]),
    "combine3": lambda i: np.concatenate([i(f"in{n}", _ZERO)[:1] for n in (1, 2, 3)]),
    "ifgreater": _if(lambda a, b: a > b), "ifgreatereq": _if(lambda a, b: a >= b), "ifequal": _if(lambda a, b: a == b),
    "sign": lambda i: np.sign(i("in", _ZERO)), "floor": lambda i: np.floor(i("in", _ZERO)), "ceil": lambda i: np.ceil(i("in", _ZERO)),
    "roughness_anisotropy": lambda i: _widths(i("roughness", _ZERO), i), "glossiness_anisotropy": lambda i: _widths(1.0 - i("glossiness", _ONE), i),
    "open_pbr_anisotropy": _open_widths, "roughness_dual": _dual, "artistic_ior": _artistic,
    "luminance": lambda i: np.full(3, np.array([0.2126, 0.7152, 0.0722]) @ i("in", np.zeros(3))[:3]),
}  # fmt: skip


# Outputs of nodes that have several, whose numbers come one after the other.
_OUTPUTS = {"artistic_ior": ("ior", "extinction")}


class _Neither(Exception):
    def __init__(self, why: Sentence):
        super().__init__(why)
        self.why = why


class Graph:
    """Follows inputs of one file. `unknown` are the names of color spaces that were met and not known: read as linear Rec.709."""

    def __init__(self, document: Document):
        self._document = document
        self.unknown: set[str] = set()
        self._steps = 0

    def value(self, element: Element) -> np.ndarray | Image | Unread:
        """Of an input; also of an output, or a node with a value of its own."""
        self._steps = 0
        try:
            return self._followed(element)
        except _Neither as neither:
            return Unread(neither.why)

    def node(self, element: Element) -> tuple[Element, str] | None:
        """The node that an input is linked to, through outputs of graphs, and the name of the node's output; None without one."""
        document = self._document
        scope = document.parent(element) if element.tag == "output" else document.parent(document.parent(element))
        if name := element.get("nodegraph"):
            graph = document.named(name, scope)
            return None if graph is None else self._output(graph, element.get("output", ""))
        if name := element.get("nodename"):
            node = document.named(name, scope)
            if node is not None and node.tag == "nodegraph":
                return self._output(node, element.get("output", ""))
            return None if node is None else (node, element.get("output", ""))
        if name := element.get("interfacename"):
            given = next((i for i in scope if i.tag == "input" and i.get("name") == name), None)
            return None if given is None else self.node(given)
        if name := element.get("output"):
            return self._output(document.root, name)
        return None

    def _output(self, graph: Element, name: str) -> tuple[Element, str] | None:
        outputs = [child for child in graph if child.tag == "output"]
        output = next((o for o in outputs if o.get("name") == name), outputs[0] if outputs and not name else None)
        return None if output is None else self.node(output)

    def _followed(self, element: Element) -> np.ndarray | Image:
        self._steps += 1
        if self._steps > _MOST_STEPS:
            raise _Neither(Sentence("its graph is too large, or runs in a circle"))
        if element.get("interfacename"):
            scope = self._document.parent(self._document.parent(element))
            given = next((i for i in scope if i.tag == "input" and i.get("name") == element.get("interfacename")), None)
            if given is not None:
                return self._followed(given)
        if any(element.get(key) for key in (*_LINKS, "output")):
            found = self.node(element)
            if found is None:
                name = next(element.get(k) for k in (*_LINKS, "output") if element.get(k))[:60]
                raise _Neither(Sentence("is linked to {name}, which is not in the file", name=name))
            return self._of_node(*found)
        return self.own_value(element)

    def own_value(self, element: Element) -> np.ndarray:
        """The numbers that an element holds. Raises LaminaError for what is none."""
        kind, text = element.get("type", ""), element.get("value", "")
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
        if kind in _IMAGES:
            return self._image(node, output)
        if kind in _NORMALS:
            given = input_of(node, _NORMALS[kind])
            image = self._image(node, "") if _NORMALS[kind] == "file" else self._followed(given) if given is not None else None
            if isinstance(image, Image):
                return Image(image.file, "", True, image.tiling)
            raise _Neither(Sentence("is a {kind} without an image", kind=kind))
        if kind in _PASSED:
            given = input_of(node, _PASSED[kind])
            if given is None:
                raise _Neither(Sentence("is a {kind} without a value", kind=kind))
            result = self._followed(given)
            return result if isinstance(result, Image) else _as_type(result, node.get("type", ""))
        if kind.startswith("separate"):
            return self._channel(input_of(node, "in"), {"outr": 0, "outx": 0, "outg": 1, "outy": 1, "outb": 2, "outz": 2, "outa": 3, "outw": 3}.get(output, 0))
        if kind == "extract" and isinstance(given := self._optional(node, "in"), Image):
            index = self._optional(node, "index")
            return self._channel(input_of(node, "in"), int(index[0]) if isinstance(index, np.ndarray) else 0)
        if kind not in FUNCTIONS:
            raise _Neither(Sentence("is computed by {kind}", kind=kind))

        def inputs(name: str, default: np.ndarray) -> np.ndarray:
            given = input_of(node, name)
            if given is None:
                return default
            found = self._followed(given)
            if isinstance(found, Image):
                raise _Neither(Sentence("is computed from the image {file}", file=found.file))
            return found

        result = np.atleast_1d(FUNCTIONS[kind](inputs))
        if kind in _OUTPUTS:
            names = _OUTPUTS[kind]
            return np.split(result, len(names))[names.index(output) if output in names else 0]
        return _as_type(result, node.get("type", ""))

    def _optional(self, node: Element, name: str):
        given = input_of(node, name)
        return None if given is None else self._followed(given)

    def _channel(self, given: Element | None, index: int) -> np.ndarray | Image:
        if given is None:
            raise _Neither(Sentence("is a channel of nothing"))
        found = self._followed(given)
        if isinstance(found, Image):
            return Image(found.file, found.space, False, found.tiling, index)
        return found[min(index, len(found) - 1)][None]

    def _image(self, node: Element, output: str) -> Image:
        file = input_of(node, "file")
        if file is None or not file.get("value"):
            if file is not None and file.get("interfacename"):
                scope = self._document.parent(node)
                file = next((i for i in scope if i.tag == "input" and i.get("name") == file.get("interfacename")), None)
            if file is None or not file.get("value"):
                raise _Neither(Sentence("is an image without a file"))
        is_color = node.get("type", "").startswith("color") or node.tag == "UsdUVTexture" and output in ("", "rgb", "rgba")
        tiling = self._optional(node, "uvtiling")
        pair = tuple(float(t) for t in tiling) if isinstance(tiling, np.ndarray) and len(tiling) == 2 else (1.0, 1.0)
        channel = {"r": 0, "g": 1, "b": 2, "a": 3}.get(output) if node.tag == "UsdUVTexture" else None
        space = self._document.nearest(file, "colorspace") if is_color else file.get("colorspace", "")
        return Image(self._document.prefixed(node, "fileprefix") + file.get("value"), space, False, pair, channel)


def input_of(node: Element, name: str) -> Element | None:
    """The input of a node by name; None without one."""
    return next((child for child in node if child.tag == "input" and child.get("name") == name), None)


def _as_type(numbers: np.ndarray, kind: str) -> np.ndarray:
    """Numbers of another count: one is repeated, those beyond are left out."""
    count = _COUNTS.get(kind, len(numbers))
    if len(numbers) == 1:
        return np.repeat(numbers, count)
    return np.concatenate([numbers, np.ones(max(count - len(numbers), 0))])[:count]
