# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as a graph of MaterialX's BSDFs that says its layers themselves: one `dielectric_bsdf` over the next over the base.

The color of a medium's round trip is a power of its tint, which scales what is below its interface. A layer's coverage is
a mix of all with it and all without it; an opaque layer is mixed with what it hides. Indices are those to the medium above.
"""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

import numpy as np

from ..errors import Sentence
from ..material.schema import ANISOTROPY, COVERAGE, NORMAL, SCATTERING
from ..material.stack import Base, Layer, Stack
from ..optics.bases import ConductorBase, DiffuseBase
from ..optics.colour import artist_color, artist_index
from ..optics.diffuse import fujii_roughness
from ..optics.interface import Microfacets, film_of, optical_depth
from ..optics.microfacet import GGX
from ..optics.optical_stack import OpticalStack
from .bsdf_albedo import light_of
from .bsdf_tree import CONDUCTOR, DEFAULTS, DIELECTRIC, DISTRIBUTION, OREN_NAYAR, SURFACE, Layered, Leaf, Mixed, Scaled, Tree, every_part
from .conversion import unmatched
from .matching import FINE, compared, mean, solve, truth
from .report import APPROXIMATED, LOST, Loss, Report
from .slots import MOST_REFLECTANCE

_CLEAR = 1e-9  # optical depth of a medium that is none
_TYPES = {"energy_compensation": "boolean", "roughness": "vector2"}


@dataclass(frozen=True)
class LayerGraph:
    """A stack's graph, and what became of it."""

    tree: Tree
    report: Report

    @property
    def values(self) -> dict:
        """What is not at its default, by the node's name and the input."""
        found = {part.name: part for part in every_part(self.tree) if isinstance(part, Leaf)}
        return {f"{name} {key}": value for name, leaf in found.items() for key, value in leaf.values.items() if value != DEFAULTS[leaf.kind][key]}


def to_layers(stack: Stack) -> LayerGraph:
    """The graph as bright as the stack. Raises LaminaError for a stack that no model knows."""
    optics = OpticalStack.of(Stack((), stack.base)).base
    n = next((layer["ior"] for layer in reversed(stack.layers) if not layer.is_opaque), 1.0)
    edge = None
    start = np.array(stack.base["color"]) if isinstance(optics, DiffuseBase) else None
    if isinstance(optics, ConductorBase):
        start, edge = artist_color(np.asarray(optics.eta) / n, np.asarray(optics.k) / n)
        start = np.minimum(start, MOST_REFLECTANCE)

    def tree(color) -> Tree:
        return _below(stack, 0, 1.0, (color, edge, n))

    wanted = truth(stack)()
    color, found = solve(lambda c: light_of(tree(c)).back, mean(wanted), start, 1.0 if edge is None else MOST_REFLECTANCE, FINE)
    has_film = any(film_of(e) for e in (*stack.layers, stack.base))
    losses = [loss for i, e in enumerate([*stack.layers, stack.base]) for loss in _losses(f"layer {i}" if i < len(stack.layers) else "base", e)]
    losses += [
        Loss("base color", color, APPROXIMATED, Sentence("solved such that the mean albedo stays")),
        *unmatched("base color", color, mean(found) - mean(wanted)),
    ]
    return LayerGraph(tree(color), Report(tuple(losses), compared(wanted, found, has_film)))


def _below(stack: Stack, index: int, n: float, solved: tuple) -> Tree:
    """What is from a layer on, below a medium of index `n`; `solved` is the base's color, edge color and the index these are against."""
    if index == len(stack.layers):
        return _base_leaf("base", stack.base, n, solved)
    layer = stack.layers[index]
    share = layer["coverage"] if layer.has(COVERAGE) else 1.0
    if layer.is_opaque:
        whole: Tree = _base_leaf(f"layer_{index}", layer.as_base(), n, None)
    else:
        inner = _below(stack, index + 1, layer["ior"], solved)
        if np.max(optical_depth(layer["tint"], layer["thickness"])) > _CLEAR:
            trips = 2.0 * layer["thickness"]
            inner = Scaled(inner, tuple(float(c) for c in np.power(layer["tint"], trips)), (layer["tint"], trips))
        values = DEFAULTS[DIELECTRIC] | {"ior": float(layer["ior"] / n)} | _facets(layer)
        whole = Layered(Leaf(DIELECTRIC, f"layer_{index}", values, turn=_turn(layer), distribution=layer["distribution"]), inner)
    return whole if share == 1.0 else Mixed(_below(stack, index + 1, n, solved), whole, share, name=f"coverage_{index}")


def _base_leaf(name: str, base: Base, n: float, solved: tuple | None) -> Leaf:
    optics = OpticalStack.of(Stack((), base)).base
    if isinstance(optics, DiffuseBase):
        values = {"color": tuple(float(c) for c in (base["color"] if solved is None else solved[0]))}
        if optics.sigma_deg:
            values |= {"roughness": float(fujii_roughness(optics.sigma_deg)), "energy_compensation": 1.0}
        return Leaf(OREN_NAYAR, name, DEFAULTS[OREN_NAYAR] | values)
    eta, k = (np.asarray(optics.eta), np.asarray(optics.k)) if solved is None else (solved[2] * part for part in artist_index(*solved[:2]))
    values = {"ior": tuple(float(c) for c in eta / n), "extinction": tuple(float(c) for c in k / n)}
    return Leaf(CONDUCTOR, name, DEFAULTS[CONDUCTOR] | values | _facets(base), turn=_turn(base), distribution=base["distribution"])


def _facets(element: Layer | Base) -> dict:
    """Both alphas, and the film."""
    facets, film = Microfacets.of(element), film_of(element)
    widths = facets.anisotropic
    values = {"roughness": (widths.alpha_x, widths.alpha_y) if widths else (facets.alpha, facets.alpha)}
    return values | ({"thinfilm_thickness": film.thickness_nm, "thinfilm_ior": film.ior} if film else {})


def _turn(element: Layer | Base) -> float:
    return element["rotation"] if element.has(ANISOTROPY) else 0.0


def _losses(where: str, element: Layer | Base) -> list[Loss]:
    losses = []
    if "distribution" in element and element["distribution"] != GGX:
        how = Sentence("MaterialX's renderers show GGX, whose highlights have longer tails; it is an attribute of the node, which Lamina reads")
        losses.append(Loss(f"{where} distribution", element["distribution"], APPROXIMATED, how))
    if element.has(NORMAL):
        losses.append(Loss(f"{where} normal", "", LOST, Sentence("textures are not written")))
    if element.has(SCATTERING):
        given = (p.name for p in SCATTERING.parameters if p.name in element)
        losses += [Loss(f"{where} {key}", element[key], APPROXIMATED, Sentence("in the base color alone, such that the mean albedo stays")) for key in given]
    return losses


class _Writer:
    """Elements of a tree, each leaf once."""

    def __init__(self, root: ElementTree.Element):
        self._root = root
        self._names: dict[str, Tree] = {}

    def add(self, tree: Tree) -> str:
        """Write what is not there yet; returns the node's name."""
        name = next((n for n, other in self._names.items() if other == tree), "")
        if name:
            return name
        if isinstance(tree, Leaf):
            return self._leaf(tree)
        if isinstance(tree, Scaled):
            inner = self.add(tree.bsdf)
            assert tree.medium is not None
            power = self._node("round_trip", "power", "color3", tree, "medium")
            _input(power, "in1", "color3", tree.medium[0])
            _input(power, "in2", "float", tree.medium[1])
            node = self._node("below_medium", "multiply", "BSDF", tree)
            _input(node, "in1", "BSDF", link=inner)
            _input(node, "in2", "color3", link=power.get("name", ""))
        elif isinstance(tree, Layered):
            links = {"top": self.add(tree.top), "base": self.add(tree.base)}
            node = self._node(f"{links['top']}_on_{links['base']}", "layer", "BSDF", tree)
            for key, link in links.items():
                _input(node, key, "BSDF", link=link)
        else:
            assert isinstance(tree, Mixed)
            links = {"bg": self.add(tree.first), "fg": self.add(tree.second)}
            node = self._node(tree.name, "mix", "BSDF", tree)
            for key, link in links.items():
                _input(node, key, "BSDF", link=link)
            _input(node, "mix", "float", tree.share)
        return node.get("name", "")

    def _leaf(self, leaf: Leaf) -> str:
        tangent = self._tangent(leaf) if leaf.turn else ""
        node = self._node(leaf.name, leaf.kind, "BSDF", leaf)
        if leaf.distribution != GGX:
            node.set(DISTRIBUTION, leaf.distribution)
        for key, value in leaf.values.items():
            if value != DEFAULTS[leaf.kind][key]:
                kind = _TYPES.get(key, "color3") if isinstance(value, tuple) else _TYPES["energy_compensation"] if key == "energy_compensation" else "float"
                _input(node, key, kind, value)
        if tangent:
            _input(node, "tangent", "vector3", link=tangent)
        return node.get("name", "")

    def _tangent(self, leaf: Leaf) -> str:
        """A tangent that is turned about the normal."""
        links = {
            "in": self._node(f"{leaf.name}_tangent", "tangent", "vector3", leaf, "tangent"),
            "axis": self._node(f"{leaf.name}_normal", "normal", "vector3", leaf, "normal"),
        }
        turned = self._node(f"{leaf.name}_turned", "rotate3d", "vector3", leaf, "turned")
        for key, node in links.items():
            _input(turned, key, "vector3", link=node.get("name", ""))
        _input(turned, "amount", "float", 360.0 * leaf.turn)
        return turned.get("name", "")

    def _node(self, name: str, tag: str, kind: str, tree: Tree, part: str = "") -> ElementTree.Element:
        taken = {node.get("name") for node in self._root}
        name = next(n for n in (name, *(f"{name}_{i}" for i in range(2, 1000))) if n not in taken)
        if not part:
            self._names[name] = tree
        return ElementTree.SubElement(self._root, tag, name=name, type=kind)


def add_surface(root: ElementTree.Element, tree: Tree, name: str) -> None:
    """Write a tree, and the `surface` of a name that shows it."""
    writer = _Writer(root)
    bsdf = writer.add(tree)
    surface = ElementTree.SubElement(root, SURFACE, name=name, type="surfaceshader")
    _input(surface, "bsdf", "BSDF", link=bsdf)


def _input(node: ElementTree.Element, name: str, kind: str, value=None, link: str = "") -> None:
    if link:
        ElementTree.SubElement(node, "input", name=name, type=kind, nodename=link)
        return
    text = ", ".join(f"{v:.9g}" for v in value) if isinstance(value, tuple) else ("true" if value else "false") if kind == "boolean" else f"{value:.9g}"
    ElementTree.SubElement(node, "input", name=name, type=kind, value=text)
