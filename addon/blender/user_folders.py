# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's folders that Lamina writes to: what was baked, and saved presets. Imports bpy only inside Blender's extensions."""

import os
import sys
from pathlib import Path

from ...reference_py.lobes.cache import FOLDER_VARIABLE as CACHE_VARIABLE

PRESETS_VARIABLE = "LAMINA_PRESETS"
# Blender asks for the name of the extension itself, bl_ext.REPOSITORY.lamina.
_EXTENSION = __package__.rsplit(".", 2)[0]


def cache_folder() -> Path:
    """Where what was baked is kept between sessions: LAMINA_CACHE, else the extension's own, else in the user's cache."""
    return _folder("bakes", CACHE_VARIABLE, "LOCALAPPDATA", "XDG_CACHE_HOME", ".cache")


def presets_folder() -> Path:
    """Where the user's presets are: LAMINA_PRESETS, else the extension's own, which updates leave alone, else in the user's data."""
    return _folder("presets", PRESETS_VARIABLE, "APPDATA", "XDG_DATA_HOME", ".local/share")


def _folder(name: str, variable: str, windows: str, unix: str, unix_default: str) -> Path:
    """A folder that need not exist."""
    if given := os.environ.get(variable):
        return Path(given).expanduser()
    if _EXTENSION.startswith("bl_ext."):
        import bpy

        return Path(bpy.utils.extension_path_user(_EXTENSION, path=name))
    if sys.platform == "win32":
        return Path(os.environ.get(windows) or Path.home(), "lamina", name)
    return Path(os.environ.get(unix) or Path.home() / unix_default, "lamina", name)
