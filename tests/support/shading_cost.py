# SPDX-License-Identifier: GPL-3.0-or-later
"""CPU time of shading and of a render's start, for benchmarks that compare materials in turn."""

import os
import time

import bpy

from lamina.addon.rendering.geometry import plane_mesh
from lamina.addon.rendering.settings import measurement_settings, render_to

# Pixels along a picture that is shaded, and copies of a material whose start is measured.
SIZE, COPIES = 96, 8


def cpu(work) -> float:
    before = time.process_time()
    work()
    return time.process_time() - before


class Scene:
    """Planes, the first of which fills the frame, with a copy each of a material."""

    def __init__(self, folder: str):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene, self.file = bpy.context.scene, os.path.join(folder, "x.exr")
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 1.3, (0.0, 0.0, 50.0)
        self.scene.collection.objects.link(camera)
        self.scene.camera, self.scene.world = camera, bpy.data.worlds.new("world")
        self.scene.world.color = (1.0, 1.0, 1.0)
        self.planes = [bpy.data.objects.new("plane", plane_mesh(f"plane {i}", 1.0)) for i in range(COPIES)]
        for i, plane in enumerate(self.planes):
            self.scene.collection.objects.link(plane)
            plane.location.x = 3.0 * i
            plane.data.materials.append(None)

    def seconds(self, copies: list, osl: bool, size: int, samples: int) -> float:
        measurement_settings(self.scene, samples, size, max_bounces=1)
        self.scene.cycles.shading_system = osl
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 1
        for plane, material in zip(self.planes, copies):
            plane.data.materials[0] = material
            plane.hide_render = False
        for plane in self.planes[len(copies) :]:
            plane.hide_render = True
        return cpu(lambda: render_to(self.scene, self.file))


def least(rounds: int, *ways) -> list[float]:
    """The least seconds of each of several ways, taken in turn; the first round warms up."""
    return [min(seconds) for seconds in zip(*[[way() for way in ways] for _ in range(rounds + 1)][1:])]
