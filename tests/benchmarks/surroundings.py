# SPDX-License-Identifier: GPL-3.0-or-later
"""One .blend in its four surroundings: Cycles with OSL, without, in another Blender (which may have none), and EEVEE there.

    surroundings.py PICTURE.png TABLE.csv

LAMINA_BLENDER names the other Blender, which must have EEVEE; Lamina need not be installed there. Rows of the picture are
presets. The table has the mean of each picture and the largest difference, in blocks of 8 pixels, from Cycles with OSL.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.blender.images import read_exr, write_png
from lamina.addon.material.material import apply_stack, refresh
from lamina.addon.rendering.settings import render_to
from lamina.addon.rendering.studio import build_ball_scene
from lamina.reference_py.material import presets
from lamina.study.pareto.ball_picture import encoded
from lamina.study.tables import write_table
from lamina.study.viewport.eevee_pictures import blender_program, blender_version, eevee_pictures

NAMES = ("glazed_mug", "metallic_car_paint", "patina_copper")
SIZE, SAMPLES, EEVEE_SAMPLES, BLOCK = 160, 128, 64, 8
SURROUNDINGS = ("osl_on", "osl_off", "other_blender", "eevee")


def pixels(path: Path) -> np.ndarray:
    channels = read_exr(path).channels
    return np.stack([next(v for name, v in channels.items() if name.split(".")[-1] == c) for c in "RGB"], axis=-1).astype(float)


def pictures(folder: Path) -> dict[str, list[np.ndarray]]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = []
    for name in NAMES:
        materials.append(bpy.data.materials.new(name))
        apply_stack(materials[-1], presets.load(name))
        refresh(materials[-1], settle=True)
        materials[-1].use_fake_user = True
    studio = build_ball_scene(materials[0], SIZE, SAMPLES, name="Surroundings")
    scene = bpy.context.window.scene = studio.scene
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    for light in bpy.data.lights:  # EEVEE ignores nodes of lights, by which the softboxes fade towards their edges
        for socket in (s for node in light.node_tree.nodes for s in node.inputs if s.name == "Strength") if light.node_tree else ():
            for link in list(socket.links):
                light.node_tree.links.remove(link)
            socket.default_value = 1.0
    found: dict[str, list[np.ndarray]] = {key: [] for key in SURROUNDINGS}
    for name, material in zip(NAMES, materials):
        studio.ball.material_slots[0].material = material
        for key in ("osl_on", "osl_off"):
            scene.cycles.shading_system = key == "osl_on"
            render_to(scene, folder / f"{name}.exr")
            found[key].append(pixels(folder / f"{name}.exr"))
        there, file = folder / f"{name}.there.exr", folder / f"{name}.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
        act = f"import bpy; s = bpy.data.scenes['{scene.name}']; s.render.filepath = {str(there)!r}; bpy.ops.render.render(write_still=True, scene=s.name)"
        subprocess.run([blender_program(), "-b", "--factory-startup", file, "--python-exit-code", "1", "--python-expr", act], check=True, capture_output=True)
        found["other_blender"].append(pixels(there))
    found["eevee"] = list(eevee_pictures(scene, studio.ball, materials, EEVEE_SAMPLES, lambda message: None))
    return found


def blocks(picture: np.ndarray) -> np.ndarray:
    side = SIZE // BLOCK
    return picture.reshape(side, BLOCK, side, BLOCK, 3).mean(axis=(1, 3))


def main(picture: str, table: str) -> None:
    ensure_osl_query_on_path()
    lamina.register()
    other = blender_version()
    with tempfile.TemporaryDirectory() as folder:
        found = pictures(Path(folder))
    rows = []
    for i, name in enumerate(NAMES):
        for key in SURROUNDINGS:
            apart = np.abs(blocks(found[key][i]) - blocks(found["osl_on"][i])).max()
            rows.append((name, key, *(f"{v:.4f}" for v in found[key][i].mean(axis=(0, 1))), f"{apart:.4f}"))
            print(*rows[-1])
    sheet = np.concatenate([np.concatenate([found[key][i] for key in SURROUNDINGS], axis=1) for i in range(len(NAMES))], axis=0)
    write_png(picture, encoded(sheet))
    heading = ("make surroundings", f"the other Blender {other}")
    write_table(Path(table), heading, ("preset", "surroundings", "r", "g", "b", "largest_difference"), rows)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
