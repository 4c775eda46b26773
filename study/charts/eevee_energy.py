# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart eevee`: how bright every preset is in EEVEE against Cycles' stock nodes in a white world, at ten views of a plane.

A strip of planes, each tilted further, bends away from the camera, so that none hides light from another. EEVEE keeps light in numbers of 11 and 10
bits, which are cut off: 0 to 1.6 % of red and green and 0 to 3.1 % of blue are lost by that alone, of any material.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ...addon.blender.images import read_exr
from ...addon.blender.versions import node_tree
from ...addon.material.material import apply_stack, refresh
from ...addon.material.roles import EEVEE_OUTPUT, node_with
from ...addon.rendering.settings import add_object, measurement_settings, render_to, scratch_scene
from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.material import presets
from ..pareto.surface_types import load_surface
from ..tables import Report, write_table
from ..viewport.eevee_pictures import blender_version, eevee_pictures
from .output import print_table

THETA_DEG = (0.0, 15.0, 30.0, 45.0, 55.0, 65.0, 72.0, 78.0, 83.0, 86.0)
COLUMNS = ("preset", "output", "worst", *(f"{t:g}" for t in THETA_DEG))
_CELL, _SAMPLES, _EEVEE_SAMPLES, _FAR = 8, 256, 32, 200.0
_OWN, _SHARED = "EEVEE's own", "shared"


def chart(folder: Path, report: Report, surface: Sequence[str] = ()) -> None:
    """Write eevee_energy.csv and print it. `surface` names presets or stacks of the suite instead of all presets. Raises LaminaError."""
    table = folder / "eevee_energy.csv"
    require_writable(table)
    version = blender_version()
    names = surface or presets.names()
    with blender(lambda text: None), scratch_scene("EEVEE energy") as scene, tempfile.TemporaryDirectory() as scratch:
        item, materials, cycles = _set_up(scene), [], []
        for name in names:
            report(name)
            material = bpy.data.materials.new(name)
            apply_stack(material, load_surface(name))
            refresh(material, settle=True)
            item.material_slots[0].material = material
            render_to(scene, Path(scratch, "cycles.exr"))
            cycles += 2 * [_cells(read_exr(Path(scratch, "cycles.exr")).layer("ViewLayer.Combined"))]
            materials += [material, _without_own(material)]
        apart = [100.0 * (_cells(picture) / here - 1.0) for picture, here in zip(eevee_pictures(scene, item, materials, _EEVEE_SAMPLES, report), cycles)]
    worst = [cells[np.arange(len(THETA_DEG)), np.argmax(np.abs(cells), axis=1)] for cells in apart]
    rows = [[names[i // 2], (_OWN, _SHARED)[i % 2], *(f"{v:.1f}" for v in (row[np.argmax(np.abs(row))], *row))] for i, row in enumerate(worst)]
    heading = ("lamina chart eevee", f"Blender {version}: EEVEE over Cycles' stock nodes minus 1 in percent, worst channel, by the view in degrees")
    write_table(table, heading, COLUMNS, rows, report)
    print_table(COLUMNS, rows)


def _without_own(material: bpy.types.Material) -> bpy.types.Material:
    """A copy that shows EEVEE the stock nodes that Cycles shows."""
    shared = material.copy()
    if output := node_with(shared, EEVEE_OUTPUT):
        shared.node_tree.nodes.remove(output)
    return shared


def _cells(picture: np.ndarray) -> np.ndarray:
    """The mean of each plane's middle, (views, 3)."""
    return np.array([picture[2:-2, _CELL * i + 2 : _CELL * (i + 1) - 2].mean(axis=(0, 1)) for i in range(len(THETA_DEG))])


def _set_up(scene: bpy.types.Scene) -> bpy.types.Object:
    """A white world, the strip of planes, and a camera that looks along the first one's normal."""
    world = scene.world = bpy.data.worlds.new("White")
    node_tree(world).nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    world.sun_threshold = 0.0
    slopes = np.tan(np.radians(THETA_DEG))
    heights = -np.cumsum(slopes + np.concatenate([[0.0], slopes[:-1]])) / 2.0
    corners = [(-0.4, -0.45), (0.4, -0.45), (0.4, 0.45), (-0.4, 0.45)]
    places = [(i + x, y, height - x * slope) for i, (height, slope) in enumerate(zip(heights, slopes)) for x, y in corners]
    mesh = bpy.data.meshes.new("Strip")
    mesh.from_pydata(places, [], [list(range(4 * i, 4 * i + 4)) for i in range(len(THETA_DEG))])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.tile([0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0], len(THETA_DEG)))
    mesh.materials.append(None)
    camera = bpy.data.cameras.new("Above")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", float(len(THETA_DEG)), 1e3
    scene.camera = add_object(scene, "Above", camera)
    scene.camera.location = ((len(THETA_DEG) - 1) / 2.0, 0.0, _FAR)
    measurement_settings(scene, _SAMPLES, (_CELL * len(THETA_DEG), _CELL))
    scene.cycles.shading_system = False
    return add_object(scene, "Strip", mesh)
