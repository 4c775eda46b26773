#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: a thin film on an OSL closure is left out without an error where its thickness is written as a whole number.
# Expected: a number is a number, as everywhere else in OSL: dielectric_bsdf(..., "thinfilm_thickness", 400, "thinfilm_ior", 1.8) has a film
# of 400 nm; and what one Blender's stdcycles.h declares works or is refused.
# Seen: a keyword's value is not converted, so 400 is an int and the keyword does not apply: a warning on the console, then the shader renders without the film.
# float(400) has it in 5.3.0. In 4.5.15 dielectric_bsdf takes the keywords and shows no film either way.
# Output of 2026-11-29, red reflected along the normal, .0356 without a film: 400 .0356, 400.0 and float(400) .0998 in 5.3.0; all .0356 in 4.5.15
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

DIELECTRIC = 'dielectric_bsdf(N, vector(1, 0, 0), color(1), color(0), 0.3, 0.3, 1.5, "ggx"{film})'


def reflected(film):
    scene = empty_file(osl=True)
    scene.cycles.samples = 64
    world((1.0, 1.0, 1.0))
    owner, output = material("filmed")
    script = script_node(owner.node_tree, f"shader filmed(output closure color BSDF = 0) {{ BSDF = {DIELECTRIC.format(film=film)}; }}")
    owner.node_tree.links.new(script.outputs["BSDF"], output.inputs["Surface"])
    plane(owner)
    return seen()


plain = reflected("")
for thickness in ("400", "400.0", "float(400)"):
    filmed = reflected(f', "thinfilm_thickness", {thickness}, "thinfilm_ior", 1.8')
    differs = float(np.max(np.abs(filmed / plain - 1.0)))
    print(f"  thickness {thickness}: {' '.join(f'{c:.4f}' for c in filmed)}, without a film {' '.join(f'{c:.4f}' for c in plain)}")
    told("  a film shows", differs > 0.1, VERSION >= (5, 3) and thickness != "400")
done()
PYTHON
blenders 4.5.15 5.3.0
