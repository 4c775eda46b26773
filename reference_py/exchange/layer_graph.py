# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of MaterialX files that are layers of BSDFs, to stacks and back.

A `layer` node of MaterialX leaves out the light between two layers; a stack has it. So the base color is solved both ways,
such that the mean albedo stays, and a stack that goes out and comes back is itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.stack import Stack
from ..optics.colour import known_spaces
from .appearance import Appearance
from .bsdf_albedo import light_of
from .bsdf_stack import Builder, metal_row, relative_colors
from .bsdf_tree import SURFACE, Leaf, Mixed, Tree, TreeReader, every_part, images_of, mapped, within, without_nothing
from .conversion import Converted, matched
from .matching import FINE, Albedos, color_map, mean, recolored, truth
from .materialx_document import Document
from .materialx_graph import Absent, input_of
from .materialx_image import Image
from .report import APPROXIMATED, LOST, Loss, Report, image_loss, shown
from .slots import MOST_REFLECTANCE

NAME = "a graph of layers"
# Inputs of leaves that a texture may feed, as parameters of an element.
_LINKED = {"color": "color", "color0": "color", "roughness": "roughness", "normal": "normal", "weight": "coverage", "thinfilm_thickness": "film_thickness"}


@dataclass(frozen=True)
class LayeredMaterial:
    """One material of a file whose surface is a BSDF; `emission` and `opacity` are those of the surface. Used as `materialx.Material`."""

    name: str
    tree: Tree
    emission: tuple = (0.0, 0.0, 0.0)
    opacity: float = 1.0
    losses: tuple[Loss, ...] = ()
    """What reading it cost."""
    means: frozenset[str] = frozenset()
    """Images whose means the values are."""
    node: str = SURFACE
    values: Mapping = field(default_factory=dict)
    """It has no inputs of its own."""

    @property
    def images(self) -> dict[str, Image]:
        """By what they feed: the node's name and the input."""
        return images_of(self.tree)

    def with_means(self, means: Mapping[str, np.ndarray]) -> "LayeredMaterial":
        """With the means of images as the values of what they feed; what is beyond its range is limited, and said."""
        losses: dict[str, Loss] = {}  # a leaf may be linked twice

        def kept(name: str, given: str) -> np.ndarray:
            mean_ = means[f"{name} {given}"]
            inside = within(given, mean_)
            if np.any(np.abs(inside - mean_) > 1e-6):
                why = Sentence("its mean is out of its range; limited to {kept}", kept=shown(inside))
                losses[f"{name} {given}"] = Loss(f"{name} {given}", tuple(map(float, mean_)), APPROXIMATED, why)
            return inside

        def change(part: Tree) -> Tree:
            if isinstance(part, Mixed):
                return replace(part, share=float(kept(part.name, "mix")[0])) if f"{part.name} mix" in means else part
            if not isinstance(part, Leaf):
                return part
            here = [given for given in part.images if f"{part.name} {given}" in means and given in part.values]
            return replace(part, values={**part.values, **{given: _as_value(part, given, kept(part.name, given)) for given in here}})

        return replace(self, tree=mapped(self.tree, change), losses=(*self.losses, *losses.values()), means=frozenset(means))

    def to_stack(self, without: frozenset[str] = frozenset()) -> Converted:
        """The stack that is as bright; `without`: images that are not linked to it, and are lost. Raises LaminaError."""
        tree = mapped(mapped(self.tree, lambda part: _without(part, without)), without_nothing)
        builder = Builder()
        rows = builder.rows(tree)
        for index, leaf in rows.sources.items():
            element = rows.base if index < 0 else rows.layers[index]
            if "normal" in leaf.images:
                element["normal"] = (0.0, 0.0, 0.0)
            if "weight" in leaf.images and index >= 0:
                element["coverage"] = 1.0
        losses = [*self.losses, *builder.losses]
        losses += [image_loss(i, self.images[i], _value_of(self.tree, i), i in self.means) for i in sorted(without)]
        if rows.media:
            losses.append(Loss("multiply", np.prod([np.power(t, 2.0 * d) for t, d in rows.media], axis=0), APPROXIMATED, Sentence("in the base color")))
        data = {"name": self.name, "source": f"Converted from {NAME}", "layers": rows.layers, "base": rows.base}
        stack = Stack.from_dict(data, self.name or NAME)
        look = self._look(tree)
        losses += [
            Loss(leaf, "", LOST, Sentence("light that no stack sends back; that is {share:.1f} % of its light", share=_share(light, look)))
            for leaf, light in look.lost.items()
        ]
        base = rows.sources.get(-1)
        is_metal = base is not None and "reflectance" in stack.base
        start, edge = relative_colors(base) if base is not None and is_metal else (stack.base["color"], None)

        def exact(of: Stack) -> Albedos:
            return truth(of) if edge is None else lambda color: truth(_with_color(of, color, edge, rows.n))()

        stack, color, report = matched(stack, exact, start, MOST_REFLECTANCE if is_metal else 1.0, look, self.name, losses, FINE)
        told = {(loss.parameter, loss.how): loss for loss in report.losses}  # a leaf may be linked twice
        owners = {f"{leaf.name} {given}": index for index, leaf in rows.sources.items() for given in leaf.images}
        owners |= {f"{mix} mix": index for mix, covering in builder.covers.items() for index, leaf in rows.sources.items() if leaf == covering}
        colors = None
        if base is not None and (base_color := next((i for i in ("color", "color0") if i in base.images), None)):
            colors = color_map(lambda c: self._look(_recolored(tree, base, base_color, c)).solid, truth(stack))
        return Converted(_with_color(stack, color, edge, rows.n), {}, None, owners, Report(tuple(told.values()), report.match), colors)

    def places(self, given: str, converted: Converted) -> list[tuple[int, str]]:
        """Where an image of `images` goes: elements by index, -1 the base, and their parameter."""
        parameter = "coverage" if given.endswith(" mix") else _LINKED.get(given.rpartition(" ")[2])
        return [(converted.owners[given], parameter)] if parameter and given in converted.owners else []

    def _look(self, tree: Tree) -> Appearance:
        light = light_of(tree)
        lost = {name: self.opacity * np.broadcast_to(part, light.back.shape) for name, part in light.lost.items() if np.any(part > 0.0)}
        if any(self.emission):
            lost["emission"] = np.broadcast_to(self.opacity * np.array(self.emission), light.back.shape)
        if self.opacity < 1.0:
            lost["opacity"] = np.full(light.back.shape, 1.0 - self.opacity)
        return Appearance(light.back, self.opacity * light.back, lost)


def read_layered(document: Document, name: str, node: Element, folder: Path | None = None) -> LayeredMaterial:
    """The material of a `surface` node. Raises LaminaError without a BSDF, or for one that is not known."""
    reader = TreeReader(document, folder)
    tree = reader.tree(input_of(node, "bsdf"))
    if tree is None:
        raise LaminaError("{where}: {name} has no BSDF", where=document.where, name=node.get("name", SURFACE))
    emission = tuple(float(c) for c in reader.emission(input_of(node, "edf")))
    opacity, losses = 1.0, reader.losses
    if (given := input_of(node, "opacity")) is not None:
        value = reader.value("opacity", given)
        if isinstance(value, np.ndarray):
            opacity = float(np.clip(value[0], 0.0, 1.0))
        elif not isinstance(value, Absent):
            losses.append(Loss("opacity", Sentence("linked"), LOST, Sentence("a stack is opaque")))
    losses += [
        Loss("color space", space[:40], APPROXIMATED, Sentence("unknown: read as linear Rec.709; known are {known}", known=", ".join(known_spaces())))
        for space in sorted(reader.graph.unknown)
    ]
    return LayeredMaterial(name, tree, emission, opacity, tuple(losses))


def _without(part: Tree, without: frozenset[str]) -> Tree:
    if isinstance(part, Mixed):
        return replace(part, image=None) if f"{part.name} mix" in without else part
    if not isinstance(part, Leaf):
        return part
    return replace(part, images={given: image for given, image in part.images.items() if f"{part.name} {given}" not in without})


def _as_value(leaf: Leaf, given: str, mean_: np.ndarray):
    """A mean as the value of an input: of a roughness its square, twice."""
    if given == "roughness" and isinstance(leaf.values[given], tuple):
        return (float(mean_[0]) ** 2,) * 2
    default = leaf.values[given]
    return tuple(float(c) for c in np.broadcast_to(mean_, 3)) if isinstance(default, tuple) else float(mean_[0])


def _value_of(tree: Tree, given: str):
    """What an image feeds has this value; None for what has none."""
    node, _, name = given.rpartition(" ")
    named = next(part for part in every_part(tree) if isinstance(part, (Leaf, Mixed)) and part.name == node)
    return named.share if isinstance(named, Mixed) else named.values.get(name)


def _share(light: np.ndarray, look: Appearance) -> float:
    return 100.0 * float(np.sum(mean(light))) / max(float(np.sum(mean(look.seen + look.all_lost))), 1e-9)


def _recolored(tree: Tree, leaf: Leaf, given: str, color) -> Tree:
    values = {**leaf.values, given: tuple(float(c) for c in np.broadcast_to(color, 3))}
    return mapped(tree, lambda part: replace(part, values=values) if part == leaf else part)


def _with_color(stack: Stack, color: np.ndarray, edge: np.ndarray | None, n: float) -> Stack:
    """With a base of another color: of a metal, which has an edge color, that against a medium of index n."""
    if edge is None:
        return replace(stack, base=recolored(stack.base, color))
    return replace(stack, base=stack.base.with_values(**{key: value for key, value in metal_row(color, edge, n).items() if key != "kind"}))
