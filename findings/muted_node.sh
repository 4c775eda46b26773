#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: what a muted node hands on in a material where its input is not linked.
# Expected: mute lets the input through, so a Math node whose own first value is 1.5 hands on 1.5.
# Seen: its own value never counts. 4.5.15 hands on 0, 5.3.0 the value of the socket that it leads to, as if the link were cut. With
# the input linked both hand on the linked value. An OSL Script node is no exception: its output is not what the script
# says, also where the script knows only one value, and the linked value comes through with OSL off too.
# Output of 2026-11-28 (Strength of an Emission, own value 3):
#   Blender 4.5.15  Math: 2.5, muted 0, muted and linked to 7: 7   Script: 1, muted 0, muted and linked to 7: 7, OSL off 7
#   Blender 5.3.0   Math: 2.5, muted 3, muted and linked to 7: 7   Script: 1, muted 3, muted and linked to 7: 7, OSL off 7
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

cut = 0.0 if VERSION < (5, 0) else 3.0
empty_file(osl=True)
owner, emission = material("glowing", "ShaderNodeEmission", Strength=3.0)
plane(owner)
tree = owner.node_tree
add = tree.nodes.new("ShaderNodeMath")
add.inputs[0].default_value, add.inputs[1].default_value = 1.5, 1.0
script = script_node(tree, "shader one(float IOR = 1.5, output float One = 0) { One = 1; }")
seven = tree.nodes.new("ShaderNodeValue")
seven.outputs[0].default_value = 7.0
for label, node, own in (("Math 1.5 + 1", add, 2.5), ("Script, always 1", script, 1.0)):
    tree.links.new(node.outputs[0], emission.inputs["Strength"])
    told(label, seen()[0], own, 1e-5)
    node.mute = True
    told(f"{label}, muted", seen()[0], cut, 1e-5)
    tree.links.new(seven.outputs[0], node.inputs[0])
    told(f"{label}, muted, input linked to 7", seen()[0], 7.0, 1e-5)
bpy.context.scene.cycles.shading_system = False
told("Script, muted, input linked to 7, OSL off", seen()[0], 7.0, 1e-5)
done()
PYTHON
blenders 4.5.15 5.3.0
