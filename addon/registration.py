# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that enabling the extension adds to Blender, and its removal."""

import bpy

from ..reference_py.network.memory import keep_in
from . import bakes, freshness, operators, panel, properties
from .cache import cache_folder
from .cli.main import run

# Kept for unregister: Blender gives the command as a handle.
_command = None

CLASSES = (*properties.CLASSES, *operators.CLASSES, *panel.CLASSES)


def register() -> None:
    """Add the classes, the materials' property and the command `blender --command lamina ...`."""
    global _command
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Material.lamina = bpy.props.PointerProperty(type=properties.LaminaMaterial)
    _command = bpy.utils.register_cli_command("lamina", run)
    keep_in(cache_folder(), lambda told: print(f"Lamina: {told}"))
    for handlers, handler in (*freshness.handlers(), *bakes.handlers()):
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in (*freshness.handlers(), *bakes.handlers()):
        handlers.remove(handler)
    bakes.stop()
    bpy.utils.unregister_cli_command(_command)
    del bpy.types.Material.lamina
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
