# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear pictures as a scene's view transform shows them."""

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import bpy
import numpy as np

from ..blender.images import read_png
from .settings import scratch_scene, studio_settings


def displayed(linear: np.ndarray, view: Mapping, report: Callable[[str], None]) -> np.ndarray:
    """A linear picture (h, w, 3) as uint8 (h, w, 3) for the display, as Blender itself writes it.

    `view` has the settings of its scene, as `batch.task.view_of` gives them; what it lacks is the studio's, and what
    this Blender lacks goes to `report`.
    """
    height, width = linear.shape[:2]
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = linear
    image = bpy.data.images.new("Lamina view", width, height, float_buffer=True)
    try:
        with scratch_scene("Lamina view") as scene, tempfile.TemporaryDirectory() as folder:
            studio_settings(scene, 1, 1)
            for name, value in view.items():
                owner = scene.display_settings if name == "display_device" else scene.view_settings
                try:
                    setattr(owner, name, value)
                except TypeError:  # a transform of another version, or of another configuration of OpenColorIO
                    report(f"this Blender has no {name.replace('_', ' ')} {value!r}; shown with {getattr(owner, name)!r} instead")
            image.pixels.foreach_set(np.ascontiguousarray(rgba[::-1]).ravel())
            image.save_render(str(Path(folder, "view.png")), scene=scene)
            return read_png(Path(folder, "view.png"))[0][..., :3]
    finally:
        bpy.data.images.remove(image)
