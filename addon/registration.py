# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that enabling the extension adds to Blender, and its removal."""

import bpy

from . import properties

CLASSES = (*properties.CLASSES,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Material.lamina = bpy.props.PointerProperty(type=properties.LaminaMaterial)


def unregister() -> None:
    del bpy.types.Material.lamina
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
