#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles with OSL: a number attribute has one type, and getattribute() of the other type finds nothing.
# Expected: OSL converts between int and float, so `int x; getattribute("geom:is_curve", x)` works; is_curve is a yes or no.
# Seen: geom:is_curve, geom:is_smooth and object:index are floats, path:ray_depth and geom:numpolyvertices ints. Asked for in the other type
# the call returns 0 and leaves the variable as it was: an int that starts at 0 reads "no curve" for ever, without an error.
# Output of 2026-11-28, both (found, value; the variable starts at -1; a plane of one quad seen by the camera, no curve):
#   geom:is_curve        float: 1 0     int: 0 -1        path:ray_depth        float: 0 -1    int: 1 0
#   geom:is_smooth       float: 1 0     int: 0 -1        geom:numpolyvertices  float: 0 -1    int: 1 3
#   object:index         float: 1 5     int: 0 -1
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

FLOATS = {"geom:is_curve": 0.0, "geom:is_smooth": 0.0, "object:index": 5.0}
INTS = {"path:ray_depth": 0.0, "geom:numpolyvertices": 3.0}
for name, value in {**FLOATS, **INTS}.items():
    for kind in ("float", "int"):
        empty_file(osl=True)
        owner, emission = material("asked", "ShaderNodeEmission", Strength=1.0)
        plane(owner).pass_index = 5
        source = f'shader ask(output color Found = 0) {{ {kind} x = -1; int found = getattribute("{name}", x); Found = color(found, x, 0); }}'
        owner.node_tree.links.new(script_node(owner.node_tree, source).outputs[0], emission.inputs["Color"])
        has = kind == ("float" if name in FLOATS else "int")
        told(f"{name}, {kind}", seen()[:2], (1.0, value) if has else (0.0, -1.0), 1e-6)
done()
PYTHON
blenders 4.5.15 5.3.0
