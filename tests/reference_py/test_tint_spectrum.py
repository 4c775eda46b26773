# SPDX-License-Identifier: GPL-3.0-or-later
"""Tints given as spectra: integrated at the layer's thickness, kept in files, right for thick glazes where a tint in RGB is not."""

import json

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.schema import ILLUMINANTS
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.material.tint_spectrum import spectrum_of
from lamina.reference_py.optics.colour import reflectance_to_rgb, rgb_weights, standard_wavelengths, tint_of_spectrum
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.spectral import spectral_stack
from lamina.reference_py.registry import make_model

NM = np.arange(380.0, 781.0, 10.0)
# dissolved yellow substance: an exponential of the wavelength (Bricaud, Morel and Prieur 1981)
AMBER = np.exp(-0.2 * np.exp(-0.014 * (NM - 440.0)))
UP = spherical(0.0, 0.0)
SPECTRUM = {"wavelengths_nm": NM.tolist(), "transmittance": AMBER.tolist()}
WHITE = {"kind": "lambert", "color": [1.0, 1.0, 1.0]}


def glaze(thickness=5.0, base=WHITE, **more):
    return {"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0, "thickness": thickness, "tint_spectrum": SPECTRUM, **more}], "base": base}


@pytest.mark.parametrize("base", [WHITE, {"kind": "oren_nayar", "color": [0.6, 0.6, 0.6]}, {"kind": "conductor", "metal": "silver", "roughness": 0.2}])
@pytest.mark.parametrize("thickness", [0.5, 5.0])
def test_a_glaze_has_the_color_of_its_spectrum_seen_straight_on(thickness, base):
    spectral = spectral_stack(Stack.from_dict(glaze(thickness, base)), NM)
    truth, found = (make_model("adding", s, nodes=16).albedo(UP) for s in (spectral, Stack.from_dict(glaze(thickness, base))))
    assert found == pytest.approx(truth @ rgb_weights(NM), rel=0.02)
    assert Stack.from_dict(glaze(thickness, base)).unknown_keys() == []


def test_a_thick_glaze_is_right_where_a_tint_in_rgb_is_not():
    view = spherical(np.radians([0.0, 45.0, 75.0]), 0.0)
    as_spectrum = Stack.from_dict(glaze())
    as_rgb = Stack.from_dict(glaze(tint=reflectance_to_rgb(AMBER, NM).tolist()))
    truth = make_model("adding", spectral_stack(as_spectrum, NM), nodes=16).albedo(view) @ rgb_weights(NM)
    spectral, rgb = (np.abs(make_model("adding", s, nodes=16).albedo(view) / truth - 1.0).max(axis=0) for s in (as_spectrum, as_rgb))
    assert np.all(spectral < 0.025) and np.all(rgb > [0.1, 0.05, 0.15])


def test_a_stack_keeps_its_spectrum_and_reads_the_same_again():
    stack = Stack.from_dict({**glaze(), "illuminant": "A"})
    again = Stack.from_json(stack.to_json())
    assert again == stack and again.unknown["illuminant"] == "A" and spectrum_of(again.layers[0])[1] == tuple(AMBER)
    assert json.loads(stack.to_json())["layers"][0]["tint_spectrum"]["transmittance"] == SPECTRUM["transmittance"]


def test_another_thickness_is_integrated_anew_and_another_tint_wins():
    data = Stack.from_dict(glaze(1.0)).to_dict()
    layer = data["layers"][0]
    single = [float(np.float32(v)) for v in layer["tint"]]  # as Blender's sockets keep it
    thicker = Stack.from_dict({**data, "layers": [{**layer, "tint": single, "thickness": 5.0}]})
    assert thicker.layers[0]["tint"] == Stack.from_dict(glaze(5.0)).layers[0]["tint"] != tuple(layer["tint"])
    painted = Stack.from_dict({**data, "layers": [{**layer, "tint": [0.2, 0.3, 0.4]}]})
    assert painted.layers[0]["tint"] == (0.2, 0.3, 0.4) and spectrum_of(painted.layers[0]) is None
    assert painted.unknown_keys() == ["layer 0: tint_spectrum is kept and has no effect, as the layer has a tint of its own; leave tint out"]
    assert painted.to_dict()["layers"][0]["tint_spectrum"]["transmittance"] == SPECTRUM["transmittance"]


def test_a_key_that_meant_nothing_before_still_does():
    old = Stack.from_dict({**glaze(tint=[0.5, 0.5, 0.5]), "schema_version": 4, "illuminant": 7})
    assert old.layers[0]["tint"] == (0.5, 0.5, 0.5) and len(old.unknown_keys()) == 2
    assert Stack.from_dict({"layers": [{"kind": "dielectric", "tint": [1, 1, 1], "tint_spectrum": "blue"}], "base": WHITE}).unknown_keys()


@pytest.mark.parametrize("illuminant", ILLUMINANTS)
def test_white_is_white_under_every_illuminant(illuminant):
    nm = standard_wavelengths()
    assert np.ones(len(nm)) @ rgb_weights(nm, illuminant) == pytest.approx(np.ones(3), abs=1e-12)
    assert tint_of_spectrum((400.0, 700.0), (0.5, 0.5), 3.0, 1.5, 0.8, False, illuminant) == pytest.approx((0.5, 0.5, 0.5), abs=1e-4)


def test_lamp_light_sees_a_yellow_glaze_otherwise():
    lamp, day = (Stack.from_dict({**glaze(), "illuminant": name}).layers[0]["tint"] for name in ("A", "D65"))
    assert np.abs(np.subtract(lamp, day)).max() > 0.005


@pytest.mark.parametrize(
    ("spectrum", "said"),
    [
        ("blue", "two lists of numbers"),
        ({"wavelengths_nm": [400, 500]}, "two lists of numbers"),
        ({"wavelengths_nm": [400, 500], "transmittance": [0.5]}, "as many of both"),
        ({"wavelengths_nm": [400], "transmittance": [0.5]}, "as many of both"),
        ({"wavelengths_nm": [500, 400], "transmittance": [0.5, 0.5]}, "must increase"),
        ({"wavelengths_nm": [400, float("nan")], "transmittance": [0.5, 0.5]}, "must increase"),
        ({"wavelengths_nm": [400, 500], "transmittance": [0.5, 1.5]}, "transmittance is 1.5; choose 0 to 1"),
    ],
)
def test_a_bad_spectrum_is_refused_in_one_line(spectrum, said):
    with pytest.raises(LaminaError, match=f"stack: layer 0: tint_spectrum.*{said}"):
        Stack.from_dict({"layers": [{"kind": "dielectric", "tint_spectrum": spectrum}], "base": WHITE})


def test_an_unknown_illuminant_names_the_choices():
    with pytest.raises(LaminaError, match="unknown illuminant 'F2'; choose D65, A, E"):
        Stack.from_dict({**glaze(), "illuminant": "F2"})
