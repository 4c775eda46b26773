#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# iadpython 0.5.3 (adding-doubling): a Sample's default quadrature has 4 directions, which is far off for forward scattering between interfaces.
# Expected: defaults that hold for a usual turbid slab, or a word when they do not.
# Seen: a slab of optical depth 1, albedo .5, g .9, index 1.4 reflects .0653 of diffuse light by default. 32 and 64 directions agree on .092;
# the collimated reflectance, .0386 for .0389, does not show it.
# Output of 2026-11-29, diffuse reflectance by number of directions:
#   4 (default) .0653     8 .0867     16 .0912     32 .0919     64 .0920
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=${PYTHON311:-python3.11}
"$python" -c 'import venv, ensurepip' 2>/dev/null || { echo "iad_quadrature: put python3.11 on the PATH, or name one in PYTHON311" >&2; exit 2; }
"$python" -m venv "$work/v"
"$work/v/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: iadpython==0.5.3 numpy==2.3.5 scipy==1.16.3 || exit 2
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
rc=0
"$work/v/bin/python" "$work/measure.py" || rc=$?
case $rc in 0) exit 0 ;; 3) exit 1 ;; *) echo "iad_quadrature: the measurement stopped (status $rc)" >&2; exit 2 ;; esac
