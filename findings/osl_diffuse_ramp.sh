#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles on the CPU with Open Shading Language: the closure `diffuse_ramp(N, colors)` reflects by the light's direction, and its
# ramp holds the cosine too.
# Expected: a white ramp is a white diffuse surface, and a ramp is a look of cartoons, whose colors follow how bright a place is lit or the view.
# Seen: eight white entries reflect twice the light that arrives, and a lamp at 80 degrees lights them as much as one above. Entries of 0, 1/7 ... 1 are
# `diffuse(N)`. Between entries, which stand at even cosines of the light and the normal, all is linear; the view does nothing. So entries of a cosine times
# what a coat lets through at it are how paint under that coat reflects, which no other closure is.
# Output of 2026-11-30, both Blenders alike:
#   mean of a white world, white entries: 2    entries 0 to 1: 1    diffuse: 1
#   lamp at 0 and 80 degrees, white entries: .3183 .3183    entries 0 to 1: .3183 .0553    diffuse: .3183 .0553
#   the same seen from 60 degrees, white entries: .3183 .3183
#   entries 0 but the last, lamp whose cosine is 13/14: .1592
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

EVEN = [i / 7 for i in range(8)]


def seen_of(entries, view_deg=0.0, lamp_deg=None):
    """The mean red of a plane of these entries, or of `diffuse`, in a white world or under a lamp of irradiance 1 across its light."""
    scene = empty_file(osl=True)
    scene.cycles.samples = 1024 if lamp_deg is None else 64
    owner, output = material("ramp")
    if entries is None:
        source = "shader S(output closure color BSDF = 0) { BSDF = diffuse(N); }"
    else:
        values = ", ".join(f"color({value:.9g})" for value in entries)
        source = f"shader S(output closure color BSDF = 0) {{ color entries[8] = {{{values}}}; BSDF = diffuse_ramp(N, entries); }}"
    node = script_node(owner.node_tree, source)
    owner.node_tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    plane(owner, view_deg)
    if lamp_deg is None:
        world((1.0, 1.0, 1.0))
    else:
        lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
        lamp.data.angle, lamp.data.energy, lamp.rotation_euler = 0.0, 1.0, (np.radians(lamp_deg), 0.0, 0.0)
        scene.collection.objects.link(lamp)
    return float(seen()[0])


for label, entries, expected in (("white entries", [1.0] * 8, 2.0), ("entries 0 to 1", EVEN, 1.0), ("diffuse", None, 1.0)):
    told(f"mean of a white world, {label}", seen_of(entries), expected, 0.01)
for label, entries, expected in (("white entries", [1.0] * 8, (0.3183, 0.3183)), ("entries 0 to 1", EVEN, (0.3183, 0.0553)), ("diffuse", None, (0.3183, 0.0553))):
    told(f"lamp at 0 and 80 degrees, {label}", [seen_of(entries, lamp_deg=angle) for angle in (0.0, 80.0)], expected, 0.001)
told("the same seen from 60 degrees, white entries", [seen_of([1.0] * 8, 60.0, angle) for angle in (0.0, 80.0)], (0.3183, 0.3183), 0.001)
half_way = float(np.degrees(np.arccos(13 / 14)))
told("entries 0 but the last, lamp whose cosine is 13/14", seen_of([0.0] * 7 + [1.0], lamp_deg=half_way), 0.1592, 0.001)
done()
PYTHON
blenders 4.5.15 5.3.0
