# SPDX-License-Identifier: GPL-3.0-or-later
"""MaterialX graphs of BSDFs: what they mean as stacks, their light, and stacks that go out and come back."""

import numpy as np
import pytest

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.bsdf_albedo import light_of
from lamina.reference_py.exchange.bsdf_tree import BURLEY, CONDUCTOR, DEFAULTS, DIELECTRIC, OREN_NAYAR, SCHLICK, Layered, Leaf, Scaled
from lamina.reference_py.exchange.layer_graph_writing import to_layers
from lamina.reference_py.exchange.matching import mean
from lamina.reference_py.exchange.materialx import from_mtlx, layers_to_mtlx
from lamina.reference_py.exchange.report import APPROXIMATED, LOST
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.optical_stack import OpticalStack

PLASTIC = """<dielectric_bsdf name="gloss" type="BSDF"><input name="ior" type="float" value="1.5"/><input name="roughness" type="vector2" nodename="r"/></dielectric_bsdf>
<roughness_anisotropy name="r" type="vector2"><input name="roughness" type="float" value="0.25"/></roughness_anisotropy>
<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value="0.6,0.1,0.05"/></oren_nayar_diffuse_bsdf>
<burley_diffuse_bsdf name="chalk" type="BSDF"><input name="color" type="color3" value="0.2,0.5,0.05"/><input name="roughness" type="float" value="0.5"/></burley_diffuse_bsdf>
<artistic_ior name="a" type="multioutput"><input name="reflectivity" type="color3" value="0.9,0.7,0.4"/><input name="edge_color" type="color3" value="0.9,0.8,0.6"/></artistic_ior>
<conductor_bsdf name="metal" type="BSDF"><input name="ior" type="color3" nodename="a" output="ior"/><input name="extinction" type="color3" nodename="a" output="extinction"/>
<input name="roughness" type="vector2" value="0.16,0.04"/></conductor_bsdf>
<sheen_bsdf name="velvet" type="BSDF"/><subsurface_bsdf name="wax" type="BSDF"><input name="color" type="color3" value="0.3,0.3,0.2"/></subsurface_bsdf>
<layer name="plastic" type="BSDF"><input name="top" type="BSDF" nodename="gloss"/><input name="base" type="BSDF" nodename="paint"/></layer>"""


def document(more, bsdf, surface=""):
    shader = f'<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="{bsdf}"/>{surface}</surface>'
    material = '<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    return f'<materialx version="1.39" colorspace="lin_rec709">{PLASTIC}{more}{shader}{material}</materialx>'


def read(more, bsdf, surface=""):
    (material,) = from_mtlx(document(more, bsdf, surface))
    return material.to_stack()


def joined(kind, name, **links):
    inputs = "".join(
        f'<input name="{k}" type="BSDF" nodename="{v}"/>' if isinstance(v, str) else f'<input name="{k}" type="float" value="{v}"/>' for k, v in links.items()
    )
    return f'<{kind} name="{name}" type="BSDF">{inputs}</{kind}>'


def said(converted, fate):
    return " ".join(str(loss) for loss in converted.report.of(fate))


def test_layers_are_the_surface_that_they_make():
    """A gloss over paint is what standard_surface says of it, whose own graph is this one."""
    inputs = '<input name="base_color" type="color3" value="0.6,0.1,0.05"/><input name="base" type="float" value="1"/><input name="specular_roughness" type="float" value="0.25"/>'
    (same,) = from_mtlx(
        f'<materialx version="1.39" colorspace="lin_rec709"><standard_surface name="s" type="surfaceshader">{inputs}</standard_surface></materialx>'
    )
    layered, plain = read("", "plastic"), same.to_stack()
    np.testing.assert_allclose(layered.stack.base["color"], plain.stack.base["color"], atol=3e-4)  # measured: 2e-4, as that is solved to 1e-4
    for key in ("ior", "roughness"):
        assert layered.stack.layers[0][key] == pytest.approx(plain.stack.layers[0][key])
    assert not layered.report.losses and layered.report.match.soft_light == pytest.approx(plain.report.match.soft_light, abs=2e-4)


def test_a_metal_below_layers_is_followed_through_its_colors():
    metal = read("", "metal").stack
    np.testing.assert_allclose(metal.base["reflectance"], (0.9, 0.7, 0.4), atol=0.02)
    assert metal.base["roughness"] == pytest.approx((0.16 * 0.04) ** 0.25) and metal.base["anisotropy"] == pytest.approx((1.0 - 0.25) / 0.9)
    turned = read(joined("layer", "coated", top="gloss", base="metal"), "coated").stack
    assert turned.layers[0].kind == "dielectric" and turned.base.kind == "conductor"


def test_a_mix_of_coated_and_bare_is_a_coverage_and_one_with_a_metal_an_opaque_layer():
    part = read(joined("mix", "x", bg="paint", fg="plastic", mix=0.3), "x").stack
    assert part.layers[0]["coverage"] == pytest.approx(0.3) and part.base.kind == "lambert"
    other = read(joined("mix", "x", bg="plastic", fg="paint", mix=0.3), "x").stack
    assert other.layers[0]["coverage"] == pytest.approx(0.7)
    spots = read(joined("mix", "x", bg="plastic", fg="metal", mix=0.2), "x").stack
    assert spots.layers[0].kind == "conductor" and spots.layers[0]["coverage"] == pytest.approx(0.2) and spots.layers[1].kind == "dielectric"
    assert read(joined("mix", "x", bg="plastic", fg="metal", mix=1.0), "x").stack.base.kind == "conductor"
    paints = read(joined("mix", "x", bg="paint", fg="wax", mix=0.5), "x").stack
    np.testing.assert_allclose(paints.base["color"], (0.45, 0.2, 0.125), atol=1e-4)
    assert not paints.layers


def test_sums_and_factors():
    added = read(joined("add", "x", in1="gloss", in2="paint"), "x")
    assert added.stack.layers[0]["ior"] == 1.5 and "as a layer on top" in said(added, APPROXIMATED)
    factor = '<multiply name="x" type="BSDF"><input name="in1" type="BSDF" nodename="{}"/><input name="in2" type="color3" {}/></multiply>'
    half = read(factor.format("paint", 'value="0.5,0.5,0.5"'), "x")
    np.testing.assert_allclose(half.stack.base["color"], (0.3, 0.05, 0.025), atol=1e-4)
    power = '<power name="p" type="color3"><input name="in1" type="color3" value="0.8,0.9,0.95"/><input name="in2" type="float" value="1"/></power>'
    tinted = read(power + factor.format("paint", 'nodename="p"') + joined("layer", "y", top="gloss", base="x"), "y").stack
    assert tinted.layers[0]["tint"] == (0.8, 0.9, 0.95) and tinted.layers[0]["thickness"] == pytest.approx(0.5)
    plain = read(factor.format("wax", 'value="0.64,0.81,0.9"') + joined("layer", "y", top="gloss", base="x"), "y").stack
    np.testing.assert_allclose(np.power(plain.layers[0]["tint"], 2.0 * plain.layers[0]["thickness"]), (0.64, 0.81, 0.9))


def test_what_no_stack_has_is_lost_with_its_light():
    velvet = read(joined("layer", "x", top="velvet", base="paint"), "x")
    assert "sheen_bsdf" in said(velvet, LOST) and 0.05 < velvet.report.match.lost_light < 0.5
    glass = '<dielectric_bsdf name="glass" type="BSDF"><input name="scatter_mode" type="string" value="RT"/></dielectric_bsdf>'
    assert read(glass, "glass").report.match.lost_light > 0.85
    lamp = '<uniform_edf name="e" type="EDF"><input name="color" type="color3" value="2,2,2"/></uniform_edf>'
    glowing = read(lamp, "paint", '<input name="edf" type="EDF" nodename="e"/>')
    assert glowing.report.match.lost_light == pytest.approx(6.0 / 6.75, abs=0.01) and "emission" in said(glowing, LOST)
    chalk = read("", "chalk")
    assert "as a Lambert base" in said(chalk, APPROXIMATED) and chalk.report.match.color_difference < 0.01
    hidden = read(joined("layer", "x", top="metal", base="paint"), "x")
    assert hidden.stack.base.kind == "conductor" and "hides" in said(hidden, LOST)


def test_graphs_that_cannot_be_read_are_refused_in_one_line():
    for more, bsdf, words in (
        ('<chiang_hair_bsdf name="h" type="BSDF"/>', "h", "h is chiang_hair_bsdf, which no stack has; known are layer, mix"),
        (joined("layer", "x", top="gloss", base="x"), "x", "too large, or runs in a circle"),
        ("", "gone", "s has no BSDF"),
        (joined("multiply", "x", in2=0.5), "x", "lacks the BSDF"),
        ('<sheen_bsdf name="q" type="BSDF"><input name="color" type="color3" value="1,2"/></sheen_bsdf>', "q", "three numbers"),
    ):
        with pytest.raises(LaminaError, match=words):
            read(more, bsdf)


def test_a_place_that_is_not_followed_is_said_of_a_mask_and_of_a_normal():
    more = '<fractal3d name="f" type="vector2"/><normalmap name="n" type="vector3"><input name="in" type="vector3" nodename="vector3_i"/></normalmap>'
    for kind in ("float", "vector3"):
        more += f'<image name="{kind}_i" type="{kind}"><input name="file" type="filename" value="i.png"/><input name="texcoord" type="vector2" nodename="f"/></image>'
    more += '<oren_nayar_diffuse_bsdf name="wall" type="BSDF"><input name="normal" type="vector3" nodename="n"/></oren_nayar_diffuse_bsdf>'
    mask = '<input name="mix" type="float" nodename="float_i"/></mix>'
    (material,) = from_mtlx(document(more + joined("mix", "x", bg="wall", fg="plastic").replace("</mix>", mask), "x"))
    assert [loss.parameter for loss in material.losses if "it lies on the plain UVs" in str(loss)] == ["x mix", "wall normal"]


def test_a_mean_beyond_its_range_is_limited_and_said():
    """As that of an image times two is: of a color, a share, a roughness, and a film's index, which begins at 1."""

    def fed(name, kind):
        return f'<input name="{name}" type="{kind}" nodename="{kind}_picture"/>'

    more = "".join(f'<image name="{k}_picture" type="{k}"><input name="file" type="filename" value="{k}.png"/></image>' for k in ("float", "color3"))
    more += f'<oren_nayar_diffuse_bsdf name="wall" type="BSDF">{fed("color", "color3")}{fed("roughness", "float")}</oren_nayar_diffuse_bsdf>'
    more += f'<dielectric_bsdf name="film" type="BSDF">{fed("thinfilm_ior", "float")}</dielectric_bsdf>'
    more += joined("layer", "coated", top="film", base="wall")
    more += joined("mix", "x", bg="wall", fg="coated").replace("</mix>", fed("mix", "float") + "</mix>")
    (material,) = from_mtlx(document(more, "x"))
    means = {given: np.array([1.58, 0.5, -0.1]) if given.endswith("color") else np.array([1.6]) for given in material.images}
    there = material.with_means(means | {"film thinfilm_ior": np.array([0.4])})
    mixed, wall = there.tree, there.tree.first
    assert mixed.share == 1.0 and wall.values["color"] == (1.0, 0.5, 0.0) and wall.values["roughness"] == 1.0
    assert mixed.second.top.values["thinfilm_ior"] == 1.0 and mixed.second.base == wall
    told = [str(loss) for loss in there.losses]
    assert len(told) == 4 and "approximated: wall color 1.58 0.5 -0.1: its mean is out of its range; limited to 1 0.5 0" in told, told
    (again,) = from_mtlx(document(more, "wall"))
    assert again.with_means({"wall color": means["wall color"]}).to_stack().stack.base["color"][0] == pytest.approx(1.0, abs=1e-3)


def leaf(kind, **values):
    return Leaf(kind, kind, DEFAULTS[kind] | values)


def test_light_is_neither_made_nor_lost():
    white = leaf(OREN_NAYAR, color=(1.0,) * 3)
    for roughness in ((0.0, 0.0), (0.36, 0.09)):
        np.testing.assert_allclose(light_of(Layered(leaf(DIELECTRIC, roughness=roughness), white)).back, 1.0, atol=1e-9)
        np.testing.assert_allclose(mean(light_of(leaf(SCHLICK, roughness=roughness)).back), 1.0, atol=2e-3)
    metal = {"ior": (0.2, 0.9, 1.1), "extinction": (3.9, 2.4, 2.1)}
    f0 = [((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2) for n, k in zip(*metal.values())]
    np.testing.assert_allclose(light_of(leaf(CONDUCTOR, roughness=(0.0, 0.0), **metal)).back[-1], f0, atol=1e-3)
    np.testing.assert_allclose(light_of(Scaled(white, (0.25, 0.5, 1.0))).back[0], (0.25, 0.5, 1.0))
    # Burley 2012: a smooth one darkens at grazing, a rough one brightens
    smooth, rough = (light_of(leaf(BURLEY, color=(1.0,) * 3, roughness=r)).back[:, 0] for r in (0.0, 1.0))
    assert smooth[0] < smooth[-1] and rough[0] > rough[-1]


# measured: colors within 1e-5, of the metal below two tinted layers 7e-5
@pytest.mark.parametrize("name", ("glossy_plastic", "rusted_painted_steel", "lacquered_brass", "brushed_nickel", "patina_copper", "clear_coat_car_paint"))
def test_a_stack_that_goes_out_comes_back(name):
    stack = presets.load(name)
    graph = to_layers(stack)
    (material,) = from_mtlx(layers_to_mtlx(graph.tree, name))
    back = material.to_stack()
    assert material.name and not material.losses and graph.report.match.color_difference < 0.1
    assert not back.report.losses
    assert_same(stack, back.stack)


def test_covered_and_turned_layers_come_back():
    covered = {"kind": "dielectric", "ior": 1.5, "roughness": 0.2, "coverage": 0.5, "tint": [0.5, 0.6, 0.7], "thickness": 2.0}
    brushed = {"kind": "dielectric", "ior": 1.7, "roughness": 0.3, "anisotropy": 0.5, "rotation": 0.2, "distribution": "beckmann"}
    base = {"kind": "oren_nayar", "color": [0.5, 0.2, 0.1], "sigma_deg": 30.0}
    for layers, below in (([covered, brushed], base), ([covered], {"kind": "conductor", "metal": "gold", "roughness": 0.3, "film_thickness": 300.0})):
        stack = Stack.from_dict({"layers": layers, "base": below})
        graph = to_layers(stack)
        (material,) = from_mtlx(layers_to_mtlx(graph.tree, "covered"))
        assert_same(stack, material.to_stack().stack)


def assert_same(old, new):
    assert [layer.kind for layer in (*old.layers, old.base)] == [layer.kind for layer in (*new.layers, new.base)]
    for a, b in zip((*old.layers, old.base), (*new.layers, new.base)):
        for key in a.values:
            if key == "distribution":
                assert a[key] == b[key]
            elif key not in ("metal", "eta", "k", "reflectance", "edge_color"):
                np.testing.assert_allclose(b[key], a[key], atol=2e-4, err_msg=key)
        if a.kind == "conductor":
            bases = [OpticalStack.of(Stack((), e if e is old.base or e is new.base else e.as_base())).base for e in (a, b)]
            for cos in (1.0, 0.3):
                np.testing.assert_allclose(bases[1].reflectance(np.full((), cos)), bases[0].reflectance(np.full((), cos)), atol=2e-4)


def test_the_command_writes_layers_and_says_what_they_cost(tmp_path, capsys):
    out, back = tmp_path / "mug.mtlx", tmp_path / "mug.json"
    assert run(["convert", "glossy_plastic", "--to", "layers", "-o", str(out)]) == 0
    assert "difference in soft light" in capsys.readouterr().out
    assert run(["convert", str(out), "-o", str(back)]) == 0
    assert_same(presets.load("glossy_plastic"), Stack.load(back))
    assert run(["convert", "glossy_plastic", "--to", "layers", "-o", str(back)]) == 2
    assert "ends in .mtlx" in capsys.readouterr().err


def test_a_coats_tint_is_lighter_where_no_metal_below_is_bright_enough():
    """MaterialX's own copper: a white metal below a coat of copper's color."""
    inputs = "".join(
        f'<input name="{k}" type="float" value="{v}"/>' for k, v in {"base": 1, "specular": 0, "metalness": 1, "coat": 1, "specular_roughness": 0.25}.items()
    )
    inputs += '<input name="base_color" type="color3" value="1,1,1"/><input name="coat_color" type="color3" value="0.965,0.376,0.258"/>'
    (copper,) = from_mtlx(
        f'<materialx version="1.39" colorspace="lin_rec709"><standard_surface name="s" type="surfaceshader">{inputs}</standard_surface></materialx>'
    )
    converted = copper.to_stack()
    # with the coat's own color 4.5 and 13 %; what is left is how it goes with the angle
    assert converted.report.match.color_difference < 0.1 and converted.report.match.soft_light < 0.08
    assert "lighter" in said(converted, APPROXIMATED) and "coat_color" not in said(converted, "kept")


def test_an_input_without_a_value_is_as_none():
    """Of a leaf, a mix, a scale and the surface; as `value` may also be empty, and an input may lack its type."""
    empty = '<input name="{}" type="{}" value=""/>'
    rough = PLASTIC.replace('name="paint" type="BSDF">', f'name="paint" type="BSDF">{empty.format("roughness", "float")}<input name="weight"/>')
    mix = f'<mix name="m" type="BSDF"><input name="bg" type="BSDF" nodename="paint"/><input name="fg" type="BSDF" nodename="chalk"/>{empty.format("mix", "float")}</mix>'
    scale = f'<multiply name="t" type="BSDF"><input name="in1" type="BSDF" nodename="m"/>{empty.format("in2", "color3")}</multiply>'
    text = document(mix + scale, "t", empty.format("opacity", "float")).replace(PLASTIC, rough)
    (found,), paint = from_mtlx(text), read("", "paint")
    assert found.to_stack().stack == paint.stack and not found.to_stack().report.losses
