#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: what a rough white Glossy node whose Normal is tilted towards the view reflects of a white world.
# Expected: less than the upright one, as what it sends below its own normal's horizon is lost, and the same in both.
# Seen: 4.5.15 keeps samples that lie above the surface but below that horizon, where its evaluation for lamps gives 0, and so the tilted
# one reflects more than the upright one does. 5.3.0 leaves them out. Bump and normal maps on rough metal are brighter in 4.5 by
# up to as much, wherever light comes from all sides.
# Output of 2026-11-29 (GGX, roughness .63, seen at 60 degrees):
#   Blender 4.5.15  upright: .759084, tilted by 40 degrees: .776523
#   Blender 5.3.0   upright: .759084, tilted by 40 degrees: .746205
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

scene = empty_file()
scene.cycles.samples = 256
world((1.0, 1.0, 1.0))
owner, glossy = material("tilted", "ShaderNodeBsdfAnisotropic", Roughness=0.63, Color=(1.0, 1.0, 1.0, 1.0))
glossy.distribution = "GGX"
plane(owner, 60.0)
normal = owner.node_tree.nodes.new("ShaderNodeCombineXYZ")
owner.node_tree.links.new(normal.outputs[0], glossy.inputs["Normal"])
tilted = 0.776523 if VERSION < (5, 0) else 0.746205
for degrees, expected in ((0.0, 0.759084), (40.0, tilted)):
    normal.inputs[0].default_value, normal.inputs[2].default_value = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    told(f"tilted by {degrees:g} degrees", seen()[0], expected, 0.003)
done()
PYTHON
blenders 4.5.15 5.3.0
