# SPDX-License-Identifier: GPL-3.0-or-later
"""MaterialX as it comes from the world: color spaces, surfaces, graphs, and reports that do not mislead."""

import numpy as np
import pytest

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.appearance import appearance, dielectric_albedo
from lamina.reference_py.exchange.matching import mean
from lamina.reference_py.exchange.materialx import from_mtlx, load_mtlx, to_mtlx
from lamina.reference_py.exchange.materialx_image import Image
from lamina.reference_py.exchange.openpbr import from_openpbr, to_surface
from lamina.reference_py.exchange.principled import from_principled
from lamina.reference_py.exchange.report import APPROXIMATED, KEPT, LOST
from lamina.reference_py.exchange.surfaces import OPENPBR, SURFACES
from lamina.reference_py.material.stack import Stack


def document(inputs="", node="open_pbr_surface", space="lin_rec709", more=""):
    material = '<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    root = f'<materialx version="1.39" colorspace="{space}" fileprefix="images/">'
    return f'{root}{more}<{node} name="s" type="surfaceshader">{inputs}</{node}>{material}</materialx>'


def number(name, value, kind="float", more=""):
    return f'<input name="{name}" type="{kind}" value="{value}" {more}/>'


def color(name, value, more=""):
    return number(name, value, "color3", more)


def read(*args, **options):
    (material,) = from_mtlx(document(*args, **options))
    return material


def lines(converted, fate):
    return {loss.parameter: str(loss) for loss in converted.report.of(fate)}


def test_a_color_has_the_space_of_the_nearest_element():
    own = color("base_color", "0.5, 0.5, 0.5", 'colorspace="srgb_texture"')
    assert read(own).values["base_color"] == pytest.approx((0.21404,) * 3, abs=1e-5)
    assert read(color("base_color", "0.5,0.5,0.5"), space="srgb_texture").values["base_color"] == pytest.approx((0.21404,) * 3, abs=1e-5)
    assert read(color("base_color", "0.5,0.5,0.5", 'colorspace="lin_rec709"'), space="srgb_texture").values["base_color"] == (0.5,) * 3
    assert read(number("coat_weight", 0.5), space="srgb_texture").values["coat_weight"] == 0.5, "no color"


def test_a_color_outside_the_gamut_is_limited_and_an_unknown_space_is_named():
    material = read(color("base_color", "0.1, 0.6, 0.9"), space="acescg")
    assert material.values["base_color"] == pytest.approx((0.0, 0.6620, 0.9579), abs=1e-4)
    (loss,) = material.losses
    assert loss.fate == APPROXIMATED and "base_color -0.2775 0.662 0.9579: outside Rec.709" in str(loss)
    (loss,) = read(color("base_color", "0.1, 0.6, 0.9"), space="my_camera").losses
    assert "color space my_camera: unknown" in str(loss) and "acescg" in str(loss)


GRAPH = """<nodegraph name="g"><input name="given" type="color3" value="0.5,0.25,1"/>
<constant name="c" type="color3"><input name="value" type="color3" interfacename="given"/></constant>
<multiply name="m" type="color3"><input name="in1" type="color3" nodename="c"/><input name="in2" type="float" value="0.5"/></multiply>
<mix name="x" type="color3"><input name="bg" type="color3" nodename="m"/><input name="fg" type="color3" value="1,1,1"/><input name="mix" type="float" value="0.2"/></mix>
<convert name="v" type="color3"><input name="in" type="float" value="0.3"/></convert>
<image name="i" type="color3"><input name="file" type="filename" value="wood.png" colorspace="srgb_texture"/></image>
<image name="n" type="vector3"><input name="file" type="filename" value="n.png"/></image>
<normalmap name="nm" type="vector3"><input name="in" type="vector3" nodename="n"/></normalmap>
<separate3 name="s3" type="multioutput"><input name="in" type="color3" nodename="i"/></separate3>
<fractal3d name="f" type="color3"/><dot name="loop" type="color3"><input name="in" type="color3" nodename="loop"/></dot>
<output name="out" type="color3" nodename="x"/><output name="value" type="color3" nodename="v"/><output name="image" type="color3" nodename="i"/>
<output name="noise" type="color3" nodename="f"/><output name="circle" type="color3" nodename="loop"/><output name="normal" type="vector3" nodename="nm"/>
<output name="green" type="float" nodename="s3" output="outg"/></nodegraph>"""


def linked(name, output, kind="color3"):
    return f'<input name="{name}" type="{kind}" nodegraph="g" output="{output}"/>'


def test_constants_are_followed_and_images_are_linked():
    assert read(linked("base_color", "out"), more=GRAPH).values["base_color"] == pytest.approx((0.4, 0.3, 0.6))
    assert read(linked("base_color", "value"), more=GRAPH).values["base_color"] == pytest.approx((0.3,) * 3)
    material = read(linked("base_color", "image") + linked("geometry_normal", "normal", "vector3") + linked("coat_roughness", "green", "float"), more=GRAPH)
    assert material.images == {
        "base_color": Image("images/wood.png", "srgb_texture"), "geometry_normal": Image("images/n.png", "", True),
        "coat_roughness": Image("images/wood.png", "srgb_texture", channel=1),
    }  # fmt: skip
    for output, why in (("noise", "is computed by fractal3d"), ("circle", "runs in a circle"), ("none", "not in the file")):
        (loss,) = read(linked("base_color", output), more=GRAPH).losses
        assert loss.fate == LOST and why in str(loss) and "0.8 0.8 0.8, stands in" in str(loss)
    told = lines(material.to_stack(frozenset(material.images)), LOST)
    assert "image images/wood.png: 0.8 0.8 0.8 stands in" in told["base_color"]


@pytest.mark.parametrize("node", SURFACES)
def test_every_surface_at_its_defaults_keeps_its_light_and_says_nothing(node):
    converted = read(node=node).to_stack()
    assert not [loss for loss in converted.report.losses if loss.parameter != "base color"]
    match = converted.report.match
    assert match.soft_light < 0.01 and match.color_difference < 0.1 and match.lost_light == 0.0


def test_surfaces_mean_the_same_by_their_own_names():
    """A red plastic of index 1.5 and roughness .25, in the words of all five."""
    red = "0.6, 0.1, 0.05"
    written = {
        "open_pbr_surface": color("base_color", red) + number("specular_roughness", 0.25),
        "standard_surface": number("base", 1) + color("base_color", red) + number("specular_roughness", 0.25),
        "gltf_pbr": color("base_color", red) + number("metallic", 0) + number("roughness", 0.25),
        "UsdPreviewSurface": color("diffuseColor", red) + number("roughness", 0.25),
        "disney_principled": color("baseColor", red) + number("roughness", 0.25),
    }
    stacks = [read(inputs, node=node).to_stack().stack for node, inputs in written.items()]
    for stack in stacks:
        assert stack.layers[0]["roughness"] == pytest.approx(0.25) and stack.layers[0]["ior"] == pytest.approx(1.5, abs=0.02)
        np.testing.assert_allclose(stack.base["color"], stacks[0].base["color"], atol=0.005)


def test_a_metals_coat_stays_and_tints_once():
    inputs = number("metalness", 1) + color("base_color", "0.7,0.7,0.7") + number("coat", 1) + color("coat_color", "0.9,0.6,0.5")
    converted = read(inputs, node="standard_surface").to_stack()
    (coat,) = converted.stack.layers
    np.testing.assert_allclose(np.power(coat["tint"], 2.0 * coat["thickness"]), (0.9, 0.6, 0.5), atol=1e-6)
    metal = 0.75  # the mean over views: its edge rises
    np.testing.assert_allclose(converted.report.match.mean, 0.09 + 0.91 * metal * np.array([0.9, 0.6, 0.5]), atol=0.02)


def test_what_is_lost_counts_in_the_number():
    glass = read(number("transmission_weight", 1)).to_stack()
    assert max(glass.stack.base["color"]) == 0.0 and glass.report.match.lost_light > 0.9 and glass.report.match.soft_light > 0.9
    assert "92.0 % of its light" in lines(glass, LOST)["transmission_weight"]
    lamp = read(number("emission_luminance", 4) + color("emission_color", "1,0.5,0.25")).to_stack()
    assert lamp.report.match.lost_light == pytest.approx(7.0 / (7.0 + 3.0 * 0.816), abs=0.01)
    velvet = read(number("fuzz_weight", 1) + color("base_color", "0.02,0.02,0.02")).to_stack()
    assert velvet.report.match.lost_light > 0.3 and "fuzz_weight" in lines(velvet, LOST)
    for values in ({"Transmission Weight": 1.0}, {"Alpha": 0.1}, {"Emission Strength": 20.0}):
        assert from_principled(values).report.match.soft_light > 0.8, values


def test_subsurface_is_a_medium_without_end_of_its_color():
    """As bright as a diffuse base of that color, which is how such a surface is seen."""
    wanted = from_openpbr({"base_color": (0.1, 0.03, 0.02)})
    converted = read(number("subsurface_weight", 1) + color("subsurface_color", "0.1,0.03,0.02") + number("subsurface_scatter_anisotropy", 0.5)).to_stack()
    body = converted.stack.layers[0]
    assert body["scatter_color"] == converted.stack.base["color"] and body["scatter_g"] == 0.5 and body["density"] >= 40.0
    assert np.max(np.abs(converted.report.match.mean - wanted.report.match.mean)) < 1e-4
    assert "medium without end" in lines(converted, APPROXIMATED)["subsurface_weight"] and "subsurface_color" not in lines(converted, LOST)


def test_where_nothing_is_left_it_is_an_error():
    gone = number("specular_ior", 1) + number("transmission_weight", 1)
    with pytest.raises(LaminaError, match="M: nothing that is seen would be left: all light is of transmission_weight"):
        read(gone).to_stack()
    with pytest.raises(LaminaError, match="all light is of geometry_opacity"):
        read(number("geometry_opacity", 0)).to_stack()
    bubble = read(gone + number("thin_film_weight", 1)).to_stack()
    assert "film_thickness" in bubble.stack.layers[0].values, "a film is seen"


def test_values_beyond_their_range_are_limited_and_said():
    metal = number("base_metalness", 1) + color("specular_color", "0.987, 1.013, 0.997")
    assert "limited to 0.987 1 0.997" in str(read(metal).losses[0])
    strong = read(number("specular_weight", 2)).to_stack()
    assert strong.stack.layers[0]["ior"] == pytest.approx((1 + 0.08**0.5) / (1 - 0.08**0.5)) and "specular_weight" in lines(strong, APPROXIMATED)
    film = number("thin_film_weight", 1) + number("thin_film_thickness", 3)
    thick = read(film).to_stack()
    assert "0 to 2000 nm; it is 2000" in lines(thick, APPROXIMATED)["thin_film_thickness"]
    on_nothing = read(film.replace("3", "0.4") + number("specular_ior", 1)).to_stack()
    assert on_nothing.stack.layers[0]["film_thickness"] == pytest.approx(400.0) and "thin_film_thickness" in lines(on_nothing, KEPT)
    none = read(number("specular_ior", 0)).to_stack()
    assert lines(none, APPROXIMATED)["specular_ior"] == "approximated: specular_ior 0: no medium has it; choose 1 to 4; it counts as 1"
    assert none.stack.base["color"] == pytest.approx((0.8,) * 3, abs=1e-3)
    with pytest.raises(LaminaError, match="coat_roughness is -0.1; choose one number from 0 to 1"):
        read(number("coat_roughness", -0.1))


def test_the_files_albedo_is_that_of_its_layers():
    """Over a black body only the coat is seen; a white one below layers that scale gives all back, and so does a white metal."""
    rules = SURFACES["standard_surface"].rules
    black = OPENPBR | {"base_color": (0.0,) * 3, "specular_weight": 0.0, "coat_weight": 1.0, "coat_ior": 1.5}
    np.testing.assert_allclose(appearance(black, rules).solid, dielectric_albedo(1.5, 0.0) * np.ones(3), atol=1e-12)
    white = black | {"base_color": (1.0,) * 3, "specular_weight": 1.0, "specular_roughness": 0.7}
    np.testing.assert_allclose(appearance(white, rules).solid, 1.0, atol=1e-9)
    metal = OPENPBR | {"base_color": (1.0,) * 3, "base_metalness": 1.0, "specular_roughness": 1.0}
    np.testing.assert_allclose(mean(appearance(metal, rules).solid), 1.0, atol=2e-3)


def test_included_files_are_read_from_the_folder_alone(tmp_path):
    (tmp_path / "a.mtlx").write_text(document(color("base_color", "0.2,0.3,0.4")))
    look = '<materialx version="1.39" xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="{}"/></materialx>'
    (tmp_path / "look.mtlx").write_text(look.format("a.mtlx"))
    assert load_mtlx(tmp_path / "look.mtlx")[0].values["base_color"] == pytest.approx((0.2, 0.3, 0.4))
    (tmp_path / "look.mtlx").write_text(look.format("../../etc/x.mtlx"))
    with pytest.raises(LaminaError, match="outside its folder"):
        load_mtlx(tmp_path / "look.mtlx")
    (tmp_path / "look.mtlx").write_text(look.format("look.mtlx"))
    with pytest.raises(LaminaError, match="no surface"):
        load_mtlx(tmp_path / "look.mtlx")


@pytest.mark.parametrize("name", ("open_pbr_surface", "standard_surface", "gltf_pbr"))
def test_what_is_written_comes_back(name):
    """A clear coat over a gloss over paint, and a lacquered metal: index, roughness and color."""
    clear = {"kind": "dielectric", "ior": 1.5, "roughness": 0.1}
    paint = Stack.from_dict({"layers": [clear, {**clear, "ior": 1.8, "roughness": 0.3}], "base": {"kind": "lambert", "color": [0.6, 0.2, 0.1]}})
    metal = {"kind": "conductor", "reflectance": [0.9, 0.7, 0.4], "edge_color": [0.9, 0.8, 0.6], "roughness": 0.3, "anisotropy": 0.5}
    for stack in (paint, Stack.from_dict({"layers": [clear], "base": metal})):
        written = to_surface(SURFACES[name], stack)
        assert written.report.match.color_difference < 0.5
        (material,) = from_mtlx(to_mtlx(written.values, "x", name))
        assert not material.losses
        back = material.to_stack().stack
        for old, new in zip(stack.layers, back.layers, strict=True):
            assert new["ior"] == pytest.approx(old["ior"], abs=1e-4) and new["roughness"] == pytest.approx(old["roughness"], abs=1e-4)
        key = "color" if "color" in stack.base else "reflectance"
        # measured: 4e-5; of a metal .0117, as its edge color below the coat goes with the color that is solved; without one (glTF) .0199
        most = 0.001 if key == "color" else 0.025 if name == "gltf_pbr" else 0.013
        np.testing.assert_allclose(back.base[key], stack.base[key], atol=most)
        if key == "reflectance":
            assert back.base["anisotropy"] == pytest.approx(0.5, abs=1e-3) and back.base["roughness"] == pytest.approx(0.3, abs=1e-3)


def test_the_command_takes_any_material_of_a_file(tmp_path, capsys):
    second = '<gltf_pbr name="t" type="surfaceshader"/><surfacematerial name="N" type="material">'
    second += '<input name="surfaceshader" type="surfaceshader" nodename="t"/></surfacematerial></materialx>'
    file, out = tmp_path / "two.mtlx", tmp_path / "out.json"
    file.write_text(document().replace("</materialx>", second))
    assert run(["convert", str(file), "-o", str(out)]) == 0 and Stack.load(out).base.kind == "lambert"
    assert run(["convert", str(file), "--material", "N", "-o", str(out)]) == 0 and Stack.load(out).base.kind == "conductor"
    capsys.readouterr()
    assert run(["convert", str(file), "--material", "X", "-o", str(out)]) == 2
    assert "has M, N" in capsys.readouterr().err
