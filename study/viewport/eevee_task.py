# SPDX-License-Identifier: GPL-3.0-or-later
"""A script for a Blender with EEVEE, where Lamina need not be installed: every material on one object of a scene.

    blender -b FILE.blend --python eevee_task.py -- TASK.json

TASK.json has `scene`, `object`, `materials`, `samples`, `folder`. The picture of material i is folder/i.exr.
"""

import json
import sys
from pathlib import Path

import bpy

ENGINE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"


def render(task: dict) -> None:
    """All pictures of a task."""
    target = bpy.data.objects[task["object"]]
    scene = bpy.data.scenes[task["scene"]]
    _set_up(scene, task["samples"])
    for i, material in enumerate(task["materials"]):
        target.material_slots[0].material = bpy.data.materials[material]
        scene.render.filepath = str(Path(task["folder"], f"{i}.exr"))
        bpy.ops.render.render(write_still=True, scene=scene.name)
        print(f"EEVEE {i}", flush=True)


def _set_up(scene: bpy.types.Scene, samples: int) -> None:
    """Of the file's settings for Cycles the camera, the size and the raw colors stay."""
    scene.render.engine, scene.eevee.taa_render_samples = ENGINE, samples
    scene.render.filter_size = 0.01
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # Blender 5.0
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"


if __name__ == "__main__":
    render(json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text(encoding="utf-8")))
