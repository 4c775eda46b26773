# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated shader text: structure only, self-contained, nothing that the stack does not need."""

import re

import numpy as np
import pytest

from lamina.addon.material.shader_node import shader_of
from lamina.addon.shader.osl.generate import generate
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import SCATTERING
from lamina.reference_py.material.stack import Stack

COAT = {"kind": "dielectric", "ior": 1.4, "roughness": 0.2}
LAMBERT = {"kind": "lambert"}


def text_of(layers, base):
    return generate(make_lobe_set(Stack.from_dict({"layers": layers, "base": base}), "weidlich_wilkie")).text


CLEAR = [name for name in presets.names() if not any(layer.has(SCATTERING) for layer in presets.load(name).layers)]


@pytest.mark.parametrize("name", CLEAR)
def test_text_is_complete_small_and_self_contained(name):
    shader = generate(make_lobe_set(presets.load(name), "weidlich_wilkie"))
    assert "@" not in shader.text, "a placeholder was left"
    assert "#include" not in shader.text
    assert len(shader.text) < 100_000
    assert f"shader {shader.name}(" in shader.text
    for shader_input in shader.inputs:
        assert re.search(rf"^    (float|color|vector) {shader_input.osl_name} = ", shader.text, re.MULTILINE)


def test_values_do_not_change_the_text_and_structure_does():
    one = text_of([COAT], LAMBERT)
    assert one == text_of([{**COAT, "ior": 2.0, "tint": [0.1, 0.2, 0.3]}], {**LAMBERT, "color": [1, 0, 0]})
    assert one != text_of([{**COAT, "distribution": "beckmann"}], LAMBERT)
    assert one != text_of([COAT, COAT], LAMBERT)


def test_what_a_stack_lacks_is_not_generated():
    bare = text_of([], LAMBERT)
    assert "fresnel" not in bare and "weight_" not in bare and "masking" not in bare
    assert "fresnel_conductor" not in text_of([COAT], LAMBERT)
    assert "weight_glossy" not in text_of([COAT], LAMBERT)
    assert "artist_index" not in text_of([COAT], {"kind": "conductor"})
    assert "artist_index" in text_of([COAT], {"kind": "conductor", "reflectance": [0.9, 0.5, 0.3], "edge_color": [1, 1, 1]})


@pytest.mark.parametrize("name", ["glazed_mug", "frosted_paint"])
def test_baked_text_is_small_and_takes_no_parameters(name):
    shader = generate(make_lobe_set(presets.load(name), "baked"))
    assert "@" not in shader.text and not shader.inputs
    assert len(shader.text) < 20_000
    assert "fresnel" not in shader.text and "throughput" not in shader.text


def test_sums_nest_to_the_right():
    assert "BSDF = lobe_0 + (lobe_1 + (lobe_2 + lobe_3));" in text_of([COAT] * 3, LAMBERT)


def test_more_parameters_than_cycles_takes_are_refused():
    with pytest.raises(LaminaError, match="32 layers need 12. shader parameters, and Cycles takes 123"):
        text_of([COAT] * 32, LAMBERT)


@pytest.mark.blender
@pytest.mark.parametrize("layers", [0, 1, 2, 8, 30])
def test_any_number_of_layers_compiles(blender, layers):
    import bpy

    from lamina.addon.material.material import apply_stack

    for base in (LAMBERT, {"kind": "oren_nayar"}, {"kind": "conductor", "reflectance": [0.9, 0.5, 0.3], "edge_color": [1, 1, 1]}):
        material = bpy.data.materials.new("compiled")
        apply_stack(material, Stack.from_dict({"layers": [COAT] * layers, "base": base}))
        script = shader_of(material)
        assert script.bytecode


COATED = {"layers": [{**COAT, "tint": [0.9, 0.6, 0.3], "thickness": 1.0}], "base": {**LAMBERT, "color": [0.7, 0.4, 0.2]}}
METAL = {"base": {"kind": "conductor", "eta": [0.2, 0.9, 1.2], "k": [3.0, 2.5, 2.3], "roughness": 0.3}}
# A stack, a value of its topmost element, an end of its range and what lies beyond.
BEYOND = [
    (COATED, "IOR", 1.0, 0.5),
    (COATED, "IOR", 4.0, 9.0),
    (COATED, "Roughness", 1.0, 3.0),
    (COATED, "Thickness", 0.0, -1.0),
    (METAL, "IOR", 20.0, 40.0),
    (METAL, "Extinction", 0.0, -1.0),
    (METAL, "Roughness", 0.0, -2.0),
]


@pytest.mark.blender
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic"])
@pytest.mark.parametrize("stack, label, end, beyond", BEYOND, ids=[f"{label} {beyond:g}" for _, label, _, beyond in BEYOND])
def test_what_a_driver_gives_beyond_a_range_shows_as_its_end(blender, tier, stack, label, end, beyond):
    """An index of .5 gave an albedo above 1, one of 9 three quarters too much, a negative thickness light from nothing."""
    import bpy

    from lamina.addon.material.elements import node_of
    from lamina.addon.material.material import apply_stack
    from lamina.addon.rendering.measure import render_furnace

    new = bpy.data.materials.new("driven")
    apply_stack(new, Stack.from_dict(stack), tier)
    socket = node_of([*new.lamina.layers, new.lamina.base][0]).inputs[label]
    shown = []
    for value in (end, beyond):
        socket.default_value = value if socket.type == "VALUE" else (value,) * 3
        shown.append(render_furnace(new, [40.0], samples=16, size=8)[0])
    np.testing.assert_allclose(*shown, rtol=1e-5)
