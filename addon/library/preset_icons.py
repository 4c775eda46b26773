# SPDX-License-Identifier: GPL-3.0-or-later
"""Icons of presets, from their thumbnails; read when first drawn."""

from pathlib import Path

import bpy.utils.previews

from . import user_presets
from .preset_catalogues import thumbnail_of

# Kept while the extension is enabled: Blender frees icons with their collection.
_icons: bpy.utils.previews.ImagePreviewCollection | None = None


def preset_icon(name: str) -> int:
    """The icon id of one of Lamina's presets; 0, which draws nothing, where it has no picture."""
    return _icon(thumbnail_of(name))


def user_preset_icon(name: str) -> int:
    """The same for a preset that the user saved."""
    return _icon(user_presets.picture_of(name))


def _icon(path: Path) -> int:
    if _icons is None:
        return 0
    try:
        key = f"{path} {path.stat().st_mtime_ns}"  # a preset saved again has a new picture
    except OSError:
        return 0
    if key not in _icons:
        _icons.load(key, str(path), "IMAGE")
    return _icons[key].icon_id


def register() -> None:
    global _icons
    _icons = bpy.utils.previews.new()


def unregister() -> None:
    global _icons
    if _icons is not None:
        bpy.utils.previews.remove(_icons)
    _icons = None
