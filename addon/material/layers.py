# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of a material's layers. Each is made wholly or, when it raises LaminaError, not at all.

Copied layers travel as JSON text. Where the layer that was copied is still in the file, its textures, drivers and
keyframes come along too.
"""

import json
from collections.abc import Sequence
from dataclasses import replace

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.material.json_input import parse_json
from ...reference_py.material.ready_layers import layers_of
from ...reference_py.material.schema import SCHEMA, SCHEMA_VERSION
from ...reference_py.material.stack import MAX_LAYERS, Layer
from . import masks
from .elements import fill_element, find_node, free_name, node_of
from .material import changing
from .node_copy import copy_inputs
from .reading import require_editable, require_layered

COPIED_KEY = "lamina_layers"
_WHERE = "the copied layers"


def add_layer(material: bpy.types.Material, kind: str, index: int) -> None:
    """Insert a layer of the schema's defaults before position `index` (0 is the top)."""
    add_layers(material, layers_of({"layers": [{"kind": kind}]}, f"material {material.name}"), index)


def add_layers(material: bpy.types.Material, layers: Sequence[Layer], index: int) -> None:
    """Insert layers before position `index` and select the first of them. Raises LaminaError for too many."""
    _require_room(material, len(layers))
    with changing(material) as tree:
        masks.give_masks(tree, _insert(material, tree, layers, index), layers)


def add_mask(material: bpy.types.Material, index: int, name: str, generator: str) -> None:
    """Feed a value of a layer by a mask. Raises LaminaError for a value that takes none, or has a link."""
    require_layered(material)
    with changing(material) as tree:
        masks.add_mask(tree, material.lamina.layers[index], name, generator)


def duplicate_layer(material: bpy.types.Material, index: int) -> None:
    """Insert a copy of a layer above it: values, textures, drivers and keyframes."""
    _require_room(material, 1)
    paste_layers(material, copied_text(material, [index]), index)


def remove_layer(material: bpy.types.Material, index: int) -> None:
    """Remove a layer and its node, with what animates it."""
    require_layered(material)
    with changing(material):
        lamina = material.lamina
        if lamina.layers[index].node == lamina.solo:
            lamina.solo = ""
        lamina.active_layer = index + 1 if index + 1 < len(lamina.layers) else index - 1
        lamina.active_layer = index  # gone below, so its neighbour is selected, and it is again after an undo
        lamina.layers.remove(index)


def move_layer(material: bpy.types.Material, index: int, to: int) -> None:
    """Move a layer to another position. Its node, and what animates it, stay as they are."""
    require_layered(material)
    with changing(material):
        material.lamina.layers.move(index, to)
        material.lamina.active_layer = to


def solo_layer(material: bpy.types.Material, index: int) -> None:
    """Show a layer alone over the base, or, where it is alone already, all visible ones as before."""
    require_layered(material)
    with changing(material):
        lamina = material.lamina
        node = lamina.layers[index].node
        lamina.solo = "" if lamina.solo == node else node


def copied_text(material: bpy.types.Material, indices: Sequence[int]) -> str:
    """Layers as the JSON text that `paste_layers` takes. Raises LaminaError for values that the schema does not allow."""
    require_layered(material)
    elements = [material.lamina.layers[index] for index in indices]
    rows = [{**masks.read_with_masks(e), "from": {"material": material.name, "node": e.node}} for e in elements]
    layers_of({"layers": rows}, f"material {material.name}")
    return json.dumps({"schema_version": SCHEMA_VERSION, COPIED_KEY: rows}, indent=2)


def paste_layers(material: bpy.types.Material, text: str, index: int) -> list[str]:
    """Insert copied layers before position `index`. Returns one sentence for each thing that did not come along.

    Raises LaminaError for a text that is no copy of layers, or from a newer Lamina.
    """
    data = _parsed(text)
    layers = layers_of({**data, "layers": data[COPIED_KEY]}, _WHERE)
    sources = [_source_of(layer) for layer in layers]
    layers = [replace(e, unknown={k: v for k, v in e.unknown.items() if k != "from"}) for e in layers]
    _require_room(material, len(layers))
    notes: list[str] = []
    before = {node.name for node in material.node_tree.nodes}
    try:
        with changing(material) as tree:
            elements = _insert(material, tree, layers, index)
            for element, source in zip(elements, sources):
                if source is not None:
                    node, element.visible = source
                    notes += copy_inputs(node, node_of(element))
            masks.give_masks(tree, elements, layers)
    except Exception:
        for node in [node for node in material.node_tree.nodes if node.name not in before]:
            material.node_tree.nodes.remove(node)
        raise
    return notes


def _parsed(text: str) -> dict:
    try:
        data = parse_json(text, _WHERE)
    except LaminaError:
        data = None
    if not isinstance(data, dict) or not isinstance(data.get(COPIED_KEY), list):
        raise LaminaError("no layers were copied; select a layer and choose Copy Layer first")
    return data


def _require_room(material, count: int) -> None:
    require_layered(material)
    require_editable(material)
    if len(material.lamina.layers) + count > MAX_LAYERS:
        raise LaminaError(
            "material {material} has {count} layers already; at most {most} are allowed",
            material=material.name,
            count=len(material.lamina.layers),
            most=MAX_LAYERS,
        )


def _insert(material, tree, layers: Sequence[Layer], index: int) -> list:
    """New property groups for the layers, in their order. References to property groups die with each `add`."""
    lamina = material.lamina
    for offset, layer in enumerate(layers):
        fill_element(tree, lamina.layers.add(), layer, SCHEMA.layers[layer.kind])
        lamina.layers.move(len(lamina.layers) - 1, index + offset)
        element = lamina.layers[index + offset]
        element.name = free_name(element, element.name)
    lamina.active_layer = index
    return [lamina.layers[index + offset] for offset in range(len(layers))]


def _source_of(layer: Layer) -> tuple[bpy.types.Node, bool] | None:
    """The node that a copied layer came from, and whether it is visible, if it is still in this file."""
    origin = layer.unknown.get("from")
    if not isinstance(origin, dict):
        return None
    named = bpy.data.materials.get(str(origin.get("material")))
    # copies of a material have the names of its nodes, so the material that was named comes first
    for material in (*filter(None, [named]), *bpy.data.materials):
        for element in material.lamina.layers:
            if element.node == origin.get("node") and find_node(element) is not None:
                return node_of(element), element.visible
    return None
