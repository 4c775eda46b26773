# SPDX-License-Identifier: GPL-3.0-or-later
"""What the chart of followed textures counts is what a material gets."""

import pytest
from support.coats import CLAY, GLAZE, METAL, MILK, VARNISH, WOOD

from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack
from lamina.study.charts.followed import ANALYTIC, BAKED, PAPER, REFUSED, chosen, textured

_FILM, _BRUSHED = {"film_thickness": 300.0, "film_ior": 1.8}, {"anisotropy": 0.5, "rotation": 0.1}


@pytest.mark.parametrize(
    "layers, base, live, expected",
    [
        ([VARNISH], WOOD, [(0, "tint"), (0, "thickness"), (0, "roughness"), (None, "color")], BAKED),
        ([VARNISH], CLAY, [(None, "color")], BAKED),
        ([VARNISH, GLAZE], METAL, [(1, "ior"), (0, "roughness")], BAKED),
        ([VARNISH], METAL, [(0, "roughness"), (0, "tint"), (None, "roughness")], BAKED),
        ([VARNISH], METAL, [(0, "roughness"), (0, "tint"), (0, "ior"), (None, "roughness")], ANALYTIC),
        ([VARNISH | _BRUSHED], METAL, [], BAKED),
        ([VARNISH | _BRUSHED], METAL, [(0, "roughness"), (0, "tint")], BAKED),
        ([VARNISH | _BRUSHED], METAL, [(0, "roughness"), (0, "tint"), (None, "roughness")], ANALYTIC),
        ([VARNISH | _BRUSHED], METAL, [(0, "anisotropy"), (None, "roughness")], BAKED),
        ([], METAL | _BRUSHED, [], ANALYTIC),
        ([VARNISH | _FILM], METAL, [(0, "roughness")], BAKED),
        ([GLAZE | _FILM], METAL, [(0, "film_thickness")], BAKED),
        ([GLAZE | _FILM], METAL, [(0, "film_thickness"), (None, "roughness")], BAKED),
        ([GLAZE | _FILM], METAL, [(0, "film_ior"), (0, "tint")], BAKED),
        ([GLAZE | _FILM], METAL, [(0, "film_thickness"), (0, "tint"), (None, "roughness")], PAPER),
        ([GLAZE | _FILM], METAL, [(0, "film_thickness"), (0, "film_ior")], PAPER),
        ([VARNISH | _FILM | _BRUSHED], METAL, [], PAPER),
        ([MILK], METAL, [(0, "density"), (0, "thickness")], REFUSED),
    ],
)
def test_what_is_chosen(layers, base, live, expected):
    stack, places = Stack.from_dict({"layers": layers, "base": base}), tuple(Place(*pair) for pair in live)
    assert set(places) <= set(textured(stack))
    assert chosen(stack, places) == expected
    if expected in (ANALYTIC, PAPER):  # what takes no bake
        assert make_lobe_set(stack, "baked", live=places).lobe_set.name == expected
