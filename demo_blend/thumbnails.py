# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the thumbnail of every preset, or of those named, into addon/presets. `make thumbnails` runs it."""

import sys
from pathlib import Path

import bpy

from ..addon.library.preset_catalogues import thumbnail_of
from ..addon.library.thumbnails import render_thumbnail
from ..addon.session import blender, say
from ..reference_py.material import presets
from .materials import preset_material

SAMPLES = 64
# What a listing on Blender's extensions platform shows beside the name: by "icon" in place of presets' names.
ICON, ICON_SIZE, ICON_PRESET = Path(__file__).parents[1] / "tools" / "listing" / "icon.png", 256, "rusted_painted_steel"


def main() -> None:
    report = say("thumbnails")
    names = sys.argv[1:] or presets.names()
    with blender(report):
        if names == ["icon"]:
            render_thumbnail(preset_material(ICON_PRESET), ICON, ICON_SIZE, SAMPLES)
            return
        for i, name in enumerate(names):
            report(f"{100 * i // len(names):3} % {name}")
            bpy.ops.wm.read_factory_settings(use_empty=True)
            render_thumbnail(preset_material(name), thumbnail_of(name), samples=SAMPLES)
    report(f"wrote {len(names)} pictures into {thumbnail_of('any').parent}")


if __name__ == "__main__":
    main()
    import os

    os._exit(0)
