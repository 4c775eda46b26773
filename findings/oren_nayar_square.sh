#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: the color of a rough Diffuse node counts to the third power between facets before 5.3, to the second from 5.3 on.
# Expected: a Diffuse BSDF of one roughness and color looks the same in both; the release's change is small.
# Seen: under a white world dark rough surfaces are 3 to 5 % brighter in 5.3; white and black are the same. Principled's Diffuse Roughness
# and OSL's oren_nayar_diffuse_bsdf changed alike.
# Output of 2026-11-28, albedo along the normal, roughness 1: color .5 .4136 in 4.5.15 and .4390 in 5.3.0; color 1 the same in both
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

EXPECTED = {0.5: 0.4390 if VERSION >= (5, 3) else 0.4136, 1.0: 1.0}
for color, expected in EXPECTED.items():
    scene = empty_file()
    scene.cycles.samples = 256
    world((1.0, 1.0, 1.0))
    owner, _ = material("matte", "ShaderNodeBsdfDiffuse", Color=(color,) * 3 + (1.0,), Roughness=1.0)
    plane(owner)
    told(f"color {color}", float(seen()[0]), expected, 0.003)
done()
PYTHON
blenders 4.5.15 5.3.0
