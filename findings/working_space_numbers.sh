#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 5.3.0: converting a file to another working space changes Color Ramps, also those that hold numbers, and not vectors.
# Expected: colors that are picked (RGB nodes, sockets) are converted; a ramp that maps a number to a number (a mask, a roughness) stays.
# Seen: set_working_color_space, and appending from a file of another space, convert the stops of every Color Ramp, its grey ones excepted
# (greys are the same in all three spaces), color sockets of OSL Script nodes too; vector sockets stay. There and back is not exact:
# the matrices have 5 decimals, .4 comes back as .399996 when read by Color.from_scene_linear_to_rec709_linear.
# Output of 2026-11-28: ramp stop and script socket 1 0 0 -> .6131 .07019 .02062; vector 1 0 0 -> 1 0 0; grey .25 -> .25;
#   .4 .8 .3 converted by the operator and read back by mathutils: .399996 .800004 .300003
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

from mathutils import Color  # noqa: E402, there once bpy is

empty_file(osl=True)
owner, _ = material("owner", "ShaderNodeEmission")
owner.use_fake_user = True
tree = owner.node_tree
ramp, rgb, vector = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("ValToRGB", "RGB", "Mapping"))
first, last = ramp.color_ramp.elements
first.color, last.color = (1.0, 0.0, 0.0, 1.0), (0.25, 0.25, 0.25, 1.0)
rgb.outputs[0].default_value = (0.4, 0.8, 0.3, 1.0)
vector.inputs["Location"].default_value = (1.0, 0.0, 0.0)
script = script_node(tree, "shader asked(color C = color(1, 0, 0), output color Found = 0) { Found = C; }")
script.inputs["C"].default_value = (1.0, 0.0, 0.0, 1.0)
with silent():
    bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=True)
RED = (0.6131, 0.07019, 0.02062)
told("a ramp's stop of 1 0 0", tuple(first.color[:3]), RED, 1e-5)
told("a Script node's socket of 1 0 0", tuple(script.inputs["C"].default_value[:3]), RED, 1e-5)
told("a ramp's grey of .25", tuple(last.color[:3]), (0.25,) * 3, 1e-5)
told("a vector of 1 0 0", tuple(vector.inputs["Location"].default_value), (1.0, 0.0, 0.0), 0.0)
back = Color(rgb.outputs[0].default_value[:3]).from_scene_linear_to_rec709_linear()
told(".4 .8 .3 read back", tuple(back), (0.399996, 0.800004, 0.300003), 2e-6)
told("it is not exact", abs(back[0] - 0.4) > 1e-6, True)
done()
PYTHON
blenders 5.3.0
