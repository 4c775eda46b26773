# SPDX-License-Identifier: GPL-3.0-or-later
"""What bakes reflect of a white world, beside what their lobes should by the formula, in this Blender.

Run by `make tilted-lobes`; nothing is asserted. Blender 4.5 samples tilted lobes below their own horizon, see
tests/addon/test_tilted_lobes.py. The last column is of lamps, which evaluate: the 99th percentile of a sphere's pixels in the sun.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import material as materials
from lamina.addon.rendering.measure import render_furnace
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model

sys.path.append(str(Path(__file__).parents[1]))
from support.goniometer import parity

THETA_DEG = (0.0, 30.0, 60.0, 75.0, 85.0)
WHITE = Stack.from_dict(
    {
        "name": "white under a rough coat",
        "layers": [{"kind": "dielectric", "roughness": 0.3}],
        "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]},
    }
)


def main() -> None:
    ensure_osl_query_on_path()
    lamina.register()
    print(f"Blender {bpy.app.version_string}: measured over formula - 1 in a white world, the channel that is most off, in %")
    print(f"{'':34}" + "".join(f"{theta:>7.0f}°" for theta in THETA_DEG) + "   sun")
    worst = 0.0
    for stack in (*(presets.load(name) for name in presets.names()), WHITE):
        material = bpy.data.materials.new("tilted")
        materials.apply_stack(material, stack, "baked")
        materials.refresh(material, settle=True)
        model = make_model("closure_model", materials.stack_of(material), method="baked")
        formula = model.albedo(spherical(np.radians(THETA_DEG), 0.0))
        measured, _ = render_furnace(material, THETA_DEG, samples=128)
        off = np.take_along_axis(measured / formula - 1.0, np.argmax(np.abs(measured / formula - 1.0), axis=1)[:, None], 1)[:, 0]
        worst = max(worst, np.abs(off).max())
        sun = parity(material, model.f, 45.0).percentile_99
        print(f"{stack.name:34}" + "".join(f"{100.0 * v:>8.2f}" for v in off) + f"{100.0 * sun:>6.2f}", flush=True)
    print(f"at most {100.0 * worst:.2f} %")


if __name__ == "__main__":
    main()
