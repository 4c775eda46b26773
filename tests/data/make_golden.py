# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the golden .blend file of this code's schema version, and what it holds and renders.

    make_golden.py FOLDER     write FOLDER/schema_N.blend and FOLDER/schema_N.json

Files of older versions were written by their own code (`git archive COMMIT`, with this script and its Blender);
the JSON file names the commit. A golden file is never written again: it stands for the files that people have.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import material
from lamina.reference_py.material.schema import SCHEMA_VERSION
from lamina.reference_py.material.stack import Stack

SIZE, SAMPLES = 48, 16
STACKS = {
    "coat": {
        "name": "Coat",
        "layers": [{"kind": "dielectric", "name": "Clear", "roughness": 0.1},
                   {"kind": "dielectric", "name": "Hidden", "roughness": 0.9},
                   {"kind": "dielectric", "name": "Glaze", "roughness": 0.4, "tint": [1.0, 0.6, 0.2], "thickness": 1.5}],
        "base": {"kind": "conductor", "metal": "copper", "roughness": 0.35},
    },
    "paint": {"name": "Paint", "layers": [{"kind": "dielectric", "roughness": 0.25}], "base": {"kind": "lambert", "color": [0.2, 0.3, 0.6]}},
}  # fmt: skip
# What only version 2 has.
FEATURED = {
    "name": "Featured",
    "layers": [{"kind": "dielectric", "roughness": 0.3, "coverage": 0.5, "tint": [0.4, 0.7, 0.5]}],
    "base": {"kind": "conductor", "metal": "gold", "roughness": 0.4},
}
# What only version 4 has.
CHIPPED = {
    "name": "Chipped",
    "layers": [{"kind": "conductor", "metal": "iron", "roughness": 0.4, "coverage": 0.25}, {"kind": "dielectric", "roughness": 0.2},
               {"kind": "oren_nayar", "color": [0.3, 0.1, 0.05], "sigma_deg": 30.0, "coverage": 0.6}],
    "base": {"kind": "lambert", "color": [0.1, 0.4, 0.2]},
}  # fmt: skip


def build() -> None:
    """A ball for each material, a hidden layer, a texture and keyframes, in a studio of one sun and a grey world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 3 * SIZE, SIZE, 100
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling, scene.cycles.seed = SAMPLES, False, False, 1
    stacks = STACKS | ({"featured": FEATURED} if SCHEMA_VERSION > 1 else {}) | ({"chipped": CHIPPED} if SCHEMA_VERSION > 3 else {})
    for place, (name, data) in enumerate(stacks.items()):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.95, location=(2.0 * place, 0.0, 0.0))
        bpy.ops.object.shade_smooth()
        owner = bpy.data.materials.new(name)
        material.apply_stack(owner, Stack.from_dict(data), "weidlich_wilkie")
        bpy.context.object.data.materials.append(owner)
        if name == "coat":
            dress(owner)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, (0.6, 0.5, 0.0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 6.0
    camera.location, camera.rotation_euler = (2.0, -5.0, 0.0), (1.5707963, 0.0, 0.0)
    for item in (sun, camera):
        bpy.context.collection.objects.link(item)
    scene.camera, scene.world = camera, bpy.data.worlds.new("world")
    scene.world.color = (0.5, 0.5, 0.5)
    scene.frame_set(6)


def dress(owner) -> None:
    """What has to survive: a hidden layer, a texture on a tint, keyframes on a roughness."""
    clear, hidden, glaze = owner.lamina.layers
    hidden.visible = False
    tree = owner.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(checker.outputs["Color"], tree.nodes[glaze.node].inputs["Tint"])
    roughness = tree.nodes[clear.node].inputs["Roughness"]
    for frame, value in ((1, 0.0), (11, 0.5)):
        roughness.default_value = value
        roughness.keyframe_insert("default_value", frame=frame)


def facts() -> dict:
    """What the open file holds, hidden layers too, by material."""
    return {m.name: material.stack_of(m, hidden=True).to_dict() for m in bpy.data.materials if m.lamina.is_layered}


def main(folder: str) -> None:
    ensure_osl_query_on_path()
    lamina.register()
    build()
    output = Path(folder) / f"schema_{SCHEMA_VERSION}"
    bpy.ops.wm.save_as_mainfile(filepath=str(output.with_suffix(".blend")), compress=True, relative_remap=False)
    commit = os.environ.get("LAMINA_COMMIT") or subprocess.run(
        ["git", "-C", Path(lamina.__file__).parent, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()  # fmt: skip
    told = {"commit": commit, "blender": bpy.app.version_string, "stacks": facts()}
    output.with_suffix(".json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1])
