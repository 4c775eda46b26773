# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets as an asset library of Blender's, to drag and drop: registered with the extension, removed with it."""

from pathlib import Path

import bpy

from .preset_catalogues import FOLDER

NAME = "Lamina"


def register() -> None:
    """Name the folder of the presets an asset library, unless it is one already."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for lost in [library for library in _ours() if not Path(library.path).is_dir()]:
        libraries.remove(lost)  # of a Lamina that was deleted or moved without being disabled
    if not any(_is_here(library) for library in libraries):
        library = libraries.new(name=NAME, directory=str(FOLDER))
        # a copy per drop: a preset dropped twice is two materials that can be edited apart
        library.import_method = "APPEND"


def unregister() -> None:
    """Remove that library; all others stay, those named alike too."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for library in [library for library in libraries if _is_here(library)]:
        libraries.remove(library)


def _ours() -> list:
    """Libraries whose folder is a Lamina's, of this one or of another."""
    return [library for library in bpy.context.preferences.filepaths.asset_libraries if Path(library.path).parts[-3:] == FOLDER.parts[-3:]]


def _is_here(library) -> bool:
    return Path(library.path) == FOLDER
