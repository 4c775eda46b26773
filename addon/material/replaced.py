# SPDX-License-Identifier: GPL-3.0-or-later
"""What is lost of a material's layers where another stack takes their place."""

import bpy

from ...reference_py.errors import Sentence, joined
from .elements import find_node, kind_of
from .live_values import what_moves
from .masks import mask_node


def lost_with_layers(material: bpy.types.Material) -> Sentence | None:
    """Names the textures and animation of a material's layers; None where it has none.

    Masks of a generator are values of a stack, as all that a preset gives.
    """
    lamina, lost = material.lamina, []
    for element in (*lamina.layers, lamina.base) if lamina.is_layered else ():
        if (node := find_node(element)) is None:
            continue
        for name, moved in what_moves(element).items():
            label = kind_of(element).parameter(name).label
            if mask_node(node.inputs[label]) is None:
                lost.append(Sentence("{label} of {layer} ({moved})", label=Sentence(label), layer=element.name, moved=Sentence(moved)))
    return Sentence("{lost}: that is gone with the former layers", lost=joined(lost)) if lost else None
