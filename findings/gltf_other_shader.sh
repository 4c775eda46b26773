#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15, 5.2.3 and 5.3.0: glTF export of a Mix Shader ignores its factor, and 5.3.0 ignores which Material Output is active.
# Expected: the exporter writes the shader that the active output shows; of a Mix Shader with factor 0 or 1 the input that it lets through.
# Seen: of two Principled nodes in a Mix Shader 4.5.15 writes the one on the first input, 5.2.3 and 5.3.0 that on the second, for factor 0 and
# 1 alike; a Principled of weight 0 also replaces a Diffuse of weight 1. Of two outputs for all renderers 4.5.15 and 5.2.3 write the active one,
# 5.3.0 the one made last. An output with target Cycles, the only one there, gives the material its values in 4.5.15; 5.2.3 and 5.3.0 write
# the material without any, and by glTF's defaults that is a rough white metal.
# Output of 2026-11-28 (picture / baseColorFactor in the file; blue is a Diffuse):
#   case                               4.5.15           5.2.3           5.3.0
#   Mix of red and green, factor 0     red / red        red / green     red / green
#   Mix of red and green, factor 1     green / red      green / green   green / green
#   Mix of blue and red, factor 0      blue / red       blue / red      blue / red
#   outputs red and green, red active  red / red        red / red       red / green
#   output red for Cycles only         red / red        red / none      red / none
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

import json

COLORS = {"red": (1.0, 0.0, 0.0), "green": (0.0, 1.0, 0.0), "blue": (0.0, 0.0, 1.0)}


def brightest(color):
    return list(COLORS)[int(np.argmax(color))]


def written():
    path = FOLDER / "written.gltf"
    with silent():
        bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
        bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLTF_SEPARATE")
    (found,) = json.loads(path.read_text())["materials"]
    return brightest(found["pbrMetallicRoughness"]["baseColorFactor"][:3]) if "pbrMetallicRoughness" in found else "none"


def started():
    empty_file()
    world((1.0, 1.0, 1.0))
    owner, output = material("shown")
    return owner, owner.node_tree, output


def shader(tree, name):
    node = tree.nodes.new("ShaderNodeBsdfDiffuse" if name == "blue" else "ShaderNodeBsdfPrincipled")
    node.inputs[0].default_value = (*COLORS[name], 1.0)
    return node.outputs[0]


def compared(label, owner, expected):
    plane(owner)
    told(label, f"{brightest(seen())} / {written()}", expected)


for first, second, factor in (("red", "green", 0), ("red", "green", 1), ("blue", "red", 0)):
    owner, tree, output = started()
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs["Fac"].default_value = factor
    for number, name in ((1, first), (2, second)):
        tree.links.new(shader(tree, name), mix.inputs[number])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    taken = "red" if first == "blue" or VERSION < (5, 0) else "green"
    compared(f"Mix of {first} and {second}, factor {factor}", owner, f"{(first, second)[factor]} / {taken}")
owner, tree, output = started()
other = tree.nodes.new("ShaderNodeOutputMaterial")
for name, node in (("red", output), ("green", other)):
    tree.links.new(shader(tree, name), node.inputs["Surface"])
    node.is_active_output = name == "red"
compared("outputs red and green, red active", owner, "red / red" if VERSION < (5, 3) else "red / green")
owner, tree, output = started()
output.target = "CYCLES"
tree.links.new(shader(tree, "red"), output.inputs["Surface"])
compared("output red for Cycles only", owner, "red / red" if VERSION < (5, 0) else "red / none")
done()
PYTHON
blenders 4.5.15 5.2.3 5.3.0
