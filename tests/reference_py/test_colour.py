# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectra to linear Rec.709, and the artist-friendly conductor."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.optics.colour import (
    artist_color,
    artist_index,
    reflectance_to_rgb,
    reflectance_to_xyz,
    resample,
    rgb_weights,
    standard_wavelengths,
    upsampled,
    xyz_to_rgb,
)
from lamina.reference_py.optics.fresnel import fresnel_conductor


@pytest.mark.parametrize("wavelength_nm", [standard_wavelengths(), np.linspace(400.0, 700.0, 16), np.array([550.0])])
def test_white_is_one_on_any_wavelengths(wavelength_nm):
    white = reflectance_to_rgb(np.ones(wavelength_nm.size), wavelength_nm)
    np.testing.assert_allclose(white, 1.0, atol=1e-14)


def test_white_point_and_luminance_weights_are_those_of_rec709():
    # Rec.709 prints the white as x .3127, y .3290 and the luminance weights as .2126, .7152, .0722; the white here
    # is the 5 nm sum, hence the tolerance.
    xyz = reflectance_to_xyz(np.ones(81), standard_wavelengths())
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), [0.3127, 0.3290], atol=1e-4)
    assert xyz[1] == pytest.approx(1.0, abs=1e-14)
    # the middle row of the inverse: Y of each primary
    luminance = np.linalg.inv(xyz_to_rgb(np.eye(3)))[:, 1]
    np.testing.assert_allclose(luminance, [0.2126, 0.7152, 0.0722], atol=2e-4)


def test_long_wavelengths_are_red_and_short_ones_blue():
    wavelength_nm = standard_wavelengths()
    edge = (wavelength_nm > 590.0).astype(float)
    red, blue = reflectance_to_rgb(np.array([edge, wavelength_nm < 490.0]), wavelength_nm)
    assert red.argmax() == 0 and red[0] > 5.0 * abs(red[1:]).max()
    assert blue.argmax() == 2 and blue[2] > 5.0 * abs(blue[:2]).max()


def test_integral_is_linear_and_keeps_leading_axes():
    wavelength_nm = standard_wavelengths()
    spectra = np.random.default_rng(3).random((2, 4, wavelength_nm.size))
    rgb = reflectance_to_rgb(spectra, wavelength_nm)
    assert rgb.shape == (2, 4, 3)
    np.testing.assert_allclose(reflectance_to_rgb(0.3 * spectra[0] + spectra[1], wavelength_nm), 0.3 * rgb[0] + rgb[1])
    np.testing.assert_allclose(xyz_to_rgb(reflectance_to_xyz(spectra, wavelength_nm)), rgb, atol=1e-14)


def test_coarse_wavelengths_agree_with_fine_ones_for_a_smooth_spectrum():
    def smooth(nm):
        return 0.5 + 0.3 * np.sin(nm / 60.0)

    coarse, fine = np.arange(380.0, 781.0, 10.0), np.arange(380.0, 781.0, 1.0)
    np.testing.assert_allclose(smooth(coarse) @ rgb_weights(coarse), smooth(fine) @ rgb_weights(fine), atol=2e-3)


def test_resample_is_linear_between_samples_and_constant_beyond():
    values = resample([400.0, 500.0], [[1.0, 3.0], [0.0, 1.0]], [300.0, 425.0, 900.0])
    np.testing.assert_allclose(values, [[1.0, 1.5, 3.0], [0.0, 0.25, 1.0]])


@pytest.mark.parametrize("wavelength_nm", [[500.0, 400.0], [400.0, 400.0], [], [[400.0, 500.0]]])
def test_bad_wavelengths_are_refused(wavelength_nm):
    with pytest.raises(LaminaError, match="Wavelengths"):
        rgb_weights(wavelength_nm)


def test_spectrum_of_another_length_is_refused():
    with pytest.raises(LaminaError, match="2 values"):
        reflectance_to_rgb(np.ones(3), [400.0, 500.0])
    with pytest.raises(LaminaError, match="2 values"):
        resample([400.0, 500.0], np.ones(3), [450.0])


def test_artist_conductor_round_trip():
    rng = np.random.default_rng(5)
    r, g = rng.uniform(0.02, 0.99, (50, 3)), rng.uniform(0.0, 1.0, (50, 3))
    n, k = artist_index(r, g)
    r_back, g_back = artist_color(n, k)
    np.testing.assert_allclose(r_back, r, rtol=1e-9)
    np.testing.assert_allclose(g_back, g, atol=1e-7)


def test_artist_conductor_has_the_asked_reflectance_and_g_lifts_the_edge():
    r = np.array([0.3, 0.6, 0.95])
    low, high = artist_index(r, 0.2), artist_index(r, 0.9)
    for n, k in (low, high):
        np.testing.assert_allclose(fresnel_conductor(1.0, n, k), r, rtol=1e-12)
    assert np.all(high[0] < low[0])
    cos_75 = np.cos(np.radians(75.0))
    assert np.all(fresnel_conductor(cos_75, *high) > fresnel_conductor(cos_75, *low))


def test_artist_conductor_limits():
    # g = 0 is a dielectric with this reflectance; glass of index 1.5 reflects 4 %
    n, k = artist_index(0.04, 0.0)
    assert n == pytest.approx(1.5) and k == pytest.approx(0.0, abs=1e-7)
    n, k = artist_index(0.0, 0.5)
    assert (n, k) == (1.0, 0.0)
    assert artist_color(1.0, 0.0) == (0.0, 0.0)


def test_upsampled_colors_come_back_and_are_reflectances():
    rgb = np.random.default_rng(1).random((50, 3))
    wavelength_nm, spectra = upsampled(rgb)
    np.testing.assert_allclose(reflectance_to_rgb(spectra, wavelength_nm), rgb, atol=2e-5)
    assert spectra.min() >= 0.0 and spectra.max() <= 1.0 + 1e-5
    np.testing.assert_allclose(upsampled([0.3, 0.3, 0.3])[1], 0.3, atol=1e-5)


def test_the_spectra_of_the_primaries_are_those_of_the_study():
    pytest.importorskip("scipy")
    from lamina.study.make_rgb_spectra import WAVELENGTH_NM, primaries

    wavelength_nm, spectra = upsampled(np.eye(3))
    assert np.array_equal(wavelength_nm, WAVELENGTH_NM)
    np.testing.assert_allclose(spectra, primaries(), atol=1e-5)


@pytest.mark.parametrize(
    "r, g, text",
    [
        (1.0, 0.5, "reflectance"),
        (-0.1, 0.5, "reflectance"),
        (np.nan, 0.5, "reflectance"),
        (0.5, 1.1, "edge tint"),
        (0.5, np.nan, "edge tint"),
    ],
)
def test_artist_index_refuses_impossible_colours(r, g, text):
    with pytest.raises(LaminaError, match=text):
        artist_index(r, g)


@pytest.mark.parametrize("n, k", [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_artist_color_refuses_impossible_indices(n, k):
    with pytest.raises(LaminaError, match="Complex index"):
        artist_color(n, k)
