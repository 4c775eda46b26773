# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes made with numpy: the measuring sphere and plane, and the ball on its stand that pictures show."""

import bpy
import numpy as np


def mesh_of(name: str, vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, smooth: bool, slots: np.ndarray | None = None) -> bpy.types.Mesh:
    """Mesh from (v, 3) positions, (f, 4) quads (a last index of -1 makes a triangle), (v, 2) UVs, (f,) slots."""
    used = faces >= 0
    loops, corners = faces[used], used.sum(axis=1)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.loops.add(len(loops))
    mesh.polygons.add(len(faces))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", loops.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", np.concatenate([[0], np.cumsum(corners)[:-1]]).astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.full(len(faces), smooth))
    if slots is not None:
        mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv[loops].astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    return mesh


def grid_faces(rows: int, columns: int) -> np.ndarray:
    """Quads ((rows-1) * (columns-1), 4) of a row-major grid of vertices."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    return np.stack([corner, corner + columns, corner + columns + 1, corner + 1], axis=1)


def lathe(name: str, profile: np.ndarray, segments: int, slots: np.ndarray | None = None) -> bpy.types.Mesh:
    """Smooth surface of revolution about z, outside facing out.

    profile: (n, 2) radius and height, from the top down; a radius of 0 at either end closes it with triangles.
    slots: (n - 1,) material slot of each band. U runs around (the seam at -y is welded in position), V downward.
    """
    # the seam's vertices are shared, or the normals would break there; so U jumps back in the last column
    rows = len(profile)
    phi = np.arange(segments) * (2.0 * np.pi / segments) - 0.5 * np.pi
    radius, height = profile[:, 0, None], profile[:, 1, None]
    vertices = np.stack(np.broadcast_arrays(radius * np.cos(phi), radius * np.sin(phi), height), axis=-1)
    corner = np.arange(rows - 1)[:, None] * segments
    here, after = np.arange(segments), np.roll(np.arange(segments), -1)
    faces = np.stack(np.broadcast_arrays(corner + here, corner + segments + here, corner + segments + after, corner + after), axis=-1)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    uv = np.stack(np.broadcast_arrays(here / segments, 1.0 - (length / length[-1])[:, None]), axis=-1)
    # a pole is one vertex: the first of its row
    if profile[0, 0] == 0.0:
        faces[0, :, 0] = 0
        faces[0, :, 3] = -1
    if profile[-1, 0] == 0.0:
        faces[-1, :, 1] = (rows - 1) * segments
        faces[-1, :, 2], faces[-1, :, 3] = faces[-1, :, 3].copy(), -1
    per_face = None if slots is None else np.repeat(slots, segments)
    faces = faces.reshape(-1, 4)
    used = np.unique(faces[faces >= 0])
    renumber = np.full(rows * segments + 1, -1)
    renumber[used] = np.arange(len(used))
    return mesh_of(name, vertices.reshape(-1, 3)[used], renumber[faces], uv.reshape(-1, 2)[used], True, per_face)


def sphere_mesh(name: str, segments: int = 512, rings: int = 256) -> bpy.types.Mesh:
    """Smooth unit sphere about the origin, poles on y, so that a view along z meets no pole.

    With 512 x 256 faces the interpolated normal differs from the position by at most about 1e-4.
    """
    theta = np.linspace(0.0, np.pi, rings + 1)
    profile = np.stack([np.sin(theta), np.cos(theta)], axis=1)
    profile[[0, -1], 0] = 0.0
    mesh = lathe(name, profile, segments)
    position = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", position)
    x, y, z = position.reshape(-1, 3).T
    mesh.vertices.foreach_set("co", np.stack([x, z, -y], axis=1).ravel())
    mesh.update()
    return mesh


def plane_mesh(name: str, half_width: float) -> bpy.types.Mesh:
    """Square in the plane z = 0 about the origin, facing +z, with UVs 0 to 1."""
    uv = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float)
    corners = np.concatenate([(2.0 * uv - 1.0) * half_width, np.zeros((4, 1))], axis=1)
    return mesh_of(name, corners, np.array([[0, 2, 3, 1]]), uv, False)


def round_corners(points: np.ndarray, radii: np.ndarray, steps: int = 10) -> np.ndarray:
    """Polyline (n, 2) whose inner corners are replaced by arcs (quadratic Bezier) reaching `radii` along each side."""
    out = [points[:1]]
    t = np.linspace(0.0, 1.0, steps)[:, None]
    for before, corner, after, radius in zip(points, points[1:], points[2:], radii[1:]):
        start = corner + (before - corner) * min(radius / np.linalg.norm(before - corner), 0.49)
        end = corner + (after - corner) * min(radius / np.linalg.norm(after - corner), 0.49)
        out.append((1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t * t * end)
    return np.concatenate(out + [points[-1:]])


def _arc(start_deg: float, stop_deg: float, radius: float, steps: int) -> np.ndarray:
    theta = np.radians(np.linspace(start_deg, stop_deg, steps))
    return radius * np.stack([np.sin(theta), np.cos(theta)], axis=1)


# polar angles, in degrees from the top, of the ball's two edges along the recessed band, and of its lower end
BAND_TOP, BAND_BOTTOM, BALL_END = 114.0, 121.0, 149.0
BAND_DEPTH = 0.075


def ball_mesh(name: str, segments: int = 256) -> bpy.types.Mesh:
    """Unit ball with a recessed band below its equator: slot 0 the material, slot 1 the core in the band.

    The edges of the band are rounded, so that they catch the light. Open at the bottom, where the stand takes it.
    """
    inner = 1.0 - BAND_DEPTH
    upper = _arc(0.0, BAND_TOP, 1.0, 140)
    upper[0, 0] = 0.0
    lip = round_corners(np.concatenate([_arc(BAND_TOP - 1.8, BAND_TOP, 1.0, 2), _arc(BAND_TOP, BAND_TOP, inner, 1)]), np.full(3, 0.028))
    core = _arc(BAND_TOP, BAND_BOTTOM, inner, 10)
    low_lip = round_corners(np.concatenate([_arc(BAND_BOTTOM, BAND_BOTTOM, inner, 1), _arc(BAND_BOTTOM, BAND_BOTTOM + 1.8, 1.0, 2)]), np.full(3, 0.028))
    lower = _arc(BAND_BOTTOM + 1.9, BALL_END, 1.0, 40)
    upper = upper[upper[:, 1] > lip[0, 1] + 0.002]
    pieces = [upper, lip, core, low_lip, lower]
    slots = np.concatenate([np.full(len(piece), 1 if piece is core else 0) for piece in pieces])[:-1]
    return lathe(name, np.concatenate(pieces), segments, slots)


def stand_mesh(name: str, segments: int = 192) -> bpy.types.Mesh:
    """Low round foot that carries the ball of `ball_mesh` (centre at the origin); its underside is at STAND_FLOOR."""
    r, z = np.sin(np.radians(BALL_END)), np.cos(np.radians(BALL_END))
    points = np.array([[r - 0.06, z - 0.02], [r + 0.015, z + 0.012], [r + 0.035, z - 0.06], [r + 0.17, z - 0.12], [r + 0.17, STAND_FLOOR], [0.0, STAND_FLOOR]])
    return lathe(name, round_corners(points, np.array([0, 0.02, 0.05, 0.035, 0.01, 0])), segments)


STAND_FLOOR = -1.04


def backdrop_mesh(name: str, half_width: float = 14.0, front: float = -9.0, back: float = 4.5, height: float = 11.0, bend: float = 3.0) -> bpy.types.Mesh:
    """Floor at z = 0 that bends up into a wall at y = `back`; V runs from the front edge (0) to the top (1)."""
    angle = np.linspace(0.0, 0.5 * np.pi, 48)
    curve = np.stack([back - bend + bend * np.sin(angle), bend - bend * np.cos(angle)], axis=1)
    path = np.concatenate([[[front, 0.0]], curve, [[back, height]]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    side = np.array([-half_width, half_width])
    vertices = np.stack(np.broadcast_arrays(side, path[:, :1], path[:, 1:]), axis=-1).reshape(-1, 3)
    uv = np.stack(np.broadcast_arrays([0.0, 1.0], (length / length[-1])[:, None]), axis=-1).reshape(-1, 2)
    return mesh_of(name, vertices, grid_faces(len(path), 2)[:, ::-1], uv, True)
