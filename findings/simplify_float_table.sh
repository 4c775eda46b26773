#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles: Simplify's Texture Limit also shrinks packed float images that are Non-Color data, such as lookup tables.
# Expected: the limit saves memory of pictures; data that a node looks up by computed coordinates stays as it is.
# Seen: a float image of 256 x 8 pixels, whose value at x is 1 at even pixels and 3 at odd ones, is exact without a limit. With the limit of
# 128 pixels neighbours are averaged: 2 everywhere. Nothing on the image or the node takes it out.
# Output of 2026-11-29, the largest difference from the table at 16 pixels' centres, in 4.5.15 and 5.3.0:
#   no limit  0 0     limit of 128 pixels  1 1
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

WIDE = 256
for limit, expected in (("OFF", 0.0), ("128", 1.0)):
    scene = empty_file()
    table = np.where(np.arange(WIDE) % 2, 3.0, 1.0)
    image = bpy.data.images.new("table", WIDE, 8, float_buffer=True, is_data=True)
    image.pixels.foreach_set(np.tile(np.repeat(table[:, None], 4, axis=1).astype(np.float32), (8, 1)).ravel())
    image.update()
    image.pack()
    scene.render.use_simplify = limit != "OFF"
    scene.cycles.texture_limit_render = limit
    worst = 0.0
    for pixel in range(100, 116):
        owner, node = material(f"at {pixel}", "ShaderNodeEmission")
        texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image, texture.interpolation, texture.extension = image, "Linear", "EXTEND"
        place = owner.node_tree.nodes.new("ShaderNodeCombineXYZ")
        place.inputs[0].default_value, place.inputs[1].default_value = (pixel + 0.5) / WIDE, 0.5
        owner.node_tree.links.new(place.outputs[0], texture.inputs["Vector"])
        owner.node_tree.links.new(texture.outputs["Color"], node.inputs["Color"])
        shown = plane(owner)
        worst = max(worst, abs(float(seen()[0]) - table[pixel]))
        bpy.data.objects.remove(shown)
    told(f"limit {limit}", worst, expected, 0.01)
done()
PYTHON
blenders 4.5.15 5.3.0
