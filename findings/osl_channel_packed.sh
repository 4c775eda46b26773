#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles: with Open Shading Language 4.5 multiplies the color of a channel-packed image by its alpha, if it lies in a file.
# Expected: Channel Packed and None keep color and alpha apart, as their descriptions say: the same color with Open Shading Language and without.
# Seen: in 4.5.15 a PNG that lies in a file is read by OSL itself, which knows no alpha mode: its color comes multiplied by alpha, before sRGB is
# decoded, so by alpha to the 2.2 or so. Packed into the .blend, or without Open Shading Language, it does not, and in 5.3.0 nowhere. So a mask
# in an alpha channel darkens its picture as soon as a scene is switched to Open Shading Language, and packing it brightens it again.
# Output of 2026-11-30, a PNG of color .5 (sRGB, so .216 in 8 bits) and alpha .25, both modes alike:
#   4.5.15  without OSL: file .216, packed .216     with OSL: file .0144, packed .216
#   5.3.0   without OSL: file .216, packed .216     with OSL: file .216, packed .216
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

OLD = VERSION < (5, 0)
for mode in ("CHANNEL_PACKED", "NONE"):
    for osl in (False, True):
        for packed in (False, True):
            empty_file(osl=osl)
            drawn = bpy.data.images.new("drawn", 4, 4, alpha=True)
            drawn.alpha_mode = mode
            drawn.pixels.foreach_set(np.tile(np.array((0.5, 0.5, 0.5, 0.25), np.float32), 16))
            path = FOLDER / f"{mode}{osl}{packed}.png"
            drawn.filepath_raw, drawn.file_format = str(path), "PNG"
            drawn.save()
            image = bpy.data.images.load(str(path))
            image.alpha_mode = mode
            if packed:
                image.pack()
            owner, node = material("shown", "ShaderNodeEmission")
            texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
            texture.image = image
            owner.node_tree.links.new(texture.outputs["Color"], node.inputs["Color"])
            plane(owner)
            expected = 0.0144 if OLD and osl and not packed else 0.216
            told(f"{mode}, OSL {'on' if osl else 'off'}, {'packed' if packed else 'file'}", float(seen()[0]), expected, 0.001)
done()
PYTHON
blenders 4.5.15 5.3.0
