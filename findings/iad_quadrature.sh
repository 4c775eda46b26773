#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# iadpython 0.5.3 (adding-doubling): a Sample's default quadrature has 4 directions, which is far off for forward scattering between interfaces.
# Expected: defaults that hold for a usual turbid slab, or a word when they do not.
# Seen: a slab of optical depth 1, albedo .5, g .9, index 1.4 reflects .0653 of diffuse light by default. 32 and 64 directions agree on .092;
# the collimated reflectance, .0386 for .0389, does not show it.
# Output of 2026-11-29, diffuse reflectance by number of directions:
#   4 (default) .0653     8 .0867     16 .0912     32 .0919     64 .0920
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
import sys

import iadpython

changed = False
for directions, expected in ((None, 0.0653), (8, 0.0867), (16, 0.0912), (32, 0.0919), (64, 0.0920)):
    sample = iadpython.Sample(a=0.5, b=1, g=0.9, n=1.4)
    if directions is not None:
        sample.quad_pts = directions
    diffuse = float(sample.rt()[2])
    same = abs(diffuse - expected) < 1e-4
    changed |= not same
    print(f"  {sample.quad_pts} directions: {diffuse:.4f}" + ("" if same else f"    CHANGED, expected {expected}"))
sys.exit(3 if changed else 0)
PYTHON
packages iadpython==0.5.3 numpy==2.3.5 scipy==1.16.3
