# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact sheets: many materials on the same ball in the same light, each with its name, on one page."""

import os
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ..blender.images import read_exr, read_png, write_png
from ..blender.versions import node_tree
from .settings import add_object, measurement_settings, render_to, scratch_scene
from .studio import build_ball_scene

PAGE = np.array([21, 22, 24]) / 255.0  # sRGB


class Tile(NamedTuple):
    """One picture of a sheet: a material, its name and an optional second line."""

    label: str
    material: bpy.types.Material
    note: str = ""


class Line(NamedTuple):
    """Text to draw: its baseline's anchor and letter size in pixels (y down), strength 0 to 1, widest width."""

    text: str
    x: float
    y: float
    size: float
    strength: float
    width: float
    align: str = "CENTER"


def render_sheet(
    items: Sequence[Tile],
    out_path: str | os.PathLike,
    columns: int = 5,
    tile_px: int = 320,
    samples: int = 24,
    progress: Callable[[float, str], None] | None = None,
    *,
    title: str = "",
    metadata: dict[str, str] | None = None,
) -> None:
    """Render `items` and write the labelled page as a PNG (with text `metadata`), whole or not at all.

    All tiles share camera, lights and seed, so they compare. `progress(done, text)` is called before each tile and
    at the end with done from 0 to 1. A tile of 320 px and 24 samples takes about 17 s of CPU time.
    Raises LaminaError for no items, columns below 1, a missing folder or a failed render.
    """
    if not items or columns < 1:
        raise LaminaError(f"contact sheet of {len(items)} materials in {columns} columns: both must be at least 1")
    if not Path(out_path).parent.is_dir():
        raise LaminaError(f"{out_path}: the folder {Path(out_path).parent} does not exist")
    pictures = []
    studio = build_ball_scene(items[0].material, tile_px, samples)
    studio.scene.render.use_persistent_data = True  # only the material changes from tile to tile
    try:
        with tempfile.TemporaryDirectory() as folder:
            for i, item in enumerate(items):
                if progress:
                    progress(i / len(items), item.label)
                studio.show(item.material)
                render_to(studio.scene, Path(folder, "tile.png"))
                pictures.append(read_png(Path(folder, "tile.png"))[0][..., :3])
    finally:
        studio.remove()
    write_png(out_path, compose(pictures, items, columns, title), metadata)
    if progress:
        progress(1.0, "written")


def compose(pictures: Sequence[np.ndarray], items: Sequence[Tile], columns: int, title: str = "") -> np.ndarray:
    """Lay out (h, w, 3) uint8 pictures of one size in rows, each over its label and note; (h, w, 3) uint8."""
    high, wide = pictures[0].shape[:2]
    columns = min(columns, len(pictures))
    unit = wide / 320.0
    margin, gap, caption, head = (round(v * unit) for v in (28, 14, 62, 66 if title else 0))
    rows = -(-len(pictures) // columns)
    width = 2 * margin + columns * wide + (columns - 1) * gap
    height = 2 * margin + head + rows * (high + caption) + (rows - 1) * gap - round(8 * unit)
    page = np.broadcast_to(PAGE, (height, width, 3)).copy()
    mask = _rounded(high, wide, 10.0 * unit)[..., None]
    lines = [Line(title, margin, margin + 30 * unit, 32 * unit, 0.92, width - 2 * margin, "LEFT")] if title else []
    for i, (picture, item) in enumerate(zip(pictures, items)):
        x = margin + (i % columns) * (wide + gap)
        y = margin + head + (i // columns) * (high + caption + gap)
        place = page[y : y + high, x : x + wide]
        place += mask * (picture / 255.0 - place)
        lines.append(Line(item.label, x + wide / 2, y + high + 28 * unit, 20 * unit, 0.9, 0.96 * wide))
        if item.note:
            lines.append(Line(item.note, x + wide / 2, y + high + 51 * unit, 15 * unit, 0.5, 0.96 * wide))
    page += text_mask(lines, width, height)[..., None] * (1.0 - page)
    return (page.clip(0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)


def _rounded(high: int, wide: int, radius: float) -> np.ndarray:
    """Coverage (high, wide) of a rectangle with rounded corners."""
    down, across = (np.maximum(np.abs(np.arange(n) + 0.5 - n / 2) - (n / 2 - radius), 0.0) for n in (high, wide))
    return np.clip(radius + 0.5 - np.hypot(across, down[:, None]), 0.0, 1.0)


def text_mask(lines: Sequence[Line], width: int, height: int) -> np.ndarray:
    """Coverage (height, width), 0 to 1, of text set in Blender's built-in font, rendered as flat emission.

    Lines wider than their `width` shrink to it.
    """
    made = []
    with scratch_scene("Lamina text") as scene, tempfile.TemporaryDirectory() as folder:
        measurement_settings(scene, 8, (width, height))
        scene.cycles.filter_width = 1.0
        camera = bpy.data.cameras.new("Page")
        camera.type, camera.ortho_scale, camera.sensor_fit = "ORTHO", width, "HORIZONTAL"
        scene.camera = add_object(scene, "Page", camera)
        scene.camera.location = (width / 2, -height / 2, 10.0)
        try:
            for line in lines:
                curve = bpy.data.curves.new("Line", "FONT")
                curve.body, curve.size, curve.align_x = line.text, line.size, line.align
                ink = _ink(line.strength)
                made.append(ink)
                curve.materials.append(ink)
                item = add_object(scene, "Line", curve)
                item.location = (line.x, -line.y, 0.0)
                scene.view_layers[0].update()
                item.scale *= min(1.0, line.width / max(item.dimensions.x, 1e-6))
            render_to(scene, Path(folder, "text.exr"))
        finally:
            bpy.data.batch_remove(made)
        picture = read_exr(Path(folder, "text.exr")).layer(f"{scene.view_layers[0].name}.Combined")
    return picture.mean(axis=-1).clip(0.0, 1.0)


def _ink(strength: float) -> bpy.types.Material:
    material = bpy.data.materials.new("Ink")
    tree = node_tree(material)
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Strength"].default_value = strength
    emission.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material
