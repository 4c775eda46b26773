# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that enabling the extension adds to Blender, and its removal."""

import bpy

from ..reference_py.network.memory import keep_in
from .background import bakes, fitting
from .user_folders import cache_folder
from .cli.main import run
from .exchange import operators as exchange_operators
from .exchange import texture_operator
from .library import asset_library
from .nodes import freshness, properties
from .operators import check_operators, layer_operators, material_operators, preset_operators
from .ui import panel, panel_layers, preset_icons, swatch_icons, translation

# Kept for unregister: Blender gives the command as a handle.
_command = None

CLASSES = (*properties.CLASSES, *material_operators.CLASSES, *layer_operators.CLASSES, *check_operators.CLASSES, *preset_operators.CLASSES, *fitting.CLASSES, *exchange_operators.CLASSES, *texture_operator.CLASSES, *panel.CLASSES)


def register() -> None:
    """Add the classes, the materials' property and the command `blender --command lamina ...`."""
    global _command
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Material.lamina = bpy.props.PointerProperty(type=properties.LaminaMaterial)
    bpy.types.WindowManager.lamina = bpy.props.PointerProperty(type=panel_layers.LaminaWindow)
    _command = bpy.utils.register_cli_command("lamina", run)
    translation.register()
    swatch_icons.register()
    preset_icons.register()
    asset_library.register()
    keep_in(cache_folder(), lambda told: print(f"Lamina: {told}"))
    for handlers, handler in (*freshness.handlers(), *bakes.handlers()):
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in (*freshness.handlers(), *bakes.handlers()):
        handlers.remove(handler)
    bakes.stop()
    fitting.stop()
    asset_library.unregister()
    preset_icons.unregister()
    swatch_icons.unregister()
    translation.unregister()
    bpy.utils.unregister_cli_command(_command)
    del bpy.types.WindowManager.lamina
    del bpy.types.Material.lamina
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
