# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the thumbnail of every preset, or of those named, into addon/presets, and lays all of them out on figures/all_presets.png.

`make thumbnails` runs it, and `make preset-sheet` its second half alone.
"""

import sys
from pathlib import Path

import bpy

from ..addon.blender.images import read_png, write_png
from ..addon.library.preset_catalogues import thumbnail_of
from ..addon.library.thumbnails import render_thumbnail
from ..addon.rendering.sheet import Tile, compose
from ..addon.session import blender, say
from ..reference_py.material import presets
from .materials import preset_material

SAMPLES = 64
# What a listing on Blender's extensions platform shows beside the name: by "icon" in place of presets' names.
ICON, ICON_SIZE, ICON_PRESET = Path(__file__).parents[1] / "tools" / "listing" / "icon.png", 256, "rusted_painted_steel"
SHEET, COLUMNS = Path(__file__).parents[1] / "figures" / "all_presets.png", 8


def main() -> None:
    report = say("thumbnails")
    names = [] if sys.argv[1:] == ["sheet"] else sys.argv[1:] or presets.names()
    with blender(report):
        if names == ["icon"]:
            render_thumbnail(preset_material(ICON_PRESET), ICON, ICON_SIZE, SAMPLES)
            return
        for i, name in enumerate(names):
            report(f"{100 * i // len(names):3} % {name}")
            bpy.ops.wm.read_factory_settings(use_empty=True)
            render_thumbnail(preset_material(name), thumbnail_of(name), samples=SAMPLES)
        write_sheet()
    report(f"wrote {len(names)} pictures into {thumbnail_of('any').parent} and all on {SHEET}")


def write_sheet() -> None:
    """All thumbnails with their names on one page."""
    pictures = [read_png(thumbnail_of(name))[0][..., :3] for name in presets.names()]
    write_png(SHEET, compose(pictures, [Tile(presets.label(name), None) for name in presets.names()], COLUMNS, "Lamina presets"))


if __name__ == "__main__":
    main()
    import os

    os._exit(0)
