# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender 5's working spaces: a material looks the same in a file of Linear Rec.709, Linear Rec.2020 and ACEScg, however it came there."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import Roles, node_with
from lamina.addon.material.state import is_stale, lags
from lamina.addon.rendering.measure import render_furnace
from lamina.addon.shader.working_space import REC709, into_working, out_of_working, primaries
from lamina.reference_py.material.stack import Stack

pytestmark = [pytest.mark.blender, pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender before 5.0 has one working space")]

SPACES = ("Linear Rec.2020", "ACEScg")
# Saturated, so that a space that is ignored shows: a green glaze over red paint, and a metal by its colors under a coat.
STACKS = {
    "glaze": Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.2, "tint": [0.9, 0.8, 0.3]}], "base": {"kind": "lambert", "color": [0.8, 0.3, 0.1]}}),
    "metal": Stack.from_dict({"layers": [{"kind": "dielectric"}], "base": {"kind": "conductor", "reflectance": [0.9, 0.4, 0.1], "edge_color": [1.0, 0.7, 0.4], "roughness": 0.3}}),
    "rough": Stack.from_dict({"base": {"kind": "oren_nayar", "color": [0.1, 0.3, 0.8], "sigma_deg": 40.0}}),
}  # fmt: skip
TOLERANCE = 0.01


def set_space(name: str, convert: bool = True) -> None:
    bpy.ops.wm.set_working_color_space(working_space=name, convert_colors=convert)


def made(name: str, tier: str, backend: str = "auto") -> bpy.types.Material:
    owner = bpy.data.materials.new(name)
    materials.apply_stack(owner, STACKS[name], tier, backend)
    materials.refresh(owner, settle=True)
    return owner


def seen(owner) -> np.ndarray:
    """Albedo at 40 degrees in linear Rec.709, what the file's space is."""
    return out_of_working(render_furnace(owner, (40.0,), samples=64, size=8)[0][0])


@pytest.fixture
def expected(blender):
    """What each material is in a file of Rec.709, by name, tier and backend."""
    return {}


@pytest.mark.parametrize("backend", ["osl", "nodes"])
@pytest.mark.parametrize("tier", ["weidlich_wilkie", "analytic", "baked"])
@pytest.mark.parametrize("name", STACKS)
def test_a_material_looks_the_same_in_every_space(blender, name, tier, backend):
    expected = seen(made(name, tier, backend))
    assert max(expected) > 1.5 * min(expected)
    for space in SPACES:
        set_space(space)
        owner = made(name, tier, backend)
        assert seen(owner) == pytest.approx(expected, rel=TOLERANCE), space
        assert materials.stack_of(owner).to_dict()["base"]["kind"] == STACKS[name].base.kind
        for ours, theirs in zip(materials.stack_of(owner).base.values.values(), STACKS[name].base.values.values()):
            assert ours == theirs or np.allclose(ours, theirs, atol=1e-5)


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_a_space_that_is_ignored_would_be_seen(blender, backend):
    """The deliberate fault: the same numbers in another space, unconverted and not made anew."""
    owner = made("glaze", "baked", backend)
    expected = seen(owner)
    set_space("ACEScg", convert=False)
    assert not np.allclose(seen(owner), expected, rtol=5 * TOLERANCE)
    assert is_stale(owner) and "shader_stale" in [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("tier", ["analytic", "baked"])
def test_blenders_operator_converts_and_a_save_keeps_it_right(blender, tmp_path, space, tier):
    owner = made("glaze", tier)
    expected = seen(owner)
    set_space(space)
    for backend in ("osl", "nodes"):
        with_one = owner.copy()
        with_one.node_tree.nodes.remove(node_with(with_one, "nodes" if backend == "osl" else "osl"))
        with_one.node_tree.links.new(node_with(with_one, backend).outputs["BSDF"], with_one.node_tree.get_output_node("ALL").inputs["Surface"])
        assert seen(with_one) == pytest.approx(expected, rel=TOLERANCE), backend
        bpy.data.materials.remove(with_one)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    assert not is_stale(owner) and not lags(owner)
    assert [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code in ("shader_edited", "shader_stale")] == []
    assert seen(owner) == pytest.approx(expected, rel=TOLERANCE)


@pytest.mark.parametrize("link", [False, True], ids=["append", "link"])
@pytest.mark.parametrize("there", SPACES)
def test_a_material_of_a_file_of_another_space(blender, tmp_path, there, link):
    owner = made("glaze", "baked")
    owner.use_fake_user = True
    expected = seen(owner)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    set_space(there)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=link) as (_, wanted):
        wanted.materials = ["glaze"]
    owner = wanted.materials[0]
    assert seen(owner) == pytest.approx(expected, rel=TOLERANCE)
    assert "shader_stale" not in [f.code for f in check.find(owner, bpy.context.scene, bpy.context.preferences)]


def textured(tier: str, backend: str, labels=()) -> bpy.types.Material:
    """The glaze over a color that an RGB node gives, which stands for a texture, and where the glaze's values come from nodes too."""
    owner = made("glaze", tier, backend)
    node = owner.node_tree.nodes.new("ShaderNodeRGB")
    node.outputs[0].default_value = (*into_working((0.2, 0.7, 0.1)), 1.0)
    owner.node_tree.links.new(node.outputs[0], node_of(owner.lamina.base).inputs["Color"])
    for label in labels:
        node, socket = owner.node_tree.nodes.new("ShaderNodeValue"), node_of(owner.lamina.layers[0]).inputs[label]
        node.outputs[0].default_value = socket.default_value
        owner.node_tree.links.new(node.outputs[0], socket)
    materials.refresh(owner, settle=True)
    return owner


@pytest.mark.parametrize(
    "tier, backend, labels", [("analytic", "osl", ()), ("baked", "osl", ()), ("baked", "nodes", ()), ("baked", "osl", ("Thickness", "Roughness"))]
)
def test_a_texture_is_in_the_working_space(blender, tmp_path, tier, backend, labels):
    """Its color is the same light in every space, also once Blender has converted the file."""
    expected = seen(textured(tier, backend, labels))
    for space in SPACES:
        set_space(space)
        assert seen(textured(tier, backend, labels)) == pytest.approx(expected, rel=TOLERANCE), space
    set_space(REC709)
    owner = textured(tier, backend, labels)
    set_space("ACEScg")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    assert not is_stale(owner) and seen(owner) == pytest.approx(expected, rel=TOLERANCE)


@pytest.mark.parametrize("backend", ["osl", "nodes"])
def test_a_bare_metal_of_textured_values_is_the_same_in_every_space(blender, backend):
    """Its Fresnel curve is that of Rec.709's channels; stock nodes have fits in other spaces, whose energies are 2 % off at most."""
    seen_in = {}
    for space in (REC709, *SPACES):
        set_space(space)
        owner = bpy.data.materials.new("bare metal")
        materials.apply_stack(owner, Stack.from_dict({"base": STACKS["metal"].base.to_dict()}), "baked", backend)
        for label, value in (("Reflectance", (0.9, 0.4, 0.1)), ("Roughness", 0.5)):
            given = owner.node_tree.nodes.new("ShaderNodeRGB" if label == "Reflectance" else "ShaderNodeValue")
            given.outputs[0].default_value = (*into_working(value), 1.0) if label == "Reflectance" else value
            owner.node_tree.links.new(given.outputs[0], node_of(owner.lamina.base).inputs[label])
        materials.refresh(owner, settle=True)
        seen_in[space] = seen(owner)
    assert max(seen_in[REC709]) > 3.0 * min(seen_in[REC709])
    for space in SPACES:
        assert seen_in[space] == pytest.approx(seen_in[REC709], rel=0.02 if backend == "nodes" else 2e-3), space


def test_what_exporters_find_is_in_the_working_space(blender):
    found = []
    for space in (REC709, "ACEScg"):
        set_space(space)
        owner = made("glaze", "analytic")
        principled = Roles(owner.node_tree).get("principled")
        found.append([out_of_working(principled.inputs["Base Color"].default_value[:3]), out_of_working(owner.diffuse_color[:3])])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-3)


def test_a_color_outside_rec709_is_limited_and_named(blender):
    set_space("ACEScg")
    owner = made("glaze", "analytic")
    node_of(owner.lamina.base).inputs["Color"].default_value = (0.05, 0.9, 0.05, 1.0)
    named = [f.text() for f in check.find(owner, bpy.context.scene, bpy.context.preferences) if f.code == "out_of_gamut"]
    assert named == ["Lambert: Color lies outside linear Rec.709, in which the model computes, and is limited to it"]
    assert min(materials.stack_of(owner).base["color"]) == 0.0


def test_greys_are_the_same_everywhere(blender):
    """What ramps of numbers rely on."""
    for space in SPACES:
        set_space(space)
        np.testing.assert_allclose(primaries().sum(axis=0), 1.0, atol=1e-5)
