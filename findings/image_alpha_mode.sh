#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles: an Image Texture with nothing linked to Alpha goes by the kind of the image in 4.5, by its alpha mode in 5.3.
# Expected: a Straight image's color is multiplied by its alpha, a Premultiplied one's is not, in both.
# Seen: 4.5.15 multiplies every byte image and no float image, whatever the mode says; 5.3.0 does as expected. So a byte image set to
# Premultiplied gets brighter where it is transparent, and a float image set to Straight darker.
# Output of 2026-11-29, color .5 (sRGB in the byte image) and alpha .75, in 4.5.15 and 5.3.0:
#   byte image     Straight: .114 .114     Premultiplied: .114 .216
#   float image    Straight: .500 .375     Premultiplied: .500 .500
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

NEW = VERSION >= (5, 3)
EXPECTED = {
    (False, "STRAIGHT"): 0.1144, (False, "PREMUL"): 0.2159 if NEW else 0.1144,
    (True, "STRAIGHT"): 0.375 if NEW else 0.5, (True, "PREMUL"): 0.5,
}  # fmt: skip
for is_float in (False, True):
    for mode in ("STRAIGHT", "PREMUL"):
        empty_file()
        image = bpy.data.images.new("image", 4, 4, alpha=True, float_buffer=is_float)
        image.pixels.foreach_set(np.tile(np.array((0.5, 0.5, 0.5, 0.75), np.float32), 16))
        image.alpha_mode = mode
        owner, node = material("shown", "ShaderNodeEmission")
        texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        owner.node_tree.links.new(texture.outputs["Color"], node.inputs["Color"])
        plane(owner)
        told(f"{'float' if is_float else 'byte'} image, {mode}", float(seen()[0]), EXPECTED[is_float, mode], 0.001)
done()
PYTHON
blenders 4.5.15 5.3.0
