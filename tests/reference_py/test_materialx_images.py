# SPDX-License-Identifier: GPL-3.0-or-later
"""Images in graphs of MaterialX: factors and offsets, where they lie, and what stands in for them. Right values by hand."""

import numpy as np
import pytest

from lamina.reference_py.exchange.materialx import from_mtlx, load_mtlx
from lamina.reference_py.exchange.materialx_functions import FUNCTIONS
from lamina.reference_py.exchange.report import APPROXIMATED, LOST

SRGB = 'colorspace="srgb_texture"'


def value(name, text, kind="color3", more=""):
    return f'<input name="{name}" type="{kind}" value="{text}" {more}/>'


def link(name, node, kind="color3", more=""):
    return f'<input name="{name}" type="{kind}" nodename="{node}" {more}/>'


def image(name, kind="color3", more="", file="wood.png", node="image"):
    return f'<{node} name="{name}" type="{kind}">{value("file", file, "filename", SRGB if kind.startswith("color") else "")}{more}</{node}>'


def node(tag, name, inputs, kind="color3"):
    return f'<{tag} name="{name}" type="{kind}">{inputs}</{tag}>'


def text(nodes, inputs, surface="open_pbr_surface"):
    return f'<materialx version="1.39" colorspace="lin_rec709">{nodes}<{surface} name="s" type="surfaceshader">{inputs}</{surface}></materialx>'


def read(nodes, inputs, surface="open_pbr_surface"):
    (material,) = from_mtlx(text(nodes, inputs, surface))
    return material


ARITHMETIC = {
    "multiply": (link("in1", "a") + value("in2", "0.5,0.25,1"), (0.5, 0.25, 1.0), (0.0,)),
    "mix": (link("bg", "a") + value("fg", "1,1,1") + value("mix", "0.25", "float"), (0.75,), (0.25,)),
    "invert": (link("in", "a"), (-1.0,), (1.0,)),
    "remap": (link("in", "a") + value("outlow", "0.2", "float") + value("outhigh", "0.6", "float"), (0.4,), (0.2,)),
    "range": (link("in", "a") + value("inhigh", "0.5", "float"), (2.0,), (0.0,)),
    "contrast": (link("in", "a") + value("amount", "0.5", "float"), (0.5,), (0.25,)),
    "colorcorrect": (link("in", "a") + value("gain", "0.5", "float") + value("exposure", "-1", "float"), (0.25,), (0.0,)),
    "clamp": (link("in", "a"), (1.0,), (0.0,)),
}


@pytest.mark.parametrize("tag", ARITHMETIC)
def test_arithmetic_of_an_image_is_a_factor_and_an_offset(tag):
    inputs, scale, offset = ARITHMETIC[tag]
    material = read(image("a") + node(tag, "m", inputs), link("base_color", "m"))
    found = material.images["base_color"]
    assert not material.losses and found.space == "srgb_texture"
    np.testing.assert_allclose(np.broadcast_to(found.scale, 3), np.broadcast_to(scale, 3), atol=1e-8)
    np.testing.assert_allclose(np.broadcast_to(found.offset, 3), np.broadcast_to(offset, 3), atol=1e-8)


def test_what_is_no_factor_is_lost_and_a_factor_of_nothing_is_a_number():
    for tag, inputs in {"power": link("in1", "a") + value("in2", "2", "float"), "clamp": link("in", "a") + value("low", "0.2", "float")}.items():
        (loss,) = read(image("a") + node(tag, "m", inputs), link("base_color", "m")).losses
        assert loss.fate == LOST and "is computed from the image wood.png" in str(loss)
    dark = read(image("a") + node("multiply", "m", link("in1", "a") + value("in2", "0", "float")), link("base_color", "m"))
    assert not dark.images and dark.values["base_color"] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("inputs", (("a", "o"), ("o", "a")))
def test_of_two_images_the_color_stays(inputs):
    """An albedo times an occlusion, in either order, halved."""
    first, second = (link(name, one, "color3" if one == "a" else "float") for name, one in zip(("in1", "in2"), inputs))
    nodes = image("a") + image("o", "float", file="ao.png") + node("multiply", "m", first + second)
    nodes += node("multiply", "h", link("in1", "m") + value("in2", "0.5", "float"))
    material = read(nodes, link("base_color", "h"))
    assert material.images["base_color"].file == "wood.png" and material.images["base_color"].scale == (0.5,)
    (loss,) = material.losses
    assert loss.fate == APPROXIMATED and "the image ao.png multiplies it too, which is left out" in str(loss)


def test_what_an_image_is_not_quite_is_told_once():
    nodes = image("a") + image("o", "float", file="ao.png") + node("multiply", "m", link("in1", "a") + link("in2", "o", "float"))
    nodes += node("mix", "h", link("bg", "m") + link("fg", "m") + value("mix", "0.5", "float"))
    (loss,) = read(nodes, link("base_color", "h")).losses
    assert "the image ao.png multiplies it too" in str(loss)


def test_a_chain_of_arithmetic_takes_a_channel():
    """Green of an image, halved, from 1 down: 1 - g / 2."""
    nodes = image("a", "vector3") + node("separate3", "p", link("in", "a", "vector3"), "multioutput")
    nodes += node("multiply", "h", link("in1", "p", "float", 'output="outg"') + value("in2", "0.5", "float"), "float")
    found = read(nodes + node("invert", "i", link("in", "h", "float"), "float"), link("specular_roughness", "i", "float")).images["specular_roughness"]
    assert (found.channel, found.scale, found.offset) == (1, (-0.5,), (1.0,))
    np.testing.assert_allclose(found.at(np.array([0.4])), 0.8)


def test_nodes_of_gltf_and_usd_have_factors_of_their_own():
    gltf = image("g", "multioutput", value("color", "0.5,0.25,1,0.75", "color4"), node="gltf_colorimage")
    gltf = gltf.replace('type="filename" value', f'type="filename" {SRGB} value')
    found = read(gltf, link("base_color", "g", more='output="outcolor"') + link("alpha", "g", "float", 'output="outa"'), "gltf_pbr").images
    np.testing.assert_allclose(found["base_color"].at(np.array([0.2, 0.4, 0.6])), (0.1, 0.1, 0.6))
    assert found["base_color"].space == "srgb_texture" and (found["alpha"].channel, found["alpha"].scale) == (3, (0.75,))
    factor = image("g", "vector3", value("factor", "1,0.5,0.25", "vector3"), node="gltf_image") + node(
        "separate3", "p", link("in", "g", "vector3"), "multioutput"
    )
    inputs = link("roughness", "p", "float", 'output="outy"') + link("metallic", "p", "float", 'output="outz"')
    found = read(factor, inputs, "gltf_pbr").images
    assert [(found[i].channel, found[i].scale) for i in ("roughness", "metallic")] == [(1, (0.5,)), (2, (0.25,))]
    usd = image("u", "multioutput", value("scale", "0.5,0.5,0.5,1", "vector4") + value("bias", "0.1,0.1,0.1,0", "vector4"), node="UsdUVTexture")
    found = read(usd, link("diffuseColor", "u", more='output="rgb"'), "UsdPreviewSurface").images["diffuseColor"]
    np.testing.assert_allclose(found.at(np.array([0.2, 0.4, 0.6])), (0.2, 0.3, 0.4))
    normals = usd.replace("0.5,0.5,0.5,1", "2,2,2,1").replace("0.1,0.1,0.1,0", "-1,-1,-1,0")
    found = read(normals, link("normal", "u", "vector3", 'output="rgb"'), "UsdPreviewSurface").images["normal"]
    assert found.is_normal and found.is_plain and found.space == ""


def place(found, uv):
    """Where an image lies, as Blender's Mapping node has it: scaled, turned counterclockwise, shifted."""
    x, y = np.array(uv) * found.tiling
    c, s = np.cos(found.turn), np.sin(found.turn)
    return np.array([c * x - s * y, s * x + c * y]) + found.shift


UV = '<texcoord name="t" type="vector2"/>'
PLACES = {
    "multiply": (link("in1", "t", "vector2") + value("in2", "4", "float"), (0.8, 1.2)),
    # (.2, .3) / (.5, .25) = (.4, 1.2), a quarter turn clockwise is (1.2, -.4), less (.1, .2)
    "place2d": (
        link("texcoord", "t", "vector2") + value("scale", "0.5,0.25", "vector2") + value("rotate", "90", "float") + value("offset", "0.1,0.2", "vector2"),
        (1.1, -0.6),
    ),
    # (.2, .3) (2, 1) = (.4, .3), a quarter turn counterclockwise is (-.3, .4), plus (.5, 0)
    "UsdTransform2d": (
        link("in", "t", "vector2") + value("scale", "2,1", "vector2") + value("rotation", "90", "float") + value("translation", "0.5,0", "vector2"),
        (0.2, 0.4),
    ),
}


@pytest.mark.parametrize("tag", PLACES)
def test_where_an_image_lies_is_followed(tag):
    inputs, wanted = PLACES[tag]
    material = read(UV + node(tag, "p", inputs, "vector2") + image("a", more=link("texcoord", "p", "vector2")), link("base_color", "a"))
    assert not material.losses
    np.testing.assert_allclose(place(material.images["base_color"], (0.2, 0.3)), wanted, atol=1e-8)


def test_nodes_that_lay_images_themselves():
    tiled = image("a", more=value("uvtiling", "2,3", "vector2") + value("uvoffset", "0.5,0.25", "vector2"), node="tiledimage")
    np.testing.assert_allclose(place(read(tiled, link("base_color", "a")).images["base_color"], (0.2, 0.3)), (-0.1, 0.65), atol=1e-8)
    # glTF counts v from above: half the size about the upper left corner, (0, 1), is .1, .65
    gltf = image("a", more=value("scale", "0.5,0.5", "vector2"), node="gltf_image")
    np.testing.assert_allclose(place(read(gltf, link("base_color", "a"), "gltf_pbr").images["base_color"], (0.2, 0.3)), (0.1, 0.65), atol=1e-8)
    bent = UV + node("fractal3d", "f", "", "vector2") + image("a", more=link("texcoord", "f", "vector2"))
    material = read(bent, link("base_color", "a"))
    (loss,) = material.losses
    assert loss.fate == APPROXIMATED and "the place of its image is computed by fractal3d: it lies on the plain UVs" in str(loss)
    assert material.images["base_color"].tiling == (1.0, 1.0)


def test_a_normals_strength_stays():
    nodes = image("n", "vector3") + node("normalmap", "m", link("in", "n", "vector3") + value("scale", "0.4", "float"), "vector3")
    found = read(nodes, value("coat_weight", "1", "float") + link("geometry_coat_normal", "m", "vector3")).images["geometry_coat_normal"]
    assert found.is_normal and found.strength == 0.4


CONSTANTS = {
    "swizzle": (value("in", "0.1,0.2,0.3") + value("channels", "bgr", "string"), (0.3, 0.2, 0.1)),
    "contrast": (value("in", "0.6,0.4,0.5") + value("amount", "0.5", "float"), (0.55, 0.45, 0.5)),
    "ifequal": (value("value2", "1", "float") + value("in1", "1,0,0") + value("in2", "0,1,0"), (0.0, 1.0, 0.0)),  # value1 is 0
    "ifgreater": (value("in1", "1,0,0") + value("in2", "0,1,0"), (1.0, 0.0, 0.0)),  # value1 is 1, value2 0
    "switch": (value("in1", "1,0,0") + value("in2", "0,0.5,0") + value("which", "1", "float"), (0.0, 0.5, 0.0)),
    "hsvtorgb": (value("in", "0.3333333333,1,0.5"), (0.0, 0.5, 0.0)),
    "saturate": (value("in", "0.5,0.2,0.1") + value("amount", "0", "float"), (0.2762997,) * 3),  # by ACEScg's luminance, its default
    "geompropvalue": (value("geomprop", "displayColor", "string") + value("default", "0.2,0.3,0.4"), (0.2, 0.3, 0.4)),
}


@pytest.mark.parametrize("tag", CONSTANTS)
def test_constants_go_through_more_nodes(tag):
    inputs, wanted = CONSTANTS[tag]
    material = read(node(tag, "c", inputs), link("base_color", "c"))
    np.testing.assert_allclose(material.values["base_color"], wanted, atol=1e-6)
    assert len(material.losses) == (tag == "geompropvalue"), "what a mesh would say is told"


def test_an_input_takes_channels_as_files_of_138_do():
    nodes = node("constant", "c", value("value", "0.1,0.2,0.3"))
    assert read(nodes, link("coat_weight", "c", "float", 'channels="b"')).values["coat_weight"] == pytest.approx(0.3)


def test_no_function_refuses_what_it_has_by_default():
    for tag, function in FUNCTIONS.items():
        assert np.all(np.isfinite(function(lambda name, default: default))), tag


def test_files_that_are_there_are_found_by_tiles_prefixes_and_windows_paths(tmp_path):
    (tmp_path / "tex").mkdir()
    for name in ("wood.1001.png", "wood.1012.png", "wood.2000.png", "wood.0512.png", "wood.1000.png", "wood.2048.png", "plain.png"):
        (tmp_path / "tex" / name).write_bytes(b"")
    file = tmp_path / "a.mtlx"
    file.write_text(text(image("a", file="tex\\wood.&lt;UDIM&gt;.png") + image("b", "float", file=str(tmp_path / "tex/plain.png")),
                         link("base_color", "a") + link("specular_roughness", "b", "float")).replace("<materialx", '<materialx fileprefix=""'))  # fmt: skip
    (material,) = load_mtlx(file)
    assert material.images["base_color"].files == [str(tmp_path / "tex" / f"wood.{n}.png") for n in (1001, 1012, 2000)], "UDIM tiles are 1001 to 2000"
    assert material.images["specular_roughness"].files == [str(tmp_path / "tex/plain.png")]
    file.write_text(text(image("a", file="gone.png", more=value("default", "0.3,0.2,0.1")) + node("multiply", "m", link("in1", "a") + value("in2", "0.5", "float")),
                         link("base_color", "m")))  # fmt: skip
    (material,) = load_mtlx(file)
    assert material.values["base_color"] == pytest.approx((0.15, 0.1, 0.05)) and not material.images
    assert "there is no such file; the file's own default, 0.15 0.1 0.05, stands in" in str(material.losses[0])


OWN = """<nodedef name="ND_dim" node="dim"><input name="c" type="color3" value="0.1,0.1,0.1"/><input name="by" type="float" value="0.5"/>
<output name="out" type="color3"/></nodedef><nodegraph name="NG_dim" nodedef="ND_dim">
<multiply name="m" type="color3"><input name="in1" type="color3" interfacename="c"/><input name="in2" type="float" interfacename="by"/></multiply>
<output name="out" type="color3" nodename="m"/></nodegraph>
<nodedef name="ND_paint" node="paint"><input name="c" type="color3" value="0.1,0.1,0.1"/><output name="out" type="surfaceshader"/></nodedef>
<nodegraph name="NG_paint"><standard_surface name="q" type="surfaceshader"><input name="base_color" type="color3" interfacename="c"/></standard_surface>
<output name="out" type="surfaceshader" nodename="q"/></nodegraph><implementation name="I" nodedef="ND_paint" nodegraph="NG_paint"/>"""


def test_a_files_own_nodes_are_followed_one_in_another():
    nested = OWN + node("dim", "a", value("c", "0.8,0.4,0.2")) + node("dim", "b", link("c", "a") + value("by", "0.25", "float"))
    assert read(nested, link("base_color", "b")).values["base_color"] == pytest.approx((0.1, 0.05, 0.025))
    assert read(OWN + node("dim", "a", ""), link("base_color", "a")).values["base_color"] == pytest.approx((0.05,) * 3), "defaults of the definition"
    first, second = (node("paint", name, value("c", color), "surfaceshader") for name, color in (("x", "0.8,0.4,0.2"), ("y", "0.1,0.2,0.3")))
    materials = from_mtlx(f'<materialx version="1.39" colorspace="lin_rec709">{OWN}{first}{second}{material("x")}{material("y")}</materialx>')
    assert [m.values["base_color"] for m in materials] == [pytest.approx((0.8, 0.4, 0.2)), pytest.approx((0.1, 0.2, 0.3))]


def material(surface, more=""):
    return f'<surfacematerial name="M_{surface}" type="material">{link("surfaceshader", surface, "surfaceshader")}{more}</surfacematerial>'


def test_graphs_and_surfaces_of_included_files_are_found(tmp_path):
    """The look has the material, another file in a folder the graph with its image, in a color space of its own."""
    (tmp_path / "lib").mkdir()
    graph = '<materialx version="1.39" colorspace="srgb_texture" fileprefix="tex/"><nodegraph name="g">'
    graph += node("constant", "c", value("value", "0.5,0.5,0.5")) + image("i")
    graph += '<output name="c" type="color3" nodename="c"/><output name="i" type="color3" nodename="i"/></nodegraph></materialx>'
    (tmp_path / "lib" / "graph.mtlx").write_text(graph)
    linked = '<input name="base_color" type="color3" nodegraph="g" output="{}"/>'
    look = '<materialx version="1.39" colorspace="lin_rec709" xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="lib/graph.mtlx"/>'
    for output in ("c", "i"):
        inputs = linked.format(output) + value("coat_color", "0.5,0.5,0.5")
        (tmp_path / "look.mtlx").write_text(look + node("open_pbr_surface", "s", inputs, "surfaceshader") + material("s") + "</materialx>")
        (found,) = load_mtlx(tmp_path / "look.mtlx")
        assert found.name == "M_s" and found.values["coat_color"] == (0.5,) * 3
        if output == "c":
            assert found.values["base_color"] == pytest.approx((0.21404,) * 3, abs=1e-5)
        else:
            assert found.images["base_color"].file == str(tmp_path / "lib" / "tex" / "wood.png")
    (tmp_path / "lib" / "surface.mtlx").write_text(text("", value("base_color", "0.3,0.2,0.1")))
    (tmp_path / "look.mtlx").write_text(look.replace("graph", "surface") + material("s") + "</materialx>")
    (found,) = load_mtlx(tmp_path / "look.mtlx")
    assert (found.name, found.values["base_color"]) == ("M_s", (0.3, 0.2, 0.1))


UNIT = 'unit="nanometer"'


def test_a_films_unit_counts_and_a_displacement_is_told():
    for surface, name, own in (("open_pbr_surface", "thin_film_thickness", 0.4), ("standard_surface", "thin_film_thickness", 400.0)):
        for text_, unit in (("400", "nanometer"), ("0.4", "micron"), ("0.0004", "millimeter")):
            assert read("", value(name, text_, "float", f'unit="{unit}"'), surface).values[name] == pytest.approx(own)
        assert read("", value(name, "0.5", "float"), surface).values[name] == 0.5
        of_graph = node("multiply", "c", '<input name="in1" type="float" interfacename="t"/>' + value("in2", "2", "float"), "float")
        graph = f'<nodegraph name="g">{value("t", "200", "float", UNIT)}{of_graph}<output name="out" type="float" nodename="c"/></nodegraph>'
        assert read(graph, f'<input name="{name}" type="float" nodegraph="g" output="out"/>', surface).values[name] == pytest.approx(own)
    moved = node("displacement", "d", value("displacement", "0.1", "float"), "displacementshader")
    moved = f"{material('s', link('displacementshader', 'd', 'displacementshader'))}{moved}"
    (found,) = from_mtlx(text("", value("base_color", "0.3,0.2,0.1")).replace("</materialx>", f"{moved}</materialx>"))
    assert [str(loss) for loss in found.losses] == ["lost: displacementshader linked: a stack has no place for it"]


def handed(name, kind="vector2", to=None):
    return f'<input name="{to or name}" type="{kind}" interfacename="{name}"/>'


def test_an_input_without_a_value_has_its_default():
    """Uv where an image is placed, also through place2d; nothing where it is the surface's own normal."""
    moved = UV.replace("texcoord", "place2d").replace("/>", f">{handed('tc', to='texcoord')}{value('scale', '0.5,0.5', 'vector2')}</place2d>")
    graph = '<nodegraph name="g"><input name="tc" type="vector2" defaultgeomprop="UV0"/>{}<output name="out" type="color3" nodename="a"/></nodegraph>'
    for nodes, tiling in ((image("a", more=handed("tc", to="texcoord")), 1.0), (moved + image("a", more=link("texcoord", "t", "vector2")), 2.0)):
        found = read(graph.format(nodes), '<input name="base_color" type="color3" nodegraph="g" output="out"/>')
        assert not found.losses and found.images["base_color"].tiling == (tiling, tiling)
    for name, kind in (("texcoord", "vector2"), ("default", "color3")):
        assert read(image("a", more=value(name, "", kind)), link("base_color", "a")).images["base_color"].tiling == (1.0, 1.0)
    normals = image("n", "vector3") + node("normalmap", "m", link("in", "n", "vector3") + '<input name="scale" type="float"/>', "vector3")
    assert read(normals, link("geometry_normal", "m", "vector3")).images["geometry_normal"].strength == 1.0
    paint = OWN.replace('value="0.1,0.1,0.1"/><output name="out" type="surf', 'value="0.1,0.1,0.1"/><input name="normal" type="vector3" defaultgeomprop="Nworld"/><output name="out" type="surf')  # fmt: skip
    paint = paint.replace('interfacename="c"/></standard', f'interfacename="c"/>{handed("normal", "vector3")}</standard')
    assert paint.count('"normal"') == 3
    (found,) = from_mtlx(f'<materialx version="1.39">{paint}{node("paint", "x", "", "surfaceshader")}{material("x")}</materialx>')
    assert not found.losses and found.values["base_color"] == pytest.approx((0.1,) * 3)


@pytest.mark.parametrize("wide", (False, True))
def test_a_channel_of_a_missing_image_has_that_of_its_default(tmp_path, wide):
    usd = image("u", "multioutput", value("fallback", "0.2,0.3,0.4,1", "vector4"), node="UsdUVTexture")
    gltf = image("u", "multioutput", value("default", "0.5,0.25,1,0.75", "color4"), node="gltf_colorimage")
    split = image("a", more=value("default", "0.1,0.5,0.9")) + node("separate3", "u", link("in", "a"), "multioutput")
    half = node("multiply", "h", link("in1", "u", more='output="rgb"') + value("in2", "0.5,0.5,0.25"))
    rows = (
        (usd, link("roughness", "u", "float", 'output="g"'), "UsdPreviewSurface", "roughness", 0.3),
        (gltf, link("alpha", "u", "float", 'output="outa"'), "gltf_pbr", "alpha", 0.75),
        (split, link("specular_roughness", "u", "float", 'output="outg"'), "open_pbr_surface", "specular_roughness", 0.5),
    )
    for nodes, inputs, surface, name, wanted in (
        ((usd + half, link("diffuseColor", "h"), "UsdPreviewSurface", "diffuseColor", (0.1, 0.15, 0.1)),) if wide else rows
    ):
        (tmp_path / "a.mtlx").write_text(text(nodes, inputs, surface))
        assert load_mtlx(tmp_path / "a.mtlx")[0].values[name] == pytest.approx(wanted)


MASKS = {
    "channel": image("v", "vector3") + node("separate3", "p", link("in", "v", "vector3"), "multioutput"),
    "float": image("p", "float"),
}


@pytest.mark.parametrize("mask", MASKS)
def test_a_mask_mixes_colors(mask):
    """From .8 .1 .3 to .1 .2 .8, at a half .45 .15 .55; a half of that; its green."""
    out = 'output="outx"' if mask == "channel" else ""
    mixed = MASKS[mask] + node("mix", "m", value("bg", "0.8,0.1,0.3") + value("fg", "0.1,0.2,0.8") + link("mix", "p", "float", out))
    darker = node("multiply", "h", link("in1", "m") + value("in2", "0.5", "float"))
    green = node("separate3", "q", link("in", "m"), "multioutput")
    assert read(mixed, link("base_color", "m")).images["base_color"].at(np.array([0.5])) == pytest.approx((0.45, 0.15, 0.55))
    found = read(mixed + darker, link("base_color", "h")).images["base_color"]
    assert found.at(np.array([0.5])) == pytest.approx((0.225, 0.075, 0.275)) and found.channel == (0 if mask == "channel" else None)
    found = read(mixed + green, link("specular_roughness", "q", "float", 'output="outg"')).images["specular_roughness"]
    assert (found.scale, found.offset, found.channel) == ((0.1,), (0.1,), 0 if mask == "channel" else None)


WIDE = {
    "usd": (image("a", "multioutput", node="UsdUVTexture"), "color3", 'output="rgb"', "0.5,0.25,1"),
    "gltf": (image("a", "multioutput", node="gltf_colorimage"), "color3", 'output="outcolor"', "0.5,0.25,1"),
    "color4": (image("a", "color4"), "color4", "", "0.5,0.25,1,1"),
}


@pytest.mark.parametrize("kind", WIDE)
def test_images_of_four_channels_take_colors(kind):
    nodes, width, out, factor = WIDE[kind]
    for tag, names, wanted in (("multiply", ("in1", "in2"), (0.1, 0.1, 0.6)), ("add", ("in1", "in2"), (0.7, 0.65, 1.6))):
        found = read(nodes + node(tag, "m", link(names[0], "a", width, out) + value(names[1], factor, width), width), link("base_color", "m"))
        assert not found.losses
        np.testing.assert_allclose(found.images["base_color"].at(np.array([0.2, 0.4, 0.6])), wanted)


def test_an_image_of_two_channels_takes_two_numbers():
    nodes = image("a", "vector2") + node("multiply", "m", link("in1", "a", "vector2") + value("in2", "0.5,0.25", "vector2"), "vector2")
    nodes += node("extract", "e", link("in", "m", "vector2") + value("index", "1", "integer"), "float")
    found = read(nodes, link("specular_roughness", "e", "float")).images["specular_roughness"]
    assert (found.channel, found.scale) == (1, (0.25,))


def overloaded(kind):
    return (
        f'<nodedef name="ND_{kind}" node="half"><input name="in" type="{kind}"/><output name="out" type="{kind}"/></nodedef>'
        f'<nodegraph name="NG_{kind}" nodedef="ND_{kind}">{node("multiply", "m", handed("in", kind, "in1") + value("in2", "0.5", "float"), kind)}'
        f'<output name="out" type="{kind}" nodename="m"/></nodegraph>'
    )


@pytest.mark.parametrize("kinds", (("float", "color3"), ("vector3", "color3")))
def test_of_several_definitions_the_one_of_its_type_or_name_is_taken(kinds):
    definitions = "".join(map(overloaded, kinds))
    half = node("half", "h", value("in", "0.8,0.4,0.2"))
    for one in (half, half.replace("<half ", '<half nodedef="ND_color3" ')):
        assert read(definitions + one, link("base_color", "h")).values["base_color"] == pytest.approx((0.4, 0.2, 0.1))
    named = half.replace("<half ", '<half nodedef="ND_float" ')
    assert read(overloaded("color3") + overloaded("float") + named, link("base_color", "h")).values["base_color"] == pytest.approx((0.4,) * 3)


TEXTURE = """<nodedef name="ND_tex" node="tex"><input name="file" type="filename" value="wood.png"/><output name="out" type="color3"/></nodedef>
<nodegraph name="NG_tex" nodedef="ND_tex">{}<image name="i" type="color3"><input name="file" type="filename" interfacename="file"/></image>
{}<output name="out" type="color3" nodename="{}"/></nodegraph>"""


def test_a_definition_of_a_library_finds_the_images_of_who_uses_it(tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "defs.mtlx").write_text(f'<materialx version="1.39">{TEXTURE.format("", "", "i")}</materialx>')
    for given, wanted in ((value("file", "tex/a.png", "filename"), "tex/a.png"), ("", "lib/wood.png")):
        used = text('<xi:include href="lib/defs.mtlx"/>' + node("tex", "q", given), link("base_color", "q"))
        (tmp_path / "x.mtlx").write_text(used.replace("<materialx", '<materialx xmlns:xi="http://www.w3.org/2001/XInclude"'))
        assert load_mtlx(tmp_path / "x.mtlx")[0].images["base_color"].file == str(tmp_path / wanted)


def test_circles_end():
    inner = node("tex", "n", handed("file", "filename"))
    own = TEXTURE.format(inner, node("mix", "m", link("bg", "i") + link("fg", "n") + value("mix", "0.5", "float")), "m")
    linked = '<input name="base_color" type="color3" nodegraph="g" output="out"/>'
    circle = '<nodegraph name="g"><output name="out" type="color3" nodename="g"/></nodegraph>'
    for nodes, inputs in ((own + node("tex", "q", ""), link("base_color", "q")), (circle, linked)):
        (loss,) = (loss for loss in read(nodes, inputs).losses if loss.fate == LOST)
        assert "its graph is too large, or runs in a circle" in str(loss)


def test_an_image_that_is_read_often_is_no_circle():
    given = {"scale": ("vector2", "2,2"), "rotate": ("float", "0"), "offset": ("vector2", "0,0"), "pivot": ("vector2", "0,0")}
    nodes = "".join(f'<input name="{name}" type="{kind}" value="{text_}"/>' for name, (kind, text_) in given.items()) + UV
    nodes += node("place2d", "p", link("texcoord", "t", "vector2") + "".join(handed(name, kind) for name, (kind, _) in given.items()), "vector2")
    nodes += image("a", more=link("texcoord", "p", "vector2")) + node("multiply", "z0", link("in1", "a") + value("in2", "0.5", "float"))
    nodes += "".join(node("mix", f"z{i}", link("fg", f"z{i - 1}") + link("bg", "a") + value("mix", "0.5", "float")) for i in range(1, 6))
    graph = f'<nodegraph name="g">{nodes}<output name="out" type="color3" nodename="z5"/></nodegraph>'
    found = read(graph, '<input name="base_color" type="color3" nodegraph="g" output="out"/>')
    assert not found.losses and found.images["base_color"].tiling == (0.5, 0.5)
    assert found.images["base_color"].scale == pytest.approx((1.0 - 0.5**6,))
