# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material holds, read from its nodes, and whether it may be changed."""

import json

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material.schema import SCHEMA_VERSION
from ...reference_py.material.stack import Stack
from .elements import find_node, kind_of
from .masks import read_with_masks
from .means import measure_node


def require_editable(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material that belongs to another file."""
    if material.library is not None:
        raise LaminaError("material {material} is linked from {library}; make it local to edit it", material=material.name, library=material.library.filepath)
    if material.override_library is not None:
        raise LaminaError(
            "material {material} is a library override, of which Blender keeps no values of nodes; make it local to edit it", material=material.name
        )


def is_own(material: bpy.types.Material) -> bool:
    """Whether a material is this file's, and so may be changed."""
    return material.library is None and material.override_library is None


def require_layered(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material without a Lamina stack."""
    if not material.lamina.is_layered:
        raise LaminaError("material {material} has no Lamina stack; pick a preset first", material=material.name)


def stack_of(material: bpy.types.Material, hidden: bool = False) -> Stack:
    """The stack that the sockets hold; layers that are not shown only if asked for. A linked socket counts with the mean that is kept.

    Raises LaminaError when a socket holds what the schema does not allow.
    """
    require_layered(material)
    lamina = material.lamina
    return Stack.from_dict(
        {
            **json.loads(lamina.unknown or "{}"),
            # older files' sockets mean what they mean now; a newer one's may not
            "schema_version": max(lamina.schema_version, SCHEMA_VERSION),
            "name": lamina.stack_name,
            "source": lamina.source,
            "layers": [read_with_masks(e) for e in (lamina.layers if hidden else lamina.shown_layers)],
            "base": read_with_masks(lamina.base),
        },
        Sentence("material {material}", material=material.name),
    )


def measure_means(material: bpy.types.Material) -> bool:
    """Keep the means of all that is linked to a material's values; whether one changed. A material of another file keeps those that it has.

    Raises LaminaError where Blender cannot bake now.
    """
    if not is_own(material):
        return False
    elements = [*material.lamina.layers, material.lamina.base]
    return sum(measure_node(node, kind_of(e).sockets) for e in elements if (node := find_node(e)) is not None) > 0  # all of them, not the first alone


def measured_stack(material: bpy.types.Material) -> Stack:
    """The stack that the sockets hold, after the means of what is linked were measured. Raises LaminaError."""
    require_layered(material)
    measure_means(material)
    return stack_of(material)
