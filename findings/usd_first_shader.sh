#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: USD export writes the first Principled or Diffuse node of the tree, linked to the output or not.
# Expected: the preview surface is made from what the active output shows, followed back along the links; a node that nothing leads to is
# left out, and a Mix Shader with factor 0 or 1 gives the input that it lets through.
# Seen: the links do not count. The one of them that was made first is written, so one that lies unused in the tree replaces the linked one, and
# of two in a Mix Shader the first made is written for factor 0 and for factor 1. Cycles shows the other.
# Output of 2026-11-28, both (picture / diffuseColor in the file; nodes in the order of making; blue is a Diffuse, the others Principled):
#   red, green, linked is green: green / red      red, blue, linked is blue: blue / red      blue, red, linked is red: red / blue
#   Mix of red and green, factor 0: red / red, 1: green / red      Mix of green and red, factor 0: green / red, 1: red / red
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

from pxr import Usd, UsdShade  # noqa: E402, on the path since blender was imported

COLORS = {"red": (1.0, 0.0, 0.0), "green": (0.0, 1.0, 0.0), "blue": (0.0, 0.0, 1.0)}


def brightest(color):
    return list(COLORS)[int(np.argmax(color))]


def written():
    path = str(FOLDER / "written.usda")
    with silent():
        bpy.ops.wm.usd_export(filepath=path)
    stage = Usd.Stage.Open(path)  # kept, or its prims expire
    shaders = [UsdShade.Shader(prim) for prim in stage.Traverse() if prim.IsA(UsdShade.Shader)]
    (surface,) = [shader for shader in shaders if shader.GetIdAttr().Get() == "UsdPreviewSurface"]
    return brightest(surface.GetInput("diffuseColor").Get())


def shown(names, inputs, factor=None):
    """The picture's and the file's color. `names` are in the order of making, `inputs` those linked: one, or two that are mixed."""
    empty_file()
    world((1.0, 1.0, 1.0))
    owner, output = material("shown")
    tree = owner.node_tree
    nodes = {}
    for name in names:
        nodes[name] = tree.nodes.new("ShaderNodeBsdfDiffuse" if name == "blue" else "ShaderNodeBsdfPrincipled")
        nodes[name].inputs[0].default_value = (*COLORS[name], 1.0)
    linked = nodes[inputs[0]]
    if factor is not None:
        linked = tree.nodes.new("ShaderNodeMixShader")
        linked.inputs["Fac"].default_value = factor
        for number, name in enumerate(inputs, 1):
            tree.links.new(nodes[name].outputs[0], linked.inputs[number])
    tree.links.new(linked.outputs[0], output.inputs["Surface"])
    plane(owner)
    return f"{brightest(seen())} / {written()}"


for first, second in (("red", "green"), ("red", "blue"), ("blue", "red")):
    told(f"{first}, {second}, linked is {second}", shown((first, second), (second,)), f"{second} / {first}")
for inputs in (("red", "green"), ("green", "red")):
    for factor in (0, 1):
        told(f"red, green, Mix of {' and '.join(inputs)}, factor {factor}", shown(("red", "green"), inputs, factor), f"{inputs[factor]} / red")
done()
PYTHON
blenders 4.5.15 5.3.0
