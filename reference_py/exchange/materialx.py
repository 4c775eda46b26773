# SPDX-License-Identifier: GPL-3.0-or-later
"""MaterialX files: materials with one of the surfaces that `surfaces` knows, or of layered BSDFs, read and written with the standard library."""

import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.json_input import read_text
from ..optics.colour import known_spaces
from .bsdf_tree import SURFACE, Mixed, Tree
from .conversion import Converted
from .layer_graph import LayeredMaterial, read_layered
from .layer_graph_writing import add_surface
from .materialx_document import Document
from .materialx_graph import Absent, Graph, Unread, as_normal, input_of
from .materialx_image import Image
from .mixed_surfaces import MixedSurfaces
from .openpbr import PLACES, from_surface
from .report import APPROXIMATED, LOST, Loss, Report, image_loss, shown
from .surfaces import SURFACES, Surface

_VERSION = "1.39"
# Mixes of mixes.
_MOST_MIXES = 8
_MATERIAL, _INCLUDE, _MOST_FILES = "surfacematerial", "xi:include", 32
# Inputs that are vectors in space: what says nothing where no image feeds it.
_FRAMES = frozenset({
    "normal", "tangent", "coat_normal", "clearcoat_normal", "geometry_normal", "geometry_coat_normal", "geometry_tangent", "geometry_coat_tangent",
})  # fmt: skip
# Their names in a stack's terms.
NORMALS = {
    "normal": "geometry_normal", "geometry_normal": "geometry_normal", "coat_normal": "geometry_coat_normal",
    "clearcoat_normal": "geometry_coat_normal", "geometry_coat_normal": "geometry_coat_normal",
}  # fmt: skip
# Units of a film's thickness in nm, and the inputs that have one.
_UNITS = {"nanometer": 1.0, "micron": 1e3, "millimeter": 1e6, "centimeter": 1e7, "meter": 1e9}
_THICKNESSES = ("thin_film_thickness", "iridescence_thickness")
# Above 1 an index is no share; a hundred is beyond every medium.
_MOST_IOR, _MOST = 100.0, 1e9
_SHARES = re.compile(
    r"weight|color|roughness|metal|anisotrop|opacity|darkening|coat|tint|sheen|base$|specular$|transmission$|subsurface$|alpha$|iridescence$", re.I
)
_SIGNED = re.compile(r"scatter_anisotropy|subsurface_anisotropy|extra_roughness|displacement|rotation")


@dataclass(frozen=True)
class Material:
    """One material of a file: its surface, values by the surface's own names, and images by the input that they feed."""

    name: str
    surface: Surface
    values: dict
    images: dict[str, Image] = field(default_factory=dict)
    losses: tuple[Loss, ...] = ()
    """What reading it cost."""
    means: frozenset[str] = frozenset()
    """Images whose means the values are."""

    @property
    def node(self) -> str:
        """The surface's node."""
        return self.surface.node

    def with_means(self, means: Mapping[str, np.ndarray]) -> "Material":
        """With the means of images as the values of what they feed."""
        values = {}
        for given, mean in means.items():
            if (default := self.surface.defaults.get(given)) is not None:
                mean = np.clip(mean, 0.0, 1.0) if _SHARES.search(given) else mean
                values[given] = tuple(float(c) for c in np.broadcast_to(mean, 3)) if isinstance(default, tuple) else float(mean[0])
        return replace(self, values=self.values | values, means=frozenset(means))

    def places(self, given: str, converted: Converted) -> list[tuple[int, str]]:
        """Where an image of `images` goes: elements by index, -1 the base, and their parameter; a normal to all that there are."""
        names = {self.surface.own(name): name for name in PLACES} | NORMALS
        if given not in names:
            return []
        roles, parameter = PLACES[names[given]]
        here = [converted.owners[role] for role in roles if role in converted.owners]
        return [(index, parameter) for index in (here if parameter == "normal" else here[:1])]

    def to_stack(self, without: frozenset[str] = frozenset()) -> Converted:
        """The stack that is as bright; `without`: images that are not linked to it, and are lost. Raises LaminaError."""
        own = {self.surface.own(name): name for name in ("base_color", "coat_weight")}
        used = frozenset(own.get(i, NORMALS.get(i, i)) for i in self.images if i not in without)
        textured = self.surface.own("base_color") in self.images and self.surface.own("base_color") not in without
        converted = from_surface(self.surface, self.values, self.name, textured, used)
        left_out = [image_loss(i, self.images[i], self.values.get(i), i in self.means) for i in sorted(without)]
        report = Report((*self.losses, *left_out, *converted.report.losses), converted.report.match)
        return replace(converted, report=report)


@dataclass(frozen=True)
class Picture:
    """An image file that feeds an input: a color in sRGB, tangent space normals, or a value."""

    file: str
    is_color: bool
    is_normal: bool


AnyMaterial = Material | LayeredMaterial | MixedSurfaces


def to_mtlx(values: dict, name: str, node: str = "open_pbr_surface", pictures: Mapping[str, Picture] = MappingProxyType({})) -> str:
    """The text of a file with one material. `values` by the surface's own names; colors are linear Rec. 709. `pictures` feed inputs in their place."""

    def add(root: ElementTree.Element, surface_name: str) -> None:
        for parameter, picture in pictures.items():
            _add_picture(root, parameter, picture)
        surface = ElementTree.SubElement(root, node, name=surface_name, type="surfaceshader")
        for parameter, value in values.items():
            if parameter in pictures:
                continue
            kind, text = ("color3", ", ".join(f"{v:.7g}" for v in value)) if isinstance(value, tuple) else ("float", f"{value:.7g}")
            ElementTree.SubElement(surface, "input", name=parameter, type=kind, value=text)
        for parameter, picture in pictures.items():
            ElementTree.SubElement(surface, "input", name=parameter, type=_kind(picture), nodename=f"{parameter}_picture")

    return _file(name, add)


def _kind(picture: Picture) -> str:
    return "color3" if picture.is_color else "vector3" if picture.is_normal else "float"


def _add_picture(root: ElementTree.Element, parameter: str, picture: Picture) -> None:
    """The node that gives an input's values."""
    name = f"{parameter}_picture"
    image = ElementTree.SubElement(root, "image", name=f"{name}_file" if picture.is_normal else name, type=_kind(picture))
    space = {"colorspace": "srgb_texture"} if picture.is_color else {}
    ElementTree.SubElement(image, "input", name="file", type="filename", value=picture.file, **space)
    if picture.is_normal:
        node = ElementTree.SubElement(root, "normalmap", name=name, type="vector3")
        ElementTree.SubElement(node, "input", name="in", type="vector3", nodename=f"{name}_file")


def layers_to_mtlx(tree: Tree, name: str) -> str:
    """The text of a file with one material, whose surface is a graph of layers."""
    return _file(name, lambda root, surface_name: add_surface(root, tree, surface_name))


def _file(name: str, add: Callable[[ElementTree.Element, str], None]) -> str:
    """The text of a file with one material, the surface of which `add` writes by a name."""
    root = ElementTree.Element("materialx", version=_VERSION, colorspace="lin_rec709")
    label = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "Lamina"
    label = label if not label[0].isdigit() else f"M_{label}"
    add(root, f"{label}_surface")
    material = ElementTree.SubElement(root, _MATERIAL, name=label, type="material")
    ElementTree.SubElement(material, "input", name="surfaceshader", type="surfaceshader", nodename=f"{label}_surface")
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def load_mtlx(path: str | os.PathLike) -> list[AnyMaterial]:
    """The materials of a file, then those of files that it includes; images are paths.

    Raises LaminaError in one line for what is no MaterialX file, has no surface that is known, or a value that is none.
    """
    main, *included = _with_included(Path(path))
    document = Document(read_text(main, "MaterialX file"), str(main))
    for file in included:
        document.include(read_text(file, "MaterialX file"), str(file), Path(os.path.relpath(file.parent, main.parent)).as_posix())
    return _required(*_materials(document, main.parent), str(path))


def from_mtlx(text: str, where: str = "MaterialX") -> list[AnyMaterial]:
    """The materials of a text, without what it includes."""
    return _required(*_materials(Document(text, where)), where)


def _materials(document: Document, folder: Path | None = None) -> tuple[list[AnyMaterial], list[str]]:
    """Those that can be read, their images below a folder, and the surfaces of the others."""
    found: list[AnyMaterial] = []
    others = []
    for name, node in _surfaces(document):
        read = _read(document, name, node, folder)
        if read is not None and _is_displaced(document, name):
            lost = Loss("displacementshader", Sentence("linked"), LOST, Sentence("a stack has no place for it"))
            read = replace(read, losses=(*read.losses, lost))
        if read is None:
            others.append(node.tag)
        else:
            found.append(read)
    return found, others


def _is_displaced(document: Document, name: str) -> bool:
    graph = Graph(document)
    return any(
        given.get("name") == "displacementshader" and graph.node(given) is not None
        for material in document.iter(_MATERIAL)
        if material.get("name") == name
        for given in material.iter("input")
    )


def _read(document: Document, name: str, node: ElementTree.Element, folder: Path | None, depth: int = 0) -> AnyMaterial | None:
    """The material of a surface; None where it, or one of two that are mixed, is not known."""
    if node.tag in SURFACES:
        return _material(document, name, node, folder)
    if node.tag == SURFACE:
        return read_layered(document, name, node, folder)
    if node.tag != "mix" or node.get("type") != "surfaceshader":
        with document.inside(node) as graph:
            inner = None if graph is None else Graph(document).output(graph, "")
            return None if inner is None or depth > _MOST_MIXES else _read(document, name, inner[0], folder, depth + 1)
    if depth > _MOST_MIXES:
        raise LaminaError("{where}: {name} mixes mixes more than {most} deep, or in a circle", where=document.where, name=name, most=_MOST_MIXES)
    graph, losses = Graph(document), []
    linked = [graph.node(given) if (given := input_of(node, side)) is not None else None for side in ("bg", "fg")]
    parts = [_read(document, one[0].get("name", name), one[0], folder, depth + 1) if one else None for one in linked]
    if None in parts:
        return None
    found, image, share = graph.value(given) if (given := input_of(node, "mix")) is not None else np.zeros(1), None, 0.5
    losses += [Loss("mix", Sentence("linked"), APPROXIMATED, note) for note in dict.fromkeys(graph.notes)]
    if isinstance(found, Image):
        image = found if folder is None else replace(found, file=str(folder / found.file))
    elif isinstance(found, Absent):
        share = 0.0
    elif isinstance(found, Unread):
        losses.append(Loss("mix", Sentence("linked"), LOST, Sentence("{why}; an even mix stands in", why=found.why)))
    else:
        share = float(np.clip(found[0], 0.0, 1.0))
    first, second = parts
    if isinstance(first, LayeredMaterial) and isinstance(second, LayeredMaterial) and (first.emission, first.opacity) == (second.emission, second.opacity):
        tree = Mixed(first.tree, second.tree, share, image, node.get("name", "mix"))
        return replace(first, name=name, tree=tree, losses=(*losses, *first.losses, *second.losses))
    if image is not None:
        losses.append(Loss("mix", Sentence("linked"), LOST, Sentence("an image says where: an even mix stands in")))
    return MixedSurfaces(name, first, second, share, tuple(losses))


def _required(found: list[AnyMaterial], others: list[str], where: str) -> list[AnyMaterial]:
    if not found:
        names = ", ".join(sorted(set(others)))[:80] or "no surface"
        raise LaminaError(
            "{where}: has none of the surfaces that can be read, {choices}, {surface} of BSDFs; it has {names}",
            where=where,
            choices=", ".join(SURFACES),
            surface=SURFACE,
            names=names,
        )
    return found


def _with_included(path: Path) -> list[Path]:
    """The file and those that it includes. Raises LaminaError for one outside its folder, or too many."""
    files = [path]
    for file in files:  # which grows
        for node in Document(read_text(file, "MaterialX file"), str(file)).root.iter(_INCLUDE):
            name = node.get("href", "")
            included = file.parent / name
            if not included.resolve().is_relative_to(path.parent.resolve()):
                raise LaminaError("{file}: includes {name}, which is outside its folder; move it there", file=file, name=name[:80])
            if included not in files:
                files.append(included)
        if len(files) > _MOST_FILES:
            raise LaminaError("{path}: includes more than {most} files", path=path, most=_MOST_FILES)
    return files


def _surfaces(document: Document) -> list[tuple[str, ElementTree.Element]]:
    """Every material's name and surface; where there is no material, every surface."""
    graph = Graph(document)
    found = []
    for material in document.iter(_MATERIAL):
        for given in material.iter("input"):
            if given.get("name") == "surfaceshader" and (linked := graph.node(given)):
                found.append((material.get("name", ""), linked[0]))
    if not found:
        defining = {n for graph in document.iter("nodegraph") if document.is_definition(graph) for n in graph.iter()}
        surfaces = (n for n in document.iter() if n.get("type") == "surfaceshader" and n.tag not in ("input", "output", "nodedef"))
        found = [(n.get("name", ""), n) for n in surfaces if n not in defining]
    return found


def _material(document: Document, name: str, node: ElementTree.Element, folder: Path | None) -> Material:
    surface, graph = SURFACES[node.tag], Graph(document)
    values, images, losses = {}, {}, []
    for given in node:
        if given.tag != "input":
            continue
        parameter = given.get("name", "")
        default = surface.defaults.get(parameter)
        if parameter not in _FRAMES and default is None:
            losses.append(Loss(parameter, given.get("value", Sentence("linked")), LOST, Sentence("a stack has no place for it")))
            continue
        found = graph.value(given)
        if isinstance(found, Absent):
            continue
        losses += [Loss(parameter, Sentence("linked"), APPROXIMATED, note) for note in dict.fromkeys(graph.notes)]
        if isinstance(found, Image):
            found = as_normal(found) if parameter in NORMALS and not found.is_normal else found
            found = found if folder is None else replace(found, file=str(folder / found.file))
            if folder is None or found.files or found.default is None or default is None:
                images[parameter] = found
                continue
            stands_for = np.array(found.default[: found.width] if found.channel is None else [found.default[min(found.channel, len(found.default) - 1)]])
            value = _limited(surface, parameter, found.at(stands_for), document.where, losses)
            values[parameter] = value
            why = Sentence("there is no such file; the file's own default, {value}, stands in", value=shown(value))
            losses.append(Loss(parameter, Sentence("image {file}", file=found.file), LOST, why))
        elif isinstance(found, Unread):
            stands_in = Sentence("left out") if default is None else Sentence("its default, {value}, stands in", value=shown(default))
            losses.append(Loss(parameter, Sentence("linked"), LOST, Sentence("{why}; {stands_in}", why=found.why, stands_in=stands_in)))
        elif default is not None:
            values[parameter] = _limited(surface, parameter, found * _of_unit(surface, parameter, graph.unit or given.get("unit", "")), document.where, losses)
    losses += [
        Loss("color space", space[:40], APPROXIMATED, Sentence("unknown: read as linear Rec.709; known are {known}", known=", ".join(known_spaces())))
        for space in sorted(graph.unknown)
    ]
    return Material(name, surface, surface.defaults | values, images, tuple(losses))


def _of_unit(surface: Surface, parameter: str, unit: str) -> float:
    """The factor from the unit of a film's thickness to the surface's own, of those that say one."""
    return _UNITS.get(unit, surface.film_unit) / surface.film_unit if parameter in _THICKNESSES else 1.0


def _limited(surface: Surface, parameter: str, found: np.ndarray, where: str, losses: list[Loss]):
    """A value in its range: what is beyond is limited, and said. Raises LaminaError for a number that cannot be meant."""
    is_color = isinstance(surface.defaults[parameter], tuple)
    value = np.broadcast_to(found[:3], 3) if is_color and len(found) in (1, 3, 4) else found
    if not is_color and len(value) != 1:
        raise LaminaError("{where}: {parameter} has {count} numbers; choose one number", where=where, parameter=parameter, count=len(value))
    most = _MOST_IOR if parameter.lower().endswith("ior") else _MOST if parameter in surface.unlimited or not _SHARES.search(parameter) else 1.0
    if _SIGNED.search(parameter):
        return float(value[0])
    if not is_color and value[0] < 0.0:
        raise LaminaError(
            "{where}: {parameter} is {value:.6g}; choose one number from 0 to {most:g}", where=where, parameter=parameter, value=value[0], most=most
        )
    kept = np.clip(value, 0.0, most)
    if np.any(np.abs(kept - value) > 1e-6):
        outside = Sentence("outside Rec.709") if is_color and np.any(value < -1e-6) else Sentence("out of its range")
        losses.append(
            Loss(
                parameter,
                tuple(value) if is_color else float(value[0]),
                APPROXIMATED,
                Sentence("{outside}, 0 to {most:g}; limited to {kept}", outside=outside, most=most, kept=shown(kept)),
            )
        )
    return tuple(float(c) for c in kept) if is_color else float(kept[0])
