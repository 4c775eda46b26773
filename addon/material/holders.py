# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects and materials can show a surface."""

import bpy

# Volumes and Grease Pencil objects have material slots too, and Cycles shows no surface of theirs.
_WITH_SURFACE = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD"}


def can_hold_material(item: bpy.types.Object | None) -> bool:
    """Whether an object takes a surface material."""
    return item is not None and item.type in _WITH_SURFACE and hasattr(item.data, "materials")
