#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles: with Open Shading Language and Persistent Data each frame in which a node's value is animated leaves memory behind.
# Expected: a process that renders a long animation stays as large as it is after its first frames, whichever value is animated.
# Seen: a Principled node with a keyframed roughness adds 11 to 15 kB a frame with OSL, as its shader is made anew and something of the old one
# stays: with a hundred such materials a thousand frames add over a gigabyte. The same frames without OSL, or with OSL and a keyframed camera, add next to nothing.
# Output of 2026-11-29, kB a frame:       4.5.15  5.3.0
#   roughness animated, without OSL           .6     .3
#   camera animated, OSL                      .1     .5
#   roughness animated, OSL                 12.7   11.5
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
[ -r /proc/self/status ] || fail "a process's size is read from /proc, which this system has not"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

FRAMES = 150


def resident_kb():
    return next(int(line.split()[1]) for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmRSS"))


def growth(osl, animated):
    """kB a frame over the last hundred frames."""
    scene = empty_file(osl)
    scene.render.use_persistent_data = True
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples = 1
    owner, node = material("animated", "ShaderNodeBsdfPrincipled")
    plane(owner)
    camera = scene.camera
    for frame, value in ((1, 0.2), (FRAMES, 0.5)):
        camera.location.x = value
        camera.keyframe_insert("location", frame=frame)
        if animated:
            node.inputs["Roughness"].default_value = value
            node.inputs["Roughness"].keyframe_insert("default_value", frame=frame)
    sizes = []
    scene.render.filepath = str(FOLDER / "picture.exr")
    with silent():
        for frame in range(1, FRAMES + 1):
            scene.frame_set(frame)
            bpy.ops.render.render(write_still=True)
            sizes.append(resident_kb())
    return (sizes[-1] - sizes[-101]) / 100


for label, osl, animated in (("roughness, without OSL", False, True), ("camera, OSL", True, False), ("roughness, OSL", True, True)):
    kb = growth(osl, animated)
    print(f"  {label}: {kb:.1f} kB a frame")
    told("  more than 5", kb > 5.0, osl and animated)
done()
PYTHON
blenders 4.5.15 5.3.0
