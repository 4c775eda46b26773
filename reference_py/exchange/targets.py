# SPDX-License-Identifier: GPL-3.0-or-later
"""What a stack is written as for other programs: Principled's values, a surface of MaterialX, or a graph of its layers."""

import json
from collections.abc import Mapping
from pathlib import PurePath

from ..errors import one_of
from ..material.stack import Stack
from . import SUFFIX
from .conversion import Converted
from .layer_graph_writing import LayerGraph, to_layers
from .materialx import Picture, layers_to_mtlx, to_mtlx
from .openpbr import to_surface
from .principled import to_principled
from .surfaces import SURFACES

PRINCIPLED = "principled"
LAYERS = "layers"
"""A graph of MaterialX's BSDFs."""
NODES = {"openpbr": "open_pbr_surface", "standard_surface": "standard_surface", "gltf_pbr": "gltf_pbr"}
"""Nodes of MaterialX that a stack becomes, by what users call them."""
TARGETS = (PRINCIPLED, *NODES, LAYERS)
# What Principled's sockets are called in each node: those that pictures may feed.
PICTURES = {
    "openpbr": {
        "Base Color": "base_color", "Roughness": "specular_roughness", "Metallic": "base_metalness", "Normal": "geometry_normal",
        "Coat Weight": "coat_weight", "Coat Roughness": "coat_roughness", "Coat Normal": "geometry_coat_normal",
    },
    "standard_surface": {
        "Base Color": "base_color", "Roughness": "specular_roughness", "Metallic": "metalness", "Normal": "normal",
        "Coat Weight": "coat", "Coat Roughness": "coat_roughness", "Coat Normal": "coat_normal",
    },
    "gltf_pbr": {
        "Base Color": "base_color", "Roughness": "roughness", "Metallic": "metallic", "Normal": "normal",
        "Coat Weight": "clearcoat", "Coat Roughness": "clearcoat_roughness", "Coat Normal": "clearcoat_normal",
    },
}  # fmt: skip


def suffix_of(target: str) -> str:
    """How names of its files end."""
    return ".json" if target == PRINCIPLED else SUFFIX


def convert_to(target: str, stack: Stack, textured: bool = False) -> Converted | LayerGraph:
    """The stack as one of TARGETS, as bright as it is. `textured`: with a map for textures of the base color, which takes seconds.

    Raises LaminaError for an unknown target, and for what one cannot say.
    """
    one_of("convert", "target", target, TARGETS)
    if target == LAYERS:
        return to_layers(stack)
    return to_principled(stack, textured) if target == PRINCIPLED else to_surface(SURFACES[NODES[target]], stack, textured)


def text_of(target: str, converted: Converted | LayerGraph, name: str, pictures: Mapping[str, PurePath] | None = None) -> str:
    """The text of a file with what `convert_to` gave. `pictures`, by Principled's sockets, lie beside the file and take the place of values."""
    if isinstance(converted, LayerGraph):
        return layers_to_mtlx(converted.tree, name)
    files = {socket: PurePath(path).name for socket, path in (pictures or {}).items()}
    if target == PRINCIPLED:
        told = {"values": converted.values, "report": converted.report.lines()}
        return json.dumps(told | ({"pictures": files} if files else {}), indent=2) + "\n"
    images = {PICTURES[target][socket]: Picture(file, "Color" in socket, "Normal" in socket) for socket, file in files.items()}
    return to_mtlx(converted.values, name, NODES[target], images)
