#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: a Material Output node can be muted in 4.5 only, and a file brings the mute along.
# Expected: `node.mute = True` mutes any node or raises an error, in both alike.
# Seen: 4.5.15 mutes it, and the material renders black. In 5.3.0 the same line does nothing, without an error: `mute` reads False and the
# material shows. But a file that 4.5.15 saved with the node muted opens in 5.3.0 with `mute` True and renders black.
# Output of 2026-11-28:
#   Blender 4.5.15  as made: 0.5 0.25 0.125   mute after mute = True: True    then: 0 0 0            from 4.5.15's file: -
#   Blender 5.3.0   as made: 0.5 0.25 0.125   mute after mute = True: False   then: 0.5 0.25 0.125   from 4.5.15's file, not muted:
#                   0.5 0.25 0.125, muted: 0 0 0
# On loading the muted file 5.3.0 prints "Code marked as unreachable has been executed" to stderr and goes on.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

COLOR = (0.5, 0.25, 0.125)
OLD = VERSION < (5, 0)
files = {muted: str(Path(__file__).parent / f"muted_{muted}.blend") for muted in (False, True)}
empty_file()
owner, shader = material("glowing", "ShaderNodeEmission", Color=(*COLOR, 1.0))
plane(owner)
output = owner.node_tree.get_output_node("CYCLES")
told("as made", seen(), COLOR, 1e-6)
if OLD:
    with silent():
        bpy.ops.wm.save_as_mainfile(filepath=files[False])
output.mute = True
told("mute after mute = True", output.mute, OLD)
told("then", seen(), (0.0, 0.0, 0.0) if OLD else COLOR, 1e-6)
if OLD:
    with silent():
        bpy.ops.wm.save_as_mainfile(filepath=files[True])
else:
    for muted, path in files.items():
        with silent():
            bpy.ops.wm.open_mainfile(filepath=path)
        told(f"a file of 4.5.15, mute {muted}: mute read", bpy.data.materials["glowing"].node_tree.get_output_node("CYCLES").mute, muted)
        told(f"a file of 4.5.15, mute {muted}", seen(), (0.0, 0.0, 0.0) if muted else COLOR, 1e-6)
done()
PYTHON
blenders 4.5.15 5.3.0
