#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.0.1: what a polished Metallic node of the type Physical Conductor reflects at 60 degrees, by its IOR and Extinction.
# Expected: Fresnel's equations, as the name says, and the same picture in both.
# Seen: 4.5.15 has the approximation for metals that are far from the index of air (n^2 + k^2 much larger than 1), which leaves out the angle
# inside the metal: a dark metal is a fifth too dark, what has no extinction up to twice too bright, gold .2 % off.
# 5.0.1 has the equations. A file of such metals changes its look from one version to the other.
# Output of 2026-11-30 (Fresnel's equations: .259280, .059126, .938980):
#   Blender 4.5.15  n .82 and k .57: .207083, n 1.33 and k 0: .123096, n .18 and k 3.4: .940890
#   Blender 5.0.1   n .82 and k .57: .259280, n 1.33 and k 0: .059126, n .18 and k 3.4: .938979
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *


def fresnel(n, k, cos):
    t = np.sqrt((n * n - k * k - 1.0 + cos * cos) ** 2 + 4.0 * n * n * k * k)
    a = np.sqrt(0.5 * (t + n * n - k * k - 1.0 + cos * cos))
    s = ((a - cos) ** 2 + t - a * a) / ((a + cos) ** 2 + t - a * a)
    tan_sin = (1.0 - cos * cos) / cos
    return 0.5 * s * (1.0 + ((a - tan_sin) ** 2 + t - a * a) / ((a + tan_sin) ** 2 + t - a * a))


scene = empty_file()
world((1.0, 1.0, 1.0))
owner, metal = material("metal", "ShaderNodeBsdfMetallic", Roughness=0.0)
metal.fresnel_type = "PHYSICAL_CONDUCTOR"
plane(owner, 60.0)
for name, n, k, old in (("a dark metal", 0.82, 0.57, 0.207083), ("water", 1.33, 0.0, 0.123096), ("gold in red", 0.18, 3.4, 0.940890)):
    metal.inputs["IOR"].default_value, metal.inputs["Extinction"].default_value = (n,) * 3, (k,) * 3
    exact = fresnel(n, k, 0.5)
    print(f"  Fresnel's equations: {exact:.6f}")
    told(f"{name}, n {n} and k {k}", seen()[0], old if VERSION < (5, 0) else exact, 0.001)
done()
PYTHON
blenders 4.5.15 5.0.1
