# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour spaces against OpenColorIO, and CIEDE2000 against the published pairs."""

import numpy as np
import pytest

from lamina.reference_py.optics.colour import ciede2000, is_known, known_spaces, lab_of_linear, srgb_encoded, to_linear_rec709
from lamina.reference_py.optics.colour.spaces import ALIASES

COLORS = np.array([[0.1, 0.6, 0.9], [0.5, 0.5, 0.5], [0.9, 0.02, 0.3], [0.0, 1.0, 0.0], [0.01, 0.03, 0.02]])


def test_spaces_are_those_of_opencolorio():
    """Every name that both know, to 1e-4: OpenColorIO's curves are in single precision."""
    ocio = pytest.importorskip("PyOpenColorIO")
    config = ocio.Config.CreateFromBuiltinConfig("ocio://cg-config-v4.0.0_aces-v2.0_ocio-v2.5")
    found = [name for name in (*known_spaces(), *ALIASES, "srgb_ap1_scene", "g22_ap1_scene", "lin_adobergb", "srgb_p3d65_scene") if config.getColorSpace(name)]
    assert len(found) >= 30
    for name in found:
        processor = config.getProcessor(name, "lin_rec709").getDefaultCPUProcessor()
        theirs = [processor.applyRGB(color.tolist()) for color in COLORS]
        np.testing.assert_allclose(to_linear_rec709(COLORS, name), theirs, atol=1e-4, err_msg=name)


def test_known_values_names_and_raw():
    np.testing.assert_allclose(to_linear_rec709([0.1, 0.6, 0.9], "ACEScg"), [-0.2775, 0.6620, 0.9579], atol=1e-4)
    np.testing.assert_allclose(to_linear_rec709([0.5, 0.5, 0.5], "srgb_texture"), 0.21404, atol=1e-5)
    for name in (*known_spaces(), *ALIASES):
        assert is_known(name), name
        np.testing.assert_allclose(to_linear_rec709(np.ones(3), name), 1.0, atol=1e-9, err_msg=name)
    assert not is_known("my_camera") and not is_known("lin_") and not is_known("lin_xyz")
    np.testing.assert_array_equal(to_linear_rec709(COLORS, "none"), COLORS)
    np.testing.assert_allclose(to_linear_rec709(srgb_encoded(COLORS), "srgb_texture"), COLORS, atol=1e-6)


# L*a*b*, L*a*b*, difference: pairs 1, 4, 7, 9, 10, 13, 16, 25, 31 and 34 of Sharma, Wu and Dalal 2005, table 1.
PUBLISHED = (
    (50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425), (50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0),
    (50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669), (50.0, 2.49, -0.001, 50.0, -2.49, 0.0009, 7.1792), (50.0, 2.49, -0.001, 50.0, -2.49, 0.0010, 7.1792),
    (50.0, -0.001, 2.49, 50.0, 0.0009, -2.49, 4.8045), (50.0, 2.5, 0.0, 50.0, 0.0, -2.5, 4.3065), (60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644),
    (36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146), (2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082),
)  # fmt: skip


def test_ciede2000_is_the_published():
    pairs = np.array(PUBLISHED)
    np.testing.assert_allclose(ciede2000(pairs[:, :3], pairs[:, 3:6]), pairs[:, 6], atol=1e-4)
    np.testing.assert_allclose(ciede2000(pairs[:, 3:6], pairs[:, :3]), pairs[:, 6], atol=1e-4)
    np.testing.assert_allclose(lab_of_linear(np.array([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]])), [[100.0, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-9)
