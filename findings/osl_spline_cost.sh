#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles with OSL: spline("linear", x, table) takes several times what two lookups and a mix take, and leaves out the table's ends.
# Expected: the built-in function is the fast way to read a table between its entries, from the first at 0 to the last at 1.
# Seen: as for curves, the first and the last entry do not count: of {5, 1, 2, 3, 7} it gives 1 at 0 and 3 at 1. A shader that reads a table
# of 300 colors at 24 places takes several times the CPU time with it, without what the rest of the render takes. (It is translated in less time,
# as one call, so it pays where a shader is hardly ever run.)
# Output of 2026-11-30 on two cores, 4.5.15 and 5.3.0: at 0: 1; at 1: 3; 7.92 and 5.38 times the CPU time
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
import time

from blender import *

ENTRIES, PLACES, ROUNDS = 300, 24, 5


def shader(value):
    scene = empty_file(osl=True)
    scene.cycles.samples, scene.render.resolution_x, scene.render.resolution_y = 512, 64, 64
    owner, emission = material("read", "ShaderNodeEmission", Strength=1.0)
    plane(owner)
    table = ", ".join(f"color({i % 7}, {i % 5}, {i % 3})" for i in range(ENTRIES))
    source = f"shader read(float Place = 0, color Table[{ENTRIES}] = {{{table}}}, output color Found = 0) {{ float p = 60 + 1000 * P[0]; {value} }}"
    owner.node_tree.links.new(script_node(owner.node_tree, source).outputs[0], emission.inputs["Color"])


def seconds(value):
    shader(value)
    least = np.inf
    for _ in range(ROUNDS):
        before = time.process_time()
        seen()
        least = min(least, time.process_time() - before)
    return least


def value_at(x):
    empty_file(osl=True)
    owner, emission = material("read", "ShaderNodeEmission", Strength=1.0)
    plane(owner)
    source = f'shader read(float T[5] = {{5, 1, 2, 3, 7}}, output color Found = 0) {{ Found = spline("linear", {x}, T); }}'
    owner.node_tree.links.new(script_node(owner.node_tree, source).outputs[0], emission.inputs["Color"])
    return float(seen()[0])


told("at 0", value_at(0.0), 1.0, 1e-6)
told("at 1", value_at(1.0), 3.0, 1e-6)
lookups = " ".join(f"Found += mix(Table[(int)p + {7 * i}], Table[(int)p + {7 * i + 1}], p - (int)p);" for i in range(PLACES))
splines = " ".join(f'Found += spline("linear", (p + {7 * i - 1}) / {ENTRIES - 3}, Table);' for i in range(PLACES))
rest = seconds("Found = p;")
times = (seconds(splines) - rest) / (seconds(lookups) - rest)
print(f"  {times:.2f} times the CPU time")
told("more than twice", times > 2.0, True)
done()
PYTHON
blenders 4.5.15 5.3.0
