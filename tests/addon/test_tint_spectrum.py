# SPDX-License-Identifier: GPL-3.0-or-later
"""A tint that is a spectrum stays one in a Blender file, follows the thickness, and gives way to a tint that somebody sets."""

import numpy as np
import pytest

pytest.importorskip("bpy")

import bpy

from lamina.addon.material import material
from lamina.addon.material.elements import node_of
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.material.tint_spectrum import spectrum_of

pytestmark = pytest.mark.blender

SPECTRUM = {"wavelengths_nm": [400.0, 500.0, 700.0], "transmittance": [0.6, 0.8, 1.0], "measured_by": "nobody"}


def glaze(thickness):
    return Stack.from_dict({"layers": [{"kind": "dielectric", "thickness": thickness, "tint_spectrum": SPECTRUM}], "base": {"kind": "lambert"}})


def test_the_spectrum_travels_with_the_material(blender):
    new = bpy.data.materials.new("glaze")
    material.apply_stack(new, glaze(1.0), "analytic", "osl")
    read = material.stack_of(new).layers[0]
    assert read["tint"] == pytest.approx(glaze(1.0).layers[0]["tint"], abs=1e-6)
    assert spectrum_of(read)[1] == (0.6, 0.8, 1.0) and read.unknown["tint_spectrum"]["measured_by"] == "nobody"
    inputs = node_of(new.lamina.layers[0]).inputs
    inputs["Thickness"].default_value = 5.0
    assert material.stack_of(new).layers[0]["tint"] == pytest.approx(glaze(5.0).layers[0]["tint"], abs=1e-6)
    inputs["Tint"].default_value = (0.2, 0.3, 0.4, 1.0)
    painted = material.stack_of(new).layers[0]
    assert painted["tint"] == pytest.approx((0.2, 0.3, 0.4)) and spectrum_of(painted) is None
    assert np.array_equal(painted.unknown["tint_spectrum"]["transmittance"], SPECTRUM["transmittance"])
