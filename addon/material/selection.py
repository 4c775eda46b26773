# SPDX-License-Identifier: GPL-3.0-or-later
"""Which layer of a material is selected: kept for this session, beside the file.

A property of the material would restart every render in a window at each click on a row. A layer is remembered by its
node, whose name never changes, and so are those selected before it: after an undo the last one that is there again is
selected again.
"""

import bpy

# By the material's session_uid: names of nodes, the last one selected at the end.
_selected: dict[int, list[str]] = {}
_MOST = 64  # of a material


def selected_layer(material: bpy.types.Material) -> int:
    """Index of the selected layer, 0 where none was selected."""
    places = {layer.node: index for index, layer in enumerate(material.lamina.layers)}
    return next((places[node] for node in reversed(_selected.get(material.session_uid, ())) if node in places), 0)


def select_layer(material: bpy.types.Material, index: int) -> None:
    """Select a layer; an index past the end selects the last one."""
    layers = material.lamina.layers
    if len(layers):
        node = layers[max(0, min(index, len(layers) - 1))].node
        before = _selected.get(material.session_uid, [])
        _selected[material.session_uid] = [*(n for n in before if n != node), node][-_MOST:]
