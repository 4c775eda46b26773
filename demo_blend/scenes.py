# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scenes: `python -m lamina.demo_blend.scenes build [NAME...]` writes their .blend files, `render` their pictures.

`make blends` and `make scenes` run it.
"""

import argparse
import shutil
import tempfile
from importlib import import_module
from pathlib import Path

import bpy

from ..addon.blender.blend_files import save_copy
from ..addon.rendering.settings import render_to
from ..addon.session import blender, say
from ..reference_py.atomic import output_folder, replacing

NAMES = ("still_life", "crayons_and_mugs", "tree_ornaments", "copper_vases", "thickness_series", "car_paint_turntable", "white_furnace", "tin_toy")
FOLDER = Path(__file__).parent
PICTURES = FOLDER.parent / "figures" / "scenes"
WIDTH, SAMPLES = 640, 16
# Pictures that are shown alone.
WIDE = {"tin_toy": 1280}


def build_scene(name: str, settle: bool = True) -> bpy.types.Scene:
    """The named scene in the running Blender, in place of what was there."""
    scene = import_module(f".{name}", __package__).build(settle)
    scene.cycles.shading_system = True
    return scene


def render_scene(scene: bpy.types.Scene, output: Path, width: int = WIDTH) -> None:
    """Write a JPEG of a scene, `width` pixels wide, whole or not at all; with fewer samples than the file asks for."""
    scene.render.resolution_percentage, scene.cycles.samples = 100, min(scene.cycles.samples, SAMPLES)
    scene.render.resolution_y = round(scene.render.resolution_y * width / scene.render.resolution_x)
    scene.render.resolution_x = width
    for stamp in [name for name in dir(scene.render) if name.startswith("use_stamp_")]:
        setattr(scene.render, stamp, False)  # no date, no path in the picture
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 88
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder, "scene.jpg")
        render_to(scene, picture)
        with replacing(output) as temporary:
            shutil.copyfile(picture, temporary)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("action", choices=("build", "render"))
    parser.add_argument("names", nargs="*", choices=[*NAMES, []], metavar="NAME", help="scenes (default: all)")
    options = parser.parse_args()
    report = say("scenes")
    with blender(report):
        for name in options.names or NAMES:
            blend = FOLDER / f"{name}.blend"
            if options.action == "build":
                build_scene(name)
                save_copy(blend)
                report(f"wrote {blend}")
            else:
                bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False)
                render_scene(bpy.context.scene, output_folder(PICTURES) / f"{name}.jpg", WIDE.get(name, WIDTH))
                report(f"wrote {PICTURES / name}.jpg")


if __name__ == "__main__":
    main()
    import os

    os._exit(0)
