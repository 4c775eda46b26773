# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that enabling the extension adds to Blender, and its removal."""

import bpy

from ..reference_py.lobes.cache import keep_in
from .blender import translation
from .blender.user_folders import cache_folder
from .jobs import bakes, fitting, older_groups, saving, staleness, stamp_note
from .library import asset_library, preset_icons
from .material import properties, seen_color
from .operators import (
    check_operators,
    exchange_operators,
    fit_operators,
    folder_operators,
    layer_operators,
    mask_link_operators,
    mask_operators,
    material_operators,
    note_operator,
    preset_operators,
    texture_operator,
)
from .ui import keys, panel, panel_layers, preferences, swatch_icons

CLASSES = (
    *properties.CLASSES,
    *material_operators.CLASSES,
    *layer_operators.CLASSES,
    *mask_operators.CLASSES,
    *mask_link_operators.CLASSES,
    *check_operators.CLASSES,
    *note_operator.CLASSES,
    *folder_operators.CLASSES,
    *preset_operators.CLASSES,
    *fit_operators.CLASSES,
    *exchange_operators.CLASSES,
    *texture_operator.CLASSES,
    *panel.CLASSES,
    preferences.LaminaPreferences,
)


def register() -> None:
    """Add the classes, the materials' property, the libraries and the handlers."""
    for cls in CLASSES:
        bpy.utils.register_class(translation.in_context(cls))
    bpy.types.Material.lamina = bpy.props.PointerProperty(type=properties.LaminaMaterial)
    bpy.types.WindowManager.lamina = bpy.props.PointerProperty(type=panel_layers.LaminaWindow)
    seen_color.register()
    translation.register()
    swatch_icons.register()
    preset_icons.register()
    asset_library.register()
    keys.register()
    bpy.types.TOPBAR_MT_file_import.append(exchange_operators.show_import)
    bpy.types.TOPBAR_MT_file_export.append(exchange_operators.show_export)
    keep_in(cache_folder(), lambda message: print(f"Lamina: {message}"))
    for handlers, handler in (*older_groups.handlers(), *staleness.handlers(), *stamp_note.handlers(), *bakes.handlers()):
        handlers.append(handler)


def unregister() -> None:
    for handlers, handler in (*older_groups.handlers(), *staleness.handlers(), *stamp_note.handlers(), *bakes.handlers()):
        handlers.remove(handler)
    bakes.stop()
    fitting.stop()
    saving.stop()
    bpy.types.TOPBAR_MT_file_export.remove(exchange_operators.show_export)
    bpy.types.TOPBAR_MT_file_import.remove(exchange_operators.show_import)
    keys.unregister()
    asset_library.unregister()
    preset_icons.unregister()
    swatch_icons.unregister()
    translation.unregister()
    seen_color.unregister()
    del bpy.types.WindowManager.lamina
    del bpy.types.Material.lamina
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
