# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene's camera sees of an object: under which angles its surface is viewed, and on how many pixels."""

from dataclasses import dataclass

import bpy
import numpy as np

from ...reference_py.errors import LaminaError

# View cosines that stand for all pixels of an object.
_VIEWS = 8


@dataclass(frozen=True, eq=False, repr=False)
class Sight:
    """`cosines` (8,) of the view split the object's pixels evenly; `pixels` is their number. Occlusion is not counted."""

    cosines: np.ndarray
    pixels: float

    def light_deg(self, soft_light_deg: float) -> float:
        """Width in degrees of what soft lights blur to, when each pixel averages the normals that a ball has in it."""
        diameter = np.sqrt(4.0 * max(self.pixels, 1.0) / np.pi)
        return float(np.hypot(soft_light_deg, 2.0 * np.degrees(2.0 / max(diameter, 2.0))))


def sight_of(target: bpy.types.Object, scene: bpy.types.Scene) -> Sight:
    """What the scene's camera sees of an object in the present frame.

    Raises LaminaError without a camera, for an object without a surface, and for one that is not in the picture.
    """
    if scene.camera is None:
        raise LaminaError("scene {scene} has no camera, so nothing is seen of {target}", scene=scene.name, target=target.name)
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = target.evaluated_get(graph)
    try:
        mesh = evaluated.to_mesh()
    except RuntimeError:
        mesh = None
    if mesh is None or not mesh.polygons:
        raise LaminaError("object {target} has no surface", target=target.name)
    try:
        centers, normals, areas = _faces(mesh, evaluated.matrix_world)
    finally:
        evaluated.to_mesh_clear()
    camera = scene.camera.evaluated_get(graph)
    place = np.array(camera.matrix_world.translation)
    if camera.data.type == "ORTHO":
        to_camera = np.broadcast_to(np.array(camera.matrix_world.col[2][:3]), centers.shape)
        distance = np.ones(len(centers))
    else:
        to_camera = place - centers
        distance = np.linalg.norm(to_camera, axis=1)
    to_camera = to_camera / np.maximum(np.linalg.norm(to_camera, axis=1), 1e-12)[:, None]
    cosines = np.sum(normals * to_camera, axis=1)
    inside, pixels_of_area = _projection(camera, scene, graph, centers)
    seen = inside & (cosines > 0.0)
    pixels = np.where(seen, areas * cosines * pixels_of_area / np.square(distance), 0.0)
    if not np.sum(pixels) > 0.0:
        raise LaminaError("object {target} is not in the picture of camera {camera}", target=target.name, camera=scene.camera.name)
    order = np.argsort(cosines)
    share = np.cumsum(pixels[order]) / np.sum(pixels)
    places = np.searchsorted(share, (np.arange(_VIEWS) + 0.5) / _VIEWS)
    return Sight(np.clip(cosines[order][places], 1e-3, 1.0), float(np.sum(pixels)))


def _faces(mesh, matrix) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centers (n, 3), unit normals (n, 3) and areas (n,) of the triangles in the world."""
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    world = np.array(matrix)
    points = points.reshape(-1, 3).astype(float) @ world[:3, :3].T + world[:3, 3]
    triangles = points[corners.reshape(-1, 3)]
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    if np.linalg.det(world[:3, :3]) < 0.0:
        cross = -cross
    length = np.linalg.norm(cross, axis=1)
    return triangles.mean(axis=1), cross / np.maximum(length, 1e-30)[:, None], 0.5 * length


def _projection(camera, scene, graph, centers) -> tuple[np.ndarray, float]:
    """Which points (n, 3) are in the picture, and the pixels of a unit area, facing the camera at distance 1."""
    scale = 0.01 * scene.render.resolution_percentage
    width, height = scene.render.resolution_x * scale, scene.render.resolution_y * scale
    matrix = np.array(camera.calc_matrix_camera(graph, x=int(width), y=int(height)))
    view = np.array(camera.matrix_world.inverted())
    clip = np.c_[centers, np.ones(len(centers))] @ (matrix @ view).T
    inside = np.all(np.abs(clip[:, :2]) <= np.abs(clip[:, 3:]), axis=1) & (clip[:, 3] > 0.0)
    return inside, float(matrix[0, 0] * matrix[1, 1] * width * height / 4.0)
