# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart of copper under amber: the committed table is what the code gives, and three wavelengths are three channels."""

import numpy as np
import pytest

from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.charts.spectral import COLUMNS, THICKNESS, VIEWS_DEG, colors, spectral, three_channels
from lamina.study.tables import FIGURES, read_rows


def test_the_committed_table_is_what_the_code_gives():
    header, *rows = read_rows(FIGURES / "spectral.csv")
    assert header == list(COLUMNS) and len(rows) == len(THICKNESS) * len(VIEWS_DEG)
    written = [[float(v) for v in cell.split()] for cell in rows[-1][2:5]]
    assert np.array(written) == pytest.approx(colors(THICKNESS[-1])[:, -1], abs=1e-3)
    # a tint in RGB keeps too much of what the glaze takes: red here, and blue
    assert np.all(np.subtract(written[1], written[0]) > 0.005) and 1.0 < float(rows[-1][5]) < 4.0


def test_three_wavelengths_are_the_channels_of_one_stack():
    stack, chosen, view = spectral(5.0), np.array([2, 17, 30]), spherical(np.radians(40.0), 0.0)
    whole = make_model("adding", stack, nodes=16).albedo(view)
    assert make_model("adding", three_channels(stack, chosen), nodes=16).albedo(view) == pytest.approx(whole[chosen], rel=1e-9)
    assert np.ptp(whole[chosen]) > 0.5
