#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles on the CPU: with Open Shading Language switched on every shader AOV is black.
# Expected: an AOV Output node writes its pass in both shading systems; the node is stock, and no Script node is in the file.
# Seen: OSL off: the color. OSL on: 0 in all channels, for the whole scene, without a warning; the picture itself is right.
# Output of 2026-11-28, both:
#   OSL off: picture 0.5, AOV 0.25 0.5 0.75 1     OSL on: picture 0.5, AOV 0 0 0 0
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

import OpenImageIO

for osl in (False, True):
    scene = empty_file(osl=osl)
    owner, emission = material("glowing", "ShaderNodeEmission", Color=(0.5, 0.5, 0.5, 1.0))
    plane(owner)
    node = owner.node_tree.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = bpy.context.view_layer.aovs.add().name = "mine"
    node.inputs["Color"].default_value = (0.25, 0.5, 0.75, 1.0)
    if VERSION >= (5, 0):
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath = str(FOLDER / "passes.exr")
    with silent():
        bpy.ops.render.render(write_still=True)
    means, file, part = {}, OpenImageIO.ImageInput.open(scene.render.filepath), 0
    while file.seek_subimage(part, 0):
        names = file.spec().channelnames
        means |= dict(zip(names, file.read_image(part, 0, 0, len(names), "float").mean((0, 1)).tolist()))
        part += 1
    file.close()
    told(f"OSL {'on' if osl else 'off'}: picture", means["ViewLayer.Combined.R"], 0.5, 1e-6)
    told(f"OSL {'on' if osl else 'off'}: AOV", [means[f"ViewLayer.mine.{c}"] for c in "RGBA"], [0.0] * 4 if osl else [0.25, 0.5, 0.75, 1.0], 1e-6)
done()
PYTHON
blenders 4.5.15 5.3.0
