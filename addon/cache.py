# SPDX-License-Identifier: GPL-3.0-or-later
"""Where what was baked is kept between sessions. Imports bpy only inside Blender's extensions."""

import os
import sys
from pathlib import Path

from ..reference_py.network.memory import FOLDER_VARIABLE


def cache_folder() -> Path:
    """The folder of the environment variable LAMINA_CACHE, else the extension's own, else the user's cache."""
    if folder := os.environ.get(FOLDER_VARIABLE):
        return Path(folder).expanduser()
    package = __package__.rpartition(".")[0]
    if package.startswith("bl_ext."):
        import bpy

        return Path(bpy.utils.extension_path_user(package, path="bakes"))
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home(), "lamina", "bakes")
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "lamina", "bakes")
