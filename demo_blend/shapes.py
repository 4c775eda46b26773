# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of the demo scenes, made with numpy; lengths in metres."""

import bpy
import numpy as np

from ..addon.rendering.geometry import lathe, mesh_of, round_corners


def loft(name: str, rings: np.ndarray, smooth: bool = True) -> bpy.types.Mesh:
    """Skin over closed `rings` (n, m, 3), counterclockwise when seen from the last one, with flat ends."""
    n, m = rings.shape[:2]
    corner = np.arange(n - 1)[:, None] * m
    here, after = np.arange(m), np.roll(np.arange(m), -1)
    skin = np.stack(np.broadcast_arrays(corner + here, corner + after, corner + m + after, corner + m + here), axis=-1)
    # fans about the ends' centres, on vertices of their own so that the edge stays sharp
    first, last = n * m + np.arange(m), n * m + m + np.arange(m)
    none = np.full(m, -1)
    fans = [
        np.stack([np.full(m, centre), a, b, none], axis=-1)
        for centre, a, b in ((n * m + 2 * m, np.roll(first, -1), first), (n * m + 2 * m + 1, last, np.roll(last, -1)))
    ]
    vertices = np.concatenate([rings.reshape(-1, 3), rings[0], rings[-1], [rings[0].mean(axis=0), rings[-1].mean(axis=0)]])
    faces = np.concatenate([skin.reshape(-1, 4), *fans])
    return mesh_of(name, vertices, faces, np.zeros((len(vertices), 2)), smooth)


def tube(name: str, path: np.ndarray, radius: float, around: int = 24) -> bpy.types.Mesh:
    """Round tube along `path` (n, 3), which must lie in a plane through it and the y axis's direction."""
    forward = np.gradient(path, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    side = np.array([0.0, 1.0, 0.0])
    up = np.cross(forward, side)
    phi = 2.0 * np.pi * np.arange(around) / around
    return loft(name, path[:, None] + radius * (np.cos(phi)[:, None] * side + np.sin(phi)[:, None] * up[:, None]))


def turned(
    name: str, points: list[tuple[float, float]], radius: float | list[float], segments: int = 96, steps: int = 10, marks: dict[int, int] | None = None
) -> bpy.types.Mesh:
    """Solid of revolution about z through `points` (radius, height) from the top down, inner corners rounded by `radius`.

    `marks` maps the index of a point to the material slot of what lies below it; above the first mark it is 0.
    """
    points = np.asarray(points, float)
    profile = round_corners(points, np.broadcast_to(np.asarray(radius, float), len(points)), steps)
    profile = profile[np.concatenate([[True], np.linalg.norm(np.diff(profile, axis=0), axis=1) > 1e-6])]
    slots = np.zeros(len(profile) - 1, int)
    for index, slot in (marks or {}).items():
        slots[np.argmin(np.linalg.norm(profile - points[index], axis=1)) :] = slot
    return lathe(name, profile, segments, slots)


def ball(name: str, radius: float, segments: int = 128) -> bpy.types.Mesh:
    """Sphere about the origin with its poles on z."""
    theta = np.linspace(0.0, np.pi, segments // 2 + 1)
    profile = radius * np.stack([np.sin(theta), np.cos(theta)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(name, profile, segments)


def polygon_ring(corners: int, radius: float, bevel: int = 4) -> np.ndarray:
    """(corners * bevel, 2) points of a regular polygon with rounded corners, counterclockwise."""
    angle = 2.0 * np.pi * (np.arange(corners) + 0.5) / corners
    tips = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    before, after = np.roll(tips, 1, axis=0), np.roll(tips, -1, axis=0)
    t = np.linspace(0.0, 1.0, bevel)[:, None, None]
    start, end = tips + 0.08 * (before - tips), tips + 0.08 * (after - tips)
    return np.transpose((1 - t) ** 2 * start + 2 * t * (1 - t) * tips + t * t * end, (1, 0, 2)).reshape(-1, 2)


def needles(name: str, count: int, length: float, radius: float, seed: int) -> bpy.types.Mesh:
    """A fir twig along x from the origin: thin triangles of `radius` (half width) around a stem."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, length, count))
    phi = rng.uniform(0.0, 2.0 * np.pi, count)
    lean = rng.uniform(0.5, 0.9, count)
    reach = (0.16 + 0.05 * rng.random(count)) * (1.15 - 0.6 * x / length)
    along = np.stack([np.cos(lean), np.sin(lean) * np.cos(phi), np.sin(lean) * np.sin(phi)], axis=1)
    foot = np.stack([x, np.zeros(count), -0.12 * np.square(x)], axis=1)
    side = np.cross(along, rng.normal(size=(count, 3)))
    side *= radius / np.linalg.norm(side, axis=1, keepdims=True)
    vertices = np.stack([foot - side, foot + side, foot + reach[:, None] * along], axis=1).reshape(-1, 3)
    corner = 3 * np.arange(count)
    faces = np.stack([corner, corner + 1, corner + 2, np.full(count, -1)], axis=1)
    return mesh_of(name, vertices, faces, np.zeros((len(vertices), 2)), False)


def rounded_box(name: str, size: tuple[float, float, float], radius: float, steps: int = 4) -> bpy.types.Mesh:
    """Box about the origin with edges rounded by `radius`; lines beside the round keep its sides flat."""
    half, turn = 0.5 * np.asarray(size), np.radians(np.linspace(0.0, 90.0, steps + 1))

    def ring(inset: float) -> np.ndarray:
        x, y = half[0] - radius, half[1] - radius
        r = max(radius - inset, 0.01 * radius)
        corners = []
        for quarter, (a, b) in enumerate(((x, y), (-x, y), (-x, -y), (x, -y))):
            angle = turn + 0.5 * np.pi * quarter
            corners.append(np.stack([a + r * np.cos(angle), b + r * np.sin(angle)], axis=1))
        points = np.concatenate(corners)
        gaps = []
        for here, after in zip(points, np.roll(points, -1, axis=0)):
            gaps.append(here[None])
            if np.linalg.norm(after - here) > 3.0 * radius:
                gaps.append(here + (after - here) * np.array([[0.02], [0.5], [0.98]]))
        return np.concatenate(gaps)

    turned_in = [(radius * (1.0 - np.sin(a)), radius * (1.0 - np.cos(a)) - half[2]) for a in turn]
    straight = [(0.0, z) for z in np.array([-0.96, 0.0, 0.96]) * (half[2] - radius)]
    rings = [
        np.column_stack([points, np.full(len(points), z)]) for d, z in (*turned_in, *straight, *((d, -z) for d, z in turned_in[::-1])) for points in [ring(d)]
    ]
    return loft(name, np.stack(rings))
