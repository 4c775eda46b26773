# SPDX-License-Identifier: GPL-3.0-or-later
"""A file with one ball in the sun, for pictures of one material in several surroundings."""

from pathlib import Path

import numpy as np

# Largest difference of a channel's mean of the picture between the branches, as a share: what ramps of 33 knots and folded
# Fresnel curves cost.
AGREE = 0.01


def stage(owner, folder) -> str:
    """A scene with a ball of the material `owner`, saved; its path."""
    import bpy

    from lamina.addon.rendering.geometry import sphere_mesh
    from lamina.addon.rendering.settings import measurement_settings

    scene = bpy.context.scene
    ball = bpy.data.objects.new("ball", sphere_mesh("ball"))
    ball.data.materials.append(owner)
    camera, sun = bpy.data.objects.new("camera", bpy.data.cameras.new("camera")), bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 2.2, (0.0, 0.0, 5.0)
    sun.data.energy, sun.rotation_euler = 2.0, (0.5, 0.3, 0.0)
    for item in (ball, camera, sun):
        scene.collection.objects.link(item)
    scene.camera = camera  # and no world: that of a new one is grey, and would be in the means
    measurement_settings(scene, 16, 32, max_bounces=2)
    path = str(folder / "one.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


def picture(folder, osl: bool) -> np.ndarray:
    """Means of the channels of the open file's scene, by Cycles with OSL or without."""
    import bpy

    from lamina.addon.rendering.settings import render_to

    bpy.context.scene.cycles.shading_system = osl
    render_to(bpy.context.scene, folder / "picture.exr")
    return means(folder / "picture.exr")


def means(path: Path) -> np.ndarray:
    """Means of the channels R, G, B of an EXR picture."""
    from lamina.addon.blender.images import read_exr

    channels = read_exr(path).channels
    named = [next(c for c in channels if c.split(".")[-1] == name) for name in "RGB"]
    return np.array([channels[name].mean() for name in named])
