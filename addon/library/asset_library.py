# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets as asset libraries of Blender's, to drag and drop: registered with the extension, removed with it."""

from pathlib import Path

import bpy

from ..blender.user_folders import presets_folder
from .preset_catalogues import FOLDER

NAME, OWN_NAME = "Lamina", "Lamina Own Presets"
# What the folders' paths end with, wherever they are.
_ENDS = (FOLDER.parts[-3:], ("lamina", "presets"))


def register() -> None:
    """Name the folder of the presets an asset library, and that of the user's own if there is one, unless they are already."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for lost in [library for library in libraries if _is_ours(library) and not Path(library.path).is_dir()]:
        libraries.remove(lost)  # of a Lamina that was deleted or moved without being disabled
    _add(NAME, FOLDER)
    show_own()


def show_own() -> None:
    """Name the folder of the user's presets an asset library, once there is one."""
    if presets_folder().is_dir():
        _add(OWN_NAME, presets_folder())


def unregister() -> None:
    """Remove these libraries; all others stay, those named alike too."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for library in [library for library in libraries if Path(library.path) in (FOLDER, presets_folder())]:
        libraries.remove(library)


def _add(name: str, folder: Path) -> None:
    libraries = bpy.context.preferences.filepaths.asset_libraries
    if not any(Path(library.path) == folder for library in libraries):
        library = libraries.new(name=name, directory=str(folder))
        # a copy per drop: a preset dropped twice is two materials that can be edited apart
        library.import_method = "APPEND"


def _is_ours(library) -> bool:
    """Whether a library's folder is a Lamina's, of this one or of another."""
    parts = Path(library.path).parts
    return any(parts[-len(end) :] == end for end in _ENDS)
