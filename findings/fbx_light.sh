#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 5.0.1: Blender's FBX importer (io_scene_fbx) stops at a light, and so at any scene of its own that has one.
# Expected: a scene that Blender wrote as FBX can be read by the same Blender; memory would say that only exotic content is lost in an FBX.
# Seen: the importer sets cycles.cast_shadow on each light, a property that Cycles gave up in 5.0; in 5.0.1 that is an AttributeError. The
# mesh beside the light is there, but the operator ends with an error. 4.5.15 and 5.3.0 read the file, each its own.
# Output of 2026-11-29: 4.5.15 and 5.3.0 read it; 5.0.1 'CyclesLightSettings' object has no attribute 'cast_shadow'
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

path = str(FOLDER / "lit.fbx")
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_cube_add()
bpy.ops.object.light_add(type="POINT")
bpy.ops.export_scene.fbx(filepath=path)
bpy.ops.wm.read_factory_settings(use_empty=True)
try:
    bpy.ops.import_scene.fbx(filepath=path)
    stopped = ""
except RuntimeError as error:
    stopped = next(line for line in str(error).splitlines() if line.startswith("AttributeError"))
print(f"  {stopped or 'read'}")
told("  the importer stops at a light", "cast_shadow" in stopped, VERSION == (5, 0))
told("  the mesh is there", "Cube" in bpy.data.meshes, True)
done()
PYTHON
blenders 4.5.15 5.0.1 5.3.0
