# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the picture of a preset in a Blender of its own, so that the window stays free, and puts it into the preset's asset.

`command` starts it with a folder, in which the asset is; it prints lines "progress SHARE", and at last "result {}" or "error
JSON", a packed `Sentence`.
"""

import json
import os
import re
import sys
from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError
from ..blender.blend_files import save_material
from .thumbnails import give_preview, pixels_of, render_thumbnail

ASSET, PICTURE = "preset.blend", "preset.png"
_ROOT = Path(__file__).resolve().parents[2]
# The package may be installed under any name; here it is imported by its place. Registered, as Blender keeps no properties that it does not know.
_START = """
import importlib.util, sys
root, folder = sys.argv[-2:]
spec = importlib.util.spec_from_file_location("lamina", root + "/__init__.py", submodule_search_locations=[root])
sys.modules["lamina"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["lamina"])
sys.modules["lamina"].register()
from lamina.addon.library.preset_process import main
main(folder)
"""


def command(folder: Path) -> list[str]:
    """The command line: this Blender again, or this Python with its bpy."""
    if bpy.app.module:
        return [sys.executable, "-c", _START, str(_ROOT), str(folder)]
    return [bpy.app.binary_path, "--background", "--factory-startup", "-noaudio", "--python-expr", _START, "--", str(_ROOT), str(folder)]


def main(folder: str) -> None:
    """Serve one preset and leave at once: a Blender that ends in order may take long."""
    try:
        draw(Path(folder))
        print("result {}", flush=True)
    except LaminaError as error:
        print(f"error {json.dumps(error.sentence.packed())}", flush=True)
    os._exit(0)


def draw(folder: Path) -> None:
    """Write the picture of the asset beside it, and the asset with it as its preview. Raises LaminaError."""
    asset = folder / ASSET
    try:
        with bpy.data.libraries.load(str(asset), link=False, assets_only=True) as (there, here):
            here.materials = list(there.materials)
    except (OSError, RuntimeError) as error:
        raise LaminaError("{asset}: Blender cannot read it: {reason}", asset=asset, reason=" ".join(str(error).split())) from None
    material = here.materials[0]
    bpy.app.handlers.render_stats.append(_tell)
    render_thumbnail(material, folder / PICTURE)
    give_preview(material, pixels_of(folder / PICTURE))
    save_material(asset, material)


def _tell(*arguments) -> None:
    for text in arguments:
        if isinstance(text, str) and (found := re.search(r"Sample (\d+)/(\d+)", text)):
            print(f"progress {int(found[1]) / int(found[2]):.3f}", flush=True)
