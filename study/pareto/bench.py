# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the measurements, where one sample stands at a time, and what a render of them costs."""

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...addon.blender.images import read_exr
from ...addon.blender.interrupt import interruptible
from ...addon.blender.versions import node_tree
from ...addon.rendering.geometry import plane_mesh, sphere_mesh
from ...addon.rendering.settings import add_object, measurement_settings, render_to, scratch_scene
from .ball_picture import Surroundings

# A path in a slab must be able to end; one that leaves a ball at once does not notice.
MAX_BOUNCES = 24
SEGMENTS, RINGS = 192, 96
# Half width: Cycles would lose the gap of a slab in the rounding of a large plane.
_PLANE = 4.0
_DISTANCE = 100.0
# The part of the ball that fills the frame, in radii.
_FILLING = 1.4


class Stage:
    """A scene whose sample, a list of objects, can be changed."""

    def __init__(self, scene: bpy.types.Scene, size: int):
        self.scene, self.size = scene, size
        self._sample: list[bpy.types.Object] = []
        data = bpy.data.cameras.new("Pareto")
        data.type, data.ortho_scale, data.clip_end = "ORTHO", 2.0, 1e4
        scene.camera = add_object(scene, "Pareto", data)
        scene.camera.location = (0.0, 0.0, _DISTANCE)
        scene.world = bpy.data.worlds.new("Pareto")
        node_tree(scene.world)

    def show(self, sample: list[bpy.types.Object]) -> None:
        objects = self.scene.collection.objects
        for item in self._sample:
            objects.unlink(item)
        for item in sample:
            objects.link(item)
        self._sample = sample

    def clear(self) -> None:
        """Let the samples outlive the scene."""
        self.show([])

    def settings(self, samples: int, seed: int = 0, size: int | None = None) -> None:
        measurement_settings(self.scene, samples, size or self.size, max_bounces=MAX_BOUNCES, seed=seed)

    def seconds(self, samples: int, size: int | None = None) -> float:
        """CPU time in seconds of a render whose picture is thrown away."""
        self.settings(samples, size=size)
        return render_seconds(self.scene)

    def picture(self, samples: int, seed: int = 0) -> np.ndarray:
        """Radiance (size, size, 3), the top row first."""
        self.settings(samples, seed)
        with tempfile.TemporaryDirectory() as folder:
            render_to(self.scene, Path(folder, "pareto.exr"))
            return read_exr(Path(folder, "pareto.exr")).layer(f"{self.scene.view_layers[0].name}.Combined")


def render_seconds(scene: bpy.types.Scene) -> float:
    """CPU time of all threads for one render."""
    start = time.process_time()
    with interruptible():
        bpy.ops.render.render(scene=scene.name)
    return time.process_time() - start


@contextmanager
def sun_stage(size: int) -> Iterator[Stage]:
    """A ball that fills the frame under a soft sun and an even sky: nothing but shading."""
    with scratch_scene("Lamina pareto sun") as scene:
        stage = Stage(scene, size)
        scene.camera.data.ortho_scale = _FILLING
        light = bpy.data.lights.new("Sun", "SUN")
        light.energy, light.angle = 2.0, 0.5
        add_object(scene, "Sun", light).rotation_euler = (0.0, 0.7, 0.0)
        _background(scene.world).inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
        try:
            yield stage
        finally:
            stage.clear()


@contextmanager
def studio_stage(size: int, surroundings: Surroundings) -> Iterator[Stage]:
    """A ball that fills the picture in surroundings that numpy knows as well."""
    with scratch_scene("Lamina pareto studio") as scene:
        stage = Stage(scene, size)
        image = _image(surroundings)
        try:
            tree = scene.world.node_tree
            sky = tree.nodes.new("ShaderNodeTexEnvironment")
            sky.image = image
            tree.links.new(sky.outputs["Color"], _background(scene.world).inputs["Color"])
            scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = "MANUAL", surroundings.height
            yield stage
        finally:
            stage.clear()
            bpy.data.images.remove(image)


def _image(surroundings: Surroundings) -> bpy.types.Image:
    height, width = surroundings.texels.shape
    image = bpy.data.images.new("Pareto surroundings", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = surroundings.texels[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


@contextmanager
def furnace_stage(size: int) -> Iterator[Stage]:
    """A plane that fills the frame, its world an even one that light finds by the surface's own samples alone."""
    with scratch_scene("Lamina pareto furnace") as scene:
        stage = Stage(scene, size)
        scene.camera.data.ortho_scale = 1e-3
        scene.world.cycles.sampling_method = "NONE"
        try:
            yield stage
        finally:
            stage.clear()


def _background(world: bpy.types.World) -> bpy.types.Node:
    return next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")


def look_along(stage: Stage, theta_deg: float) -> None:
    """Turn the camera of a furnace; the view leaves the surface in the plane y = 0, toward +x."""
    theta = np.radians(theta_deg)
    stage.scene.camera.rotation_euler = (0.0, theta, 0.0)
    stage.scene.camera.location = _DISTANCE * np.array([np.sin(theta), 0.0, np.cos(theta)])


def ball(depth: float = 0.0) -> bpy.types.Mesh:
    """Mesh of the unit ball's surface at a depth below it."""
    mesh = sphere_mesh("Pareto", SEGMENTS, RINGS)
    _move(mesh, scale=1.0 - depth)
    return mesh


def plane(depth: float = 0.0) -> bpy.types.Mesh:
    mesh = plane_mesh("Pareto", _PLANE)
    _move(mesh, down=depth)
    return mesh


def corner() -> list[bpy.types.Mesh]:
    """Meshes of a ball on a floor between two walls, seen from above."""
    floor, left, back = (plane(1.0) for _ in range(3))
    left.transform(Matrix.Rotation(np.pi / 2, 4, "Y"))
    back.transform(Matrix.Rotation(np.pi / 2, 4, "X"))
    return [ball(), floor, left, back]


def _move(mesh: bpy.types.Mesh, scale: float = 1.0, down: float = 0.0) -> None:
    place = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", place)
    mesh.vertices.foreach_set("co", scale * place - np.tile([0.0, 0.0, down], len(mesh.vertices)))
    mesh.update()


def with_material(mesh: bpy.types.Mesh, material: bpy.types.Material) -> bpy.types.Object:
    """An object that shares a mesh and has a material of its own."""
    if not mesh.materials:
        mesh.materials.append(None)
    item = bpy.data.objects.new("Pareto", mesh)
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = material
    return item
