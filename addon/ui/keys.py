# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl + Up and Down over the Properties editor move the selected layer. Users may change the keys in Blender's preferences."""

import bpy

from ..operators.layer_operators import LAMINA_OT_layer_move

# What was added, for its removal.
_added: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    config = bpy.context.window_manager.keyconfigs.addon
    if config is None:  # without a window
        return
    keymap = config.keymaps.new(name="Property Editor", space_type="PROPERTIES")
    for key, direction in (("UP_ARROW", "UP"), ("DOWN_ARROW", "DOWN")):
        item = keymap.keymap_items.new(LAMINA_OT_layer_move.bl_idname, key, "PRESS", ctrl=True)
        item.properties.direction = direction
        _added.append((keymap, item))


def unregister() -> None:
    for keymap, item in _added:
        keymap.keymap_items.remove(item)
    _added.clear()
