# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic` on Cycles: the shader computes what the numpy lobe set computes, in float32 and from sockets."""

import re

import pytest
from support.goniometer import SUN_THETA_DEG, parity, tolerance

from lamina.addon.shader.osl.generate import generate
from lamina.reference_py.lobes.methods import make_lobe_set, provisional
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.registry import make_model
from lamina.study.suite import suite, suite_stack

pytestmark = pytest.mark.blender

STACKS = {
    **{name: presets.load(name) for name in ("frosted_metal", "metallic_car_paint", "blue_wall_paint", "clean_copper", "tinted_glaze")},
    **{
        name: suite_stack(name)
        for name in ("oren_nayar_clay", "plastic_tinted_deep", "gold_coat_0_3_metal_0_05", "beckmann_over_ggx", "artist_metal_coated",
                     "air_gap_rough", "equal_index_rough_inside", "water_on_stone", "three_rough", "falling_index", "eight_layers")
    },
}  # fmt: skip


# What stands in for a bake is written as loops, however few its layers are.
STANDING_IN = ("metallic_car_paint", "plastic_tinted_deep")


@pytest.mark.parametrize(("name", "tier"), [*((name, "analytic") for name in STACKS), *((name, "baked") for name in STANDING_IN)])
def test_render_equals_mirror(blender, name, tier):
    from lamina.addon.material.material import apply_stack, stack_of
    from lamina.addon.material.state import is_settled

    material = blender.data.materials.new("Parity")
    apply_stack(material, STACKS[name], tier)
    assert is_settled(material) == (tier == "analytic")
    # what the sockets hold, rounded to float32, is what was rendered
    stack = stack_of(material)
    model = make_model("closure_model", stack, method="analytic")
    for theta in SUN_THETA_DEG:
        result = parity(material, model.f, theta)
        print(f"{name} sun {theta:g} deg: 99th percentile {result.percentile_99:.1e} of {result.errors.size} values")
        assert result.finite and result.errors.size > 30
        assert result.percentile_99 <= tolerance(stack)


def test_what_stands_in_is_much_less_code(tmp_path):
    """It is compiled within a click: what the compiler writes says how long that takes, on any machine."""
    import _cycles

    def compiled(made) -> int:
        (tmp_path / "shader.osl").write_text(generate(made).text, encoding="utf-8")
        assert _cycles.osl_compile(str(tmp_path / "shader.osl"), str(tmp_path / "shader.oso"))
        return (tmp_path / "shader.oso").stat().st_size

    for name in ("clear_coat_car_paint", "metallic_car_paint"):
        stack = presets.load(name)
        sizes = compiled(provisional(stack)), compiled(make_lobe_set(stack, "analytic"))
        assert sizes[0] < 0.5 * sizes[1], (name, sizes)


def test_text_size():
    sizes = {name: len(generate(make_lobe_set(stack, "analytic")).text) for name, stack in suite().items()}
    print(max(sizes.items(), key=lambda item: item[1]))
    assert max(sizes.values()) < 100_000


def test_text_does_not_depend_on_values():
    data = suite_stack("three_rough").to_dict()
    other = Stack.from_dict({**data, "layers": [{**layer, "ior": 1.7, "roughness": 0.2} for layer in data["layers"]]})
    assert generate(make_lobe_set(other, "analytic")).text == generate(make_lobe_set(suite_stack("three_rough"), "analytic")).text


def test_functions_are_defined_once_where_tiers_meet():
    """A patch with a film is in the tier `weidlich_wilkie`: parts that both tiers use are in the text once."""
    coat, film = {"kind": "dielectric", "roughness": 0.5}, {"film_thickness": 300.0, "film_ior": 1.8}
    metal = {"kind": "conductor", "metal": "gold", "roughness": 0.5}
    stack = Stack.from_dict({"layers": [{**coat, **film, "coverage": 0.5}, coat], "base": metal})
    text = generate(make_lobe_set(stack, "analytic")).text
    signatures = re.findall(r"^\w+ \w+\([^)]*\)(?=\n\{)", text, re.MULTILINE)
    assert any("weight_glossy" in s for s in signatures) and any("cross_first" in s for s in signatures)
    assert len(signatures) == len(set(signatures))
