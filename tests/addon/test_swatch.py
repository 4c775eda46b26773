# SPDX-License-Identifier: GPL-3.0-or-later
"""The icons of layers say what they should: thicker is higher, rougher is more jagged, color and coverage are seen."""

import numpy as np
import pytest

from lamina.addon.ui.swatch import SIZE, base_picture, layer_picture

CLEAR = (1.0, 1.0, 1.0)


def heights(picture: np.ndarray) -> np.ndarray:
    return (picture[..., 3] > 0.0).sum(axis=0)


def test_thicker_layers_are_higher_and_all_fit():
    means = [heights(layer_picture(CLEAR, t, 0.0, "ggx")).mean() for t in (0.0, 0.5, 1.0, 2.0, 1000.0)]
    assert means == sorted(set(means)) and means[0] >= 0.2 * SIZE and means[-1] < SIZE


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
def test_rougher_surfaces_are_more_jagged(distribution):
    spreads = [np.ptp(heights(layer_picture(CLEAR, 1.0, r, distribution))) for r in (0.0, 0.5, 0.75, 1.0)]
    assert spreads[0] == 0 and spreads == sorted(spreads) and spreads[-1] >= 3
    assert np.ptp(heights(base_picture(CLEAR, 0.8, distribution))) > 0


def test_color_and_coverage_are_seen():
    red = layer_picture((0.8, 0.1, 0.1), 1.0, 0.2, "ggx")
    inside = red[red[..., 3] > 0.0]
    assert inside[:, 0].mean() > 1.5 * inside[:, 1].mean() and red.min() >= 0.0 and red.max() <= 1.0
    half = heights(layer_picture(CLEAR, 1.0, 0.0, "ggx", coverage=0.5))
    assert half[: SIZE // 2].min() > 0 and half[SIZE // 2 :].max() == 0
    assert base_picture((0.5, 0.5, 0.5), 0.0, "ggx")[0, 0, :3] == pytest.approx(0.735, abs=0.005)  # sRGB of a half
