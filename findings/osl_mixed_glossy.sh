#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, Cycles on the CPU: a Multiscatter GGX Glossy node behind a Mix Shader is darker with Open Shading Language on.
# Expected: stock nodes look the same in both shading systems, and two equal shaders mixed half and half look as one.
# Seen: a white Glossy node mixed with its equal reflects all of a white world with OSL off, and with OSL on .956 of it at roughness .5 and .508
# at roughness 1. That is twice what one Glossy node of grey .5 reflects: the factor counts as a color. GGX and a Principled metal lose nothing.
# Output of 2026-11-28, both, mean of a white world, OSL off and on:
#   Multiscatter GGX alone    roughness .5: 1.001 1.001    1: 1.000 1.000
#   the same of grey .5       roughness .5: .478 .478      1: .254 .254
#   Multiscatter GGX mixed    roughness .5: 1.001 .956     1: 1.000 .508
#   GGX mixed                 roughness .5: .916 .916      1: .307 .307
#   Principled metal mixed    roughness .5: 1.001 1.001    1: 1.000 1.000
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *


def glossy(tree, distribution, roughness, grey):
    """A metal: a Glossy node of this distribution, or a Principled one."""
    if distribution == "Principled":
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.inputs["Metallic"].default_value = 1.0
    else:
        node = tree.nodes.new("ShaderNodeBsdfAnisotropic")
        node.distribution = distribution
    node.inputs[0].default_value = (grey, grey, grey, 1.0)
    node.inputs["Roughness"].default_value = roughness
    return node.outputs[0]


CASES = {  # (reflected, with OSL off and on), at roughness .5 and 1
    ("MULTI_GGX", 1.0, False): ((1.001, 1.001), (1.0, 1.0)),
    ("MULTI_GGX", 0.5, False): ((0.478, 0.478), (0.254, 0.254)),
    ("MULTI_GGX", 1.0, True): ((1.001, 0.956), (1.0, 0.508)),
    ("GGX", 1.0, True): ((0.916, 0.916), (0.307, 0.307)),
    ("Principled", 1.0, True): ((1.001, 1.001), (1.0, 1.0)),
}
for (distribution, grey, mixed), expected in CASES.items():
    for roughness, both in zip((0.5, 1.0), expected):
        reflected = []
        for osl in (False, True):
            scene = empty_file(osl=osl)
            scene.cycles.samples = 256
            world((1.0, 1.0, 1.0))
            owner, output = material("metal")
            tree, surface = owner.node_tree, output.inputs["Surface"]
            if mixed:
                mix = tree.nodes.new("ShaderNodeMixShader")
                mix.inputs["Fac"].default_value = 0.5
                for socket in mix.inputs[1:]:
                    tree.links.new(glossy(tree, distribution, roughness, grey), socket)
                tree.links.new(mix.outputs[0], surface)
            else:
                tree.links.new(glossy(tree, distribution, roughness, grey), surface)
            plane(owner)
            reflected.append(float(seen()[0]))
        told(f"{distribution} of {grey}{' mixed' if mixed else ''}, roughness {roughness}, OSL off and on", reflected, both, 0.003)
done()
PYTHON
blenders 4.5.15 5.3.0
