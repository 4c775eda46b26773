# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds presets.blend: every preset of the paper on a ball of its own in one studio. `make blends` runs it."""

import sys
from pathlib import Path

import bpy
from mathutils import Vector

from ..addon.blender.blend_files import save_copy
from ..addon.material.material import apply_stack
from ..addon.rendering.geometry import STAND_FLOOR
from ..addon.rendering.settings import add_object, remove_scene
from ..addon.rendering.studio import build_ball_scene
from ..addon.session import blender, say
from ..reference_py.lobes.methods import AnalyticLobes
from ..reference_py.material import presets

COLUMNS = 5
SCALE = 0.42
SPACING = (1.0, 1.15)  # metres across and in depth


def build() -> bpy.types.Scene:
    """The scene in the running Blender, in place of what was there."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    studio = build_ball_scene(name="Presets", tile_px=(960, 540), samples=64)
    for scene in [s for s in bpy.data.scenes if s != studio.scene]:
        remove_scene(scene)
    scene, ball, stand = studio.scene, studio.ball, studio.scene.objects["Stand"]
    names = presets.PAPER
    for index, name in enumerate(names):
        row, column = divmod(index, COLUMNS)
        location = Vector(((column - (COLUMNS - 1) / 2) * SPACING[0], row * SPACING[1] - 0.6, -STAND_FLOOR * SCALE))
        material = bpy.data.materials.new(presets.label(name))
        # every value is live, so that it can be changed where Lamina is not installed
        apply_stack(material, presets.load(name), AnalyticLobes.name)
        for part, label in ((ball, presets.label(name)), (stand, f"{presets.label(name)} stand")):
            copy = add_object(scene, label, part.data)
            copy.location, copy.scale = location, (SCALE,) * 3
            if part is ball:
                # on the object, so that all balls share one mesh
                copy.material_slots[0].link = "OBJECT"
                copy.material_slots[0].material = material
    for part in (ball, stand):
        bpy.data.objects.remove(part)
    bpy.data.orphans_purge(do_recursive=True)
    camera = scene.camera
    camera.location = (0.0, -7.4, 3.2)
    camera.rotation_euler = (Vector((0.0, -0.1, 0.45)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, camera.data.sensor_fit = 52.0, "AUTO"
    scene.cycles.shading_system = True
    return scene


def main() -> None:
    output = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("presets.blend")
    with blender(say("presets")):
        build()
        save_copy(output)
    say("presets")(f"wrote {output}")


if __name__ == "__main__":
    main()
    import os

    os._exit(0)
