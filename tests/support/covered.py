# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of covered layers, and their pictures."""

import bpy

from lamina.addon.material import material
from lamina.addon.rendering.measure import render_sun_sphere
from lamina.reference_py.material.stack import Stack

VARNISH = {"kind": "dielectric", "ior": 1.5, "roughness": 0.5, "tint": [0.9, 0.5, 0.3]}
GLAZE = {"kind": "dielectric", "ior": 1.8, "roughness": 0.6, "distribution": "beckmann"}
GREY = {"kind": "lambert", "color": [0.5, 0.4, 0.3]}
GOLD = {"kind": "conductor", "metal": "gold", "roughness": 0.5}


def layered(layers, base, tier, backend="osl"):
    """A material that shows the lobe set of its tier, baked if it must be."""
    new = bpy.data.materials.new("covered")
    material.apply_stack(new, Stack.from_dict({"layers": layers, "base": base}), tier, backend)
    material.refresh(new, settle=tier == "baked")
    return new


def picture(layers, base, tier, backend="osl"):
    return render_sun_sphere(layered(layers, base, tier, backend), 45.0, 48)["radiance"]
