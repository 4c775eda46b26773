# SPDX-License-Identifier: GPL-3.0-or-later
"""A `mix` of two surfaces of a MaterialX file: as layers with coverage where that is exactly the mixture, else refused in one line."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.materialx import from_mtlx
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model

PLASTIC = '<standard_surface name="{0}" type="surfaceshader"><input name="base_color" type="color3" value="{1}"/><input name="specular_roughness" type="float" value="{2}"/></standard_surface>'
METAL = '<gltf_pbr name="{0}" type="surfaceshader"><input name="metallic" type="float" value="1"/><input name="base_color" type="color3" value=".9,.6,.3"/></gltf_pbr>'
COATED = PLASTIC.replace("</standard_surface>", '<input name="coat" type="float" value="1"/></standard_surface>')
VIEWS = spherical(np.radians([0.0, 60.0]), 0.0)


def mixed(first: str, second: str, mix: str = 'value="0.25"', more: str = ""):
    text = f'<mix name="m" type="surfaceshader"><input name="bg" type="surfaceshader" nodename="a"/><input name="fg" type="surfaceshader" nodename="b"/><input name="mix" type="float" {mix}/></mix>'
    both = f"{first.format('a', '.2,.4,.6', '0.3')}{second.format('b', '.7,.1,.1', '0.3')}"
    material = '<surfacematerial name="Both" type="material"><input name="surfaceshader" type="surfaceshader" nodename="m"/></surfacematerial>'
    return from_mtlx(f'<materialx version="1.39" colorspace="lin_rec709">{more}{both}{text}{material}</materialx>')[0]


def albedo(stack):
    return make_model("adding", stack).albedo(VIEWS)


@pytest.mark.parametrize(("first", "second"), [(PLASTIC, METAL), (METAL, PLASTIC), (PLASTIC, PLASTIC)])
def test_a_mix_is_the_mixture_of_both(first, second):
    """Also of two coats that are alike over unlike bases."""
    material = mixed(first, second)
    one, other = (albedo(part.to_stack().stack) for part in (material.first, material.second))
    found = material.to_stack()
    assert found.stack.name == "Both" and albedo(found.stack) == pytest.approx(0.75 * one + 0.25 * other, rel=2e-3)
    assert found.report.match.soft_light < 0.05


GRAPHS = """<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value=".2,.4,.6"/></oren_nayar_diffuse_bsdf>
<dielectric_bsdf name="gloss" type="BSDF"/><layer name="l" type="BSDF"><input name="top" type="BSDF" nodename="gloss"/><input name="base" type="BSDF" nodename="paint"/></layer>
<surface name="{0}" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="paint"/></surface>"""


def test_graphs_of_layers_are_mixed_as_their_bsdfs_are():
    """A coat on a share of the same paint is its coverage."""
    material = mixed(GRAPHS, '<surface name="b" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="l"/></surface>')
    (layer,) = material.to_stack().stack.layers
    assert layer.kind == "dielectric" and layer["coverage"] == pytest.approx(0.25)


def test_what_no_stack_has_is_refused_in_one_line():
    other = COATED.replace("{2}", "0.7")
    with pytest.raises(LaminaError, match="mix of two surfaces of unlike layers") as caught:
        mixed(PLASTIC, other).to_stack()
    assert "\n" not in str(caught.value)


def test_an_image_of_the_share_is_lost_and_said():
    image = '<image name="where" type="float"><input name="file" type="filename" value="where.png"/></image>'
    material = mixed(PLASTIC, METAL, 'nodename="where"', image)
    assert material.share == 0.5 and any(loss.parameter == "mix" and "even mix" in loss.how for loss in material.to_stack().report.losses)


BENT = """<fractal3d name="f" type="vector2"/><image name="where" type="float"><input name="file" type="filename" value="where.png"/>
<input name="texcoord" type="vector2" nodename="f"/></image>"""


def test_a_place_that_is_not_followed_and_a_displacement_are_said():
    material = mixed(PLASTIC, METAL, 'nodename="where"', BENT)
    assert any("fractal3d: it lies on the plain UVs" in str(loss) for loss in material.losses)
    moved = '<displacement name="d" type="displacementshader"/>'
    linked = '<input name="displacementshader" type="displacementshader" nodename="d"/>'
    text = f'{PLASTIC.format("p", ".2,.4,.6", "0.3")}{METAL.format("q")}{moved}<mix name="m" type="surfaceshader"><input name="bg" type="surfaceshader" nodename="p"/>'
    text += '<input name="fg" type="surfaceshader" nodename="q"/></mix><surfacematerial name="M" type="material">'
    text += f'<input name="surfaceshader" type="surfaceshader" nodename="m"/>{linked}</surfacematerial>'
    (found,) = from_mtlx(f'<materialx version="1.39">{text}</materialx>')
    assert [str(loss) for loss in found.losses] == ["lost: displacementshader linked: a stack has no place for it"]


def test_a_mix_of_what_is_not_known_is_not_read():
    with pytest.raises(LaminaError, match="none of the surfaces"):
        mixed(PLASTIC, '<volume name="b" type="surfaceshader"/>')
