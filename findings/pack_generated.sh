#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: Image.pack() on a new image whose pixels nobody has written packs nothing, and says nothing.
# Expected: after pack() the image has a packed file; or an error.
# Seen: packed_file is None and the source stays GENERATED. Once any pixel was written and update() called, pack() packs, and the source
# becomes FILE. An image that is filled by its generated color alone therefore depends on its settings, not on packed pixels.
# Output of 2026-11-29, in 4.5.15 and 5.3.0:
#   as made      GENERATED, packed files 0
#   written to   FILE, packed files 1
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

for how, expected in (("as made", ("GENERATED", 0)), ("written to", ("FILE", 1))):
    empty_file()
    image = bpy.data.images.new("mask", 8, 8)
    image.generated_color = (1.0, 1.0, 1.0, 1.0)
    if how == "written to":
        image.pixels.foreach_set(np.ones(8 * 8 * 4, np.float32))
        image.update()
    image.pack()
    told(how, f"{image.source}, packed files {len(image.packed_files)}", f"{expected[0]}, packed files {expected[1]}")
done()
PYTHON
blenders 4.5.15 5.3.0
