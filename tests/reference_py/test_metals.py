# SPDX-License-Identifier: GPL-3.0-or-later
"""Metals: published tables, and the RGB index fitted to them."""

import json

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.schema import METALS
from lamina.reference_py.optics.colour import conductor_rgb, load_metal, metal_index, metal_names
from lamina.reference_py.optics.colour.metals import RGB_FILE
from lamina.reference_py.optics.fresnel import fresnel_conductor
from lamina.study.make_metals_rgb import COS_THETA, LARGEST_REFLECTANCE, rgb_entry, rgb_reflectance

RGB_TABLE = json.loads(RGB_FILE.read_text(encoding="utf-8"))["metals"]

# Printed samples: (nm, n, k). Johnson and Christy 1972 and 1974; Rakic 1995; Rakic et al. 1998 (BB); Querry 1985.
SPOTS = {
    "gold": (548.6, 0.43, 2.455),
    "silver": (495.9, 0.05, 3.093),
    "copper": (616.8, 0.30, 3.205),
    "nickel": (549.0, 1.92, 3.61),
    "chromium": (549.0, 3.18, 3.33),
    "iron": (549.0, 2.95, 2.93),
    "titanium": (549.0, 2.54, 3.43),
    "aluminium": (563.57, 1.0728, 6.7839),
    "brass": (550.0, 0.527, 2.765),
    "platinum": (555.18, 2.0984, 3.7451),
    "tungsten": (555.18, 3.517, 2.7637),
}

# Reflectance at normal incidence in linear Rec.709 as renderers' manuals quote it, and the tolerance: Adobe Standard
# Material, "Metal material references" (F0, linear); platinum from the Shader Graph manual, "Metal Reflectance node";
# brass is a number commonly quoted without a source. Only chromium and brass agree as closely as the same measurements
# would. The rest are other films, so their tolerance is what they differ by, rounded up: it tells metals and channels
# apart and catches a wrong white point or color space, no more. Red is limited to 1, as theirs is.
QUOTED_F0 = {
    "brass": ((0.910, 0.778, 0.423), 0.001),
    "chromium": ((0.5496, 0.5561, 0.5531), 0.002),
    "aluminium": ((0.9157, 0.9226, 0.9236), 0.01),
    "nickel": ((0.7014, 0.6382, 0.5593), 0.01),
    "platinum": ((0.672, 0.637, 0.585), 0.01),
    "silver": ((0.9868, 0.9830, 0.9667), 0.015),
    "gold": ((1.0, 0.7099, 0.3148), 0.055),
    "copper": ((1.0, 0.6504, 0.5274), 0.07),
}


def test_names_are_those_the_schema_offers_and_the_table_holds():
    assert metal_names() == METALS == tuple(RGB_TABLE)


@pytest.mark.parametrize("name", METALS)
def test_table_covers_the_visible_and_names_its_source(name):
    metal = load_metal(name)
    assert metal.name == name and metal.label and len(metal.source) > 40
    assert metal.wavelength_nm[0] <= 380.0 and metal.wavelength_nm[-1] >= 780.0
    assert metal.wavelength_nm.shape == metal.n.shape == metal.k.shape
    assert np.all(np.diff(metal.wavelength_nm) > 0.0) and np.all(metal.n > 0.0) and np.all(metal.k > 0.0)


@pytest.mark.parametrize("name", METALS)
def test_published_sample(name):
    wavelength_nm, n, k = SPOTS[name]
    np.testing.assert_allclose(metal_index(name, [wavelength_nm]), [[n], [k]], rtol=1e-12)


@pytest.mark.parametrize("name", QUOTED_F0)
def test_colour_at_normal_incidence_is_near_the_quoted_one(name):
    f0 = rgb_reflectance(name, np.array(1.0))
    quoted, tolerance = QUOTED_F0[name]
    np.testing.assert_allclose(np.minimum(f0, 1.0), quoted, atol=tolerance)
    if name in ("gold", "copper", "brass"):
        assert f0[0] > f0[1] > f0[2]


@pytest.mark.parametrize("name", METALS)
def test_committed_rgb_index_is_what_the_generator_makes(name):
    made, committed = rgb_entry(name), RGB_TABLE[name]
    assert made.keys() == committed.keys()
    for key, value in made.items():
        np.testing.assert_allclose(value, committed[key], rtol=1e-4, atol=2e-6, err_msg=key)


@pytest.mark.parametrize("name", METALS)
def test_rgb_index_is_physical_and_follows_the_spectral_integral(name):
    eta, k = conductor_rgb(name)
    assert eta.shape == k.shape == (3,)
    assert np.all((eta > 0.01) & (eta < 20.0) & (k > 0.0) & (k < 20.0))
    reflectance = fresnel_conductor(COS_THETA[:, None], eta, k)
    assert np.all((reflectance >= 0.0) & (reflectance <= 1.0))
    error = np.abs(reflectance - np.minimum(rgb_reflectance(name, COS_THETA), LARGEST_REFLECTANCE))
    # one index cannot follow a mixture of very different ones at grazing angles: brass has .0053 at 85 degrees
    assert error[:81].max() < 0.005
    assert error.max() < 0.006
    assert RGB_TABLE[name]["rms_error"] < 0.002
    assert RGB_TABLE[name]["max_error"] == pytest.approx(error.max(), abs=2e-6)


def test_only_gold_leaves_rec709():
    assert {name for name in METALS if RGB_TABLE[name]["clipped"] > 0.0} == {"gold"}


def test_unknown_metal_lists_the_choices():
    for call in (conductor_rgb, load_metal, lambda name: metal_index(name, [500.0])):
        with pytest.raises(LaminaError, match="'gld'.*aluminium, brass.*gold"):
            call("gld")


def test_wavelength_outside_the_table_is_refused():
    with pytest.raises(LaminaError, match="'brass' is tabulated from 380 to 780 nm"):
        metal_index("brass", [500.0, 790.0])


def test_callers_cannot_change_the_cached_table():
    eta, _ = conductor_rgb("gold")
    eta[:] = 0.0
    assert np.all(conductor_rgb("gold")[0] > 0.0)
