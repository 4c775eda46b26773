# SPDX-License-Identifier: GPL-3.0-or-later
"""A goniometer and a white furnace made of Cycles: what a bpy material really reflects.

Both render a scene of their own, which is gone afterwards; the user's scenes are left alone.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ..blender.images import read_exr
from ..blender.versions import node_tree
from .geometry import plane_mesh, sphere_mesh
from .settings import add_object, measurement_settings, render_to, scratch_scene

CAMERA_DISTANCE = 100.0
# of the orthographic camera over the plane: so narrow, grazing rays start above the plane up to 89.999 deg
FURNACE_VIEW_WIDTH = 1e-3


def _orthographic_camera(scene: bpy.types.Scene, width: float) -> bpy.types.Object:
    data = bpy.data.cameras.new("Measure")
    data.type, data.ortho_scale = "ORTHO", width
    data.clip_start, data.clip_end = 1e-3, 1e4
    scene.camera = add_object(scene, "Measure", data)
    return scene.camera


def _plain_diffuse() -> bpy.types.Material:
    material = bpy.data.materials.new("Measure normals")
    nodes = node_tree(material).nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def render_sun_sphere(
    material: bpy.types.Material,
    sun_theta_deg: float,
    size: int = 128,
    *,
    window: tuple[float, float, float] = (0.0, 0.0, 1.0),
    device: str = "CPU",
    osl: bool = True,
) -> dict[str, np.ndarray]:
    """Goniometer: a sphere of `material`, seen from +z by an orthographic camera, lit by one parallel sun.

    sun_theta_deg: angle between sun and view, 0 to 180; the sun stands in the plane y = 0, on the side of +x.
    size: pixels along each side. window: centre x, y and half width of the picture, in sphere radii: a small
    one resolves a narrow highlight. device, osl: as in `measurement_settings`.

    Returns, with the top row first,
      radiance (size, size, 3)  f(wi, wo) * max(cos_theta_i, 0): the sun has irradiance 1, so divide by the cosine for f
      normal (size, size, 3)    N of the sphere as Cycles shades it (float32), 0 beside the sphere; it comes from a
                                plain diffuse material, because the pass is the mean of the closures' normals
      position (size, size, 3)  hit point in sphere radii
      mask (size, size)         True on the sphere
      wi, wo (3,)               unit directions to the sun and to the viewer
    all in world axes. Poles are on y and tangents of UVMap run around y. One sample, no bounces, no noise.

    Precision [measured against float64 formulas]: lobes of alpha .3 and more agree to 1e-6 (median). Narrower isotropic
    ones carry Cycles' own float32 error of 1 - cos^2 of the half angle: relative error 6e-8 / alpha^2 (median),
    3e-7 / alpha^2 (99 %), so 2 and 7 % at alpha .002. With alpha_x and alpha_y apart by one part in a million, Cycles
    uses the half vector's x and y instead: 1e-5 and 1e-4 at alpha .002.
    Raises LaminaError for an angle out of range or a window beside the sphere.
    """
    x, y, half = window
    if not 0.0 <= sun_theta_deg <= 180.0:
        raise LaminaError(f"sun_theta_deg {sun_theta_deg}: must be from 0 to 180")
    if half <= 0.0 or np.hypot(x, y) >= 1.0 + half:
        raise LaminaError(f"window {window}: needs a half width above 0 and a centre near the unit disc")
    with scratch_scene("Lamina sun sphere") as scene, tempfile.TemporaryDirectory() as folder:
        measurement_settings(scene, 1, size, device=device, osl=osl)
        _orthographic_camera(scene, 2.0 * half).location = (x, y, CAMERA_DISTANCE)
        light = bpy.data.lights.new("Sun", "SUN")
        light.energy, light.angle = 1.0, 0.0
        light.use_shadow = False  # facets near the terminator would shadow each other
        sun = add_object(scene, "Sun", light)
        sun.rotation_euler = (0.0, np.radians(sun_theta_deg), 0.0)
        ball = add_object(scene, "Sphere", sphere_mesh("Sphere"))
        ball.data.materials.append(material)
        beauty, geometry = scene.view_layers[0], scene.view_layers.new("Geometry")
        beauty.name = "Beauty"
        plain = _plain_diffuse()
        try:
            geometry.material_override = plain
            geometry.use_pass_normal = geometry.use_pass_position = True
            render_to(scene, Path(folder, "sun.exr"))
            # not matrix_world, which nothing has updated in this scene
            wi = np.array(sun.rotation_euler.to_matrix().col[2], float)
        finally:
            bpy.data.materials.remove(plain)
        picture = read_exr(Path(folder, "sun.exr"))
    normal = picture.layer("Geometry.Normal", "XYZ")
    mask = np.linalg.norm(normal, axis=-1) > 0.5
    return {
        "radiance": picture.layer("Beauty.Combined"),
        "normal": normal,
        "mask": mask,
        "position": picture.layer("Geometry.Position", "XYZ") * mask[..., None],
        "wi": wi,
        "wo": np.array([0.0, 0.0, 1.0]),
    }


def render_furnace(
    material: bpy.types.Material, theta_deg_list: Sequence[float], samples: int = 64, size: int = 32, *, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """White furnace: directional albedo of `material` at view angles `theta_deg_list` (degrees from the normal).

    A plane under a world of radiance 1, looked at along one direction, size * size pixels of `samples` samples each.
    The view leaves the surface in the plane y = 0, toward +x, the direction of the plane's U. The world is found by
    the BSDF's own samples alone (no light sampling): unbiased for rough and mirror lobes alike, and with little
    noise, since a sample's weight is the lobe's reflectance. What is scattered below the surface counts as well.

    Returns albedo (n, 3) and its standard error (n, 3), from the spread of the pixels; each angle has its own seed.
    Raises LaminaError for angles outside 0 (inclusive) to 90 (exclusive) or fewer than two pixels.
    """
    thetas = np.atleast_1d(np.asarray(theta_deg_list, float))
    if np.any(~((thetas >= 0.0) & (thetas < 90.0))):
        raise LaminaError(f"theta_deg_list {thetas.tolist()}: every angle must be from 0 up to, not including, 90")
    if size < 2:
        raise LaminaError(f"size {size}: at least 2 pixels a side are needed for a standard error")
    albedo, stderr = np.empty((len(thetas), 3)), np.empty((len(thetas), 3))
    with scratch_scene("Lamina furnace") as scene, tempfile.TemporaryDirectory() as folder:
        scene.world = bpy.data.worlds.new("Furnace")
        background = _white_background(scene.world)
        background.inputs["Strength"].default_value = 1.0
        scene.world.cycles.sampling_method = "NONE"
        plane = add_object(scene, "Plane", plane_mesh("Plane", 1e3))
        plane.data.materials.append(material)
        camera = _orthographic_camera(scene, FURNACE_VIEW_WIDTH)
        for i, theta in enumerate(np.radians(thetas)):
            # one bounce takes the path from the plane to the world
            measurement_settings(scene, samples, size, max_bounces=1, seed=seed + i)
            camera.rotation_euler = (0.0, theta, 0.0)
            camera.location = CAMERA_DISTANCE * np.array([np.sin(theta), 0.0, np.cos(theta)])
            render_to(scene, Path(folder, "furnace.exr"))
            layer = f"{scene.view_layers[0].name}.Combined"
            pixels = read_exr(Path(folder, "furnace.exr")).layer(layer).reshape(-1, 3)
            albedo[i] = pixels.mean(axis=0)
            stderr[i] = pixels.std(axis=0, ddof=1) / np.sqrt(len(pixels))
    return albedo, stderr


def _white_background(world: bpy.types.World) -> bpy.types.Node:
    tree = node_tree(world)
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return background
