#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles: what an Image Texture with a sequence of three pictures shows before the frame at which it starts.
# Expected: its first picture, as it goes on with its last one after its end.
# Seen: the file numbered 0 (plus the offset), which nobody has named: pink where there is none, and that picture where there is one, such as a
# renderer's frame 0. Cyclic sequences never ask for it. So a texture that starts with its shot at frame 1001 is pink in the
# frames of a pre-roll.
# Output of 2026-11-30, start at frame 10, pictures .1, .2 and .3 numbered 1 to 3, red and green, in both:
#   frame 9, no file 0: 1 0    frame 9, a file 0 of .9: .9 .9    frame 9, cyclic: .3 .3    frame 10: .1 .1    frame 20: .3 .3
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *


def picture(number, value):
    made = bpy.data.images.new("made", 4, 4, float_buffer=True, is_data=True)
    made.pixels.foreach_set(np.tile(np.array((value, value, value, 1.0), np.float32), 16))
    made.filepath_raw, made.file_format = str(FOLDER / f"s{number:03}.exr"), "OPEN_EXR"
    made.save()
    bpy.data.images.remove(made)


def shown(frame, cyclic=False):
    scene = empty_file()
    owner, node = material("shown", "ShaderNodeEmission")
    texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(FOLDER / "s001.exr"))
    texture.image.source, texture.image.colorspace_settings.name = "SEQUENCE", "Non-Color"
    user = texture.image_user
    user.frame_start, user.frame_duration, user.use_auto_refresh, user.use_cyclic = 10, 3, True, cyclic
    owner.node_tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    plane(owner)
    scene.frame_set(frame)
    return tuple(float(c) for c in seen()[:2])


for number in (1, 2, 3):
    picture(number, number / 10)
told("frame 9, no file 0", shown(9), (1.0, 0.0), 0.001)
told("frame 9, no file 0, cyclic", shown(9, True), (0.3, 0.3), 0.001)
told("frame 10", shown(10), (0.1, 0.1), 0.001)
told("frame 20", shown(20), (0.3, 0.3), 0.001)
picture(0, 0.9)
told("frame 9, a file 0 of .9", shown(9), (0.9, 0.9), 0.001)
done()
PYTHON
blenders 4.5.15 5.3.0
