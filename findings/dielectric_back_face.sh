#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0, OSL in Cycles: dielectric_bsdf on a back face.
# Expected: a closure gets the index that the shader gives it, on both sides; whoever wants the inverse inside a solid passes it, by
# backfacing(), as shaders had to up to 5.2.
# Seen: from 5.3 on Cycles takes the inverse of the index on a back face, so that a coat on a surface whose faces point inwards reflects
# as glass does from inside, with total reflection; a generalized_schlick_bsdf whose exponent is the negative index does too. conductor_bsdf
# of no extinction, which has the same curve, does not (but is approximate in 4.5).
# Output of 2026-11-28, albedo at 60 degrees of index 1.5, alpha .01, front and back: 4.5.15 dielectric .0892 .0892, conductor .1353 .1353;
#   5.3.0 dielectric .0892 1.0000, conductor .0892 .0892
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

SHAPE = 'N, vector(1, 0, 0), {} 0.01, 0.01, {}, "ggx"'
CLOSURES = {
    "dielectric": "dielectric_bsdf(" + SHAPE.format("color(1), color(0),", "1.5") + ")",
    "conductor": 'conductor_bsdf(N, vector(1, 0, 0), 0.01, 0.01, color(1.5), color(0), "ggx")',
}
for name, closure in CLOSURES.items():
    for side in ("front", "back"):
        empty_file(osl=True)
        world((1.0, 1.0, 1.0))
        owner, output = material(name)
        source = f"shader asked(output closure color Found = 0) {{ Found = {closure}; }}"
        owner.node_tree.links.new(script_node(owner.node_tree, source).outputs[0], output.inputs["Surface"])
        shown = plane(owner, 60.0)
        if side == "back":
            shown.data.flip_normals()
        expected = 1.0 if (name, side) == ("dielectric", "back") and VERSION >= (5, 3) else 0.1353 if name == "conductor" and VERSION < (5, 0) else 0.0892
        told(f"{name}, {side}", float(seen()[0]), expected, 0.002)
done()
PYTHON
blenders 4.5.15 5.3.0
