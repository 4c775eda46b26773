# SPDX-License-Identifier: GPL-3.0-or-later
"""MaterialX files with one OpenPBR surface: written and read by the standard library.

What somebody else wrote is read within limits: no document type (so no entities), not too large, not too deep.
"""

import os
import re
import xml.etree.ElementTree as ElementTree
from math import isfinite
from xml.parsers import expat

from ..atomic import write_text
from ..errors import LaminaError
from ..material.json_input import read_text
from .openpbr import DEFAULTS

SUFFIX = ".mtlx"
_VERSION = "1.39"
_SURFACE, _MATERIAL = "open_pbr_surface", "surfacematerial"
_MAX_DEPTH = 32
_UNIT_RANGE = frozenset(p for p in DEFAULTS if p.endswith(("weight", "color", "roughness", "metalness", "anisotropy", "opacity", "darkening")))
_MOST = {"specular_ior": 10.0, "coat_ior": 10.0, "thin_film_ior": 10.0, "thin_film_thickness": 1000.0, "emission_luminance": 1e9}


def to_mtlx(values: dict, name: str) -> str:
    """The text of a file with one material. `values` by OpenPBR's names; colors are linear Rec. 709."""
    root = ElementTree.Element("materialx", version=_VERSION, colorspace="lin_rec709")
    label = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "Lamina"
    label = label if not label[0].isdigit() else f"M_{label}"
    surface = ElementTree.SubElement(root, _SURFACE, name=f"{label}_surface", type="surfaceshader")
    for parameter, value in values.items():
        kind, text = ("color3", ", ".join(f"{v:.7g}" for v in value)) if isinstance(value, tuple) else ("float", f"{value:.7g}")
        ElementTree.SubElement(surface, "input", name=parameter, type=kind, value=text)
    material = ElementTree.SubElement(root, _MATERIAL, name=label, type="material")
    ElementTree.SubElement(material, "input", name="surfaceshader", type="surfaceshader", nodename=surface.get("name"))
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def save_mtlx(values: dict, name: str, path: str | os.PathLike) -> None:
    """Write the file, whole or not at all. Raises LaminaError."""
    write_text(path, to_mtlx(values, name))


def load_mtlx(path: str | os.PathLike) -> tuple[str, dict, list[str]]:
    """Name of the first material, its OpenPBR values, and the inputs that were not read, with the reason.

    Raises LaminaError in one line for what is no MaterialX file, has no OpenPBR surface, or a value that is none.
    """
    return from_mtlx(read_text(path, "MaterialX file"), str(path))


def from_mtlx(text: str, where: str = "MaterialX") -> tuple[str, dict, list[str]]:
    """The same of a text."""
    root = _parsed(text, where)
    if root.tag != "materialx":
        raise LaminaError(f"{where}: not a MaterialX file: its root is <{root.tag[:40]}>, not <materialx>")
    surfaces = {node.get("name", ""): node for node in root.iter(_SURFACE)}
    if not surfaces:
        others = sorted({node.tag for node in root.iter() if node.get("type") == "surfaceshader" and node.tag != "input"})
        raise LaminaError(f"{where}: has no {_SURFACE}, the one surface that can be read; it has {', '.join(others)[:80] or 'no surface'}")
    name, surface = _first(root, surfaces)
    values, notes = {}, []
    for node in surface.iter("input"):
        parameter = node.get("name", "")
        if any(node.get(key) for key in ("nodename", "nodegraph", "interfacename", "output")):
            notes.append(f"{parameter}: is connected to other nodes; its default stands in")
        elif parameter in DEFAULTS:
            values[parameter] = _value(parameter, node.get("value", ""), where)
        else:
            notes.append(f"{parameter}: has no place in a stack")
    if len(surfaces) > 1:
        notes.append(f"{len(surfaces) - 1} more surfaces: only {surface.get('name', '')} is read")
    return name, values, notes


def _first(root, surfaces: dict) -> tuple[str, ElementTree.Element]:
    """The first material whose surface is here, else the first surface."""
    for material in root.iter(_MATERIAL):
        for node in material.iter("input"):
            if node.get("name") == "surfaceshader" and node.get("nodename") in surfaces:
                return material.get("name", ""), surfaces[node.get("nodename")]
    return next(iter(surfaces.items()))


def _value(parameter: str, text: str, where: str):
    parts = text.split(",")
    count = 3 if isinstance(DEFAULTS[parameter], tuple) else 1
    try:
        numbers = tuple(float(part) for part in parts)
    except ValueError:
        numbers = ()
    most = 1.0 if parameter in _UNIT_RANGE else _MOST[parameter]
    if len(numbers) != count or not all(isfinite(v) and 0.0 <= v <= most for v in numbers):
        wanted = "three numbers" if count == 3 else "one number"
        raise LaminaError(f"{where}: {parameter} is {text[:40]!r}; choose {wanted} from 0 to {most:g}")
    return numbers if count == 3 else numbers[0]


def _parsed(text: str, where: str) -> ElementTree.Element:
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    depth = 0

    def start(tag, attributes):
        nonlocal depth
        depth += 1
        if depth > _MAX_DEPTH:
            raise LaminaError(f"{where}: nested too deeply, more than {_MAX_DEPTH} levels")
        builder.start(tag, attributes)

    def end(tag):
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_):
        raise LaminaError(f"{where}: has a document type; entities are not read, so remove its <!DOCTYPE ...>")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        message = expat.errors.messages[error.code]
        raise LaminaError(f"{where}: not valid XML at line {error.lineno} column {error.offset}: {message}") from None
    except (ValueError, LookupError, UnicodeError) as error:
        if isinstance(error, LaminaError):
            raise
        raise LaminaError(f"{where}: not readable as XML: {error}") from None
    return builder.close()
