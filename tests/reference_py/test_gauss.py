# SPDX-License-Identifier: GPL-3.0-or-later
"""Gauss-Legendre quadrature is exact for polynomials of less than twice its number of nodes."""

import numpy as np
import pytest

from lamina.reference_py.optics.gauss import gauss_legendre


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 12, 31, 64, 192])
def test_polynomials_are_integrated_exactly(count):
    nodes, weights = gauss_legendre(count)
    assert len(nodes) == len(weights) == count and np.all(np.diff(nodes) > 0.0)
    np.testing.assert_array_equal(nodes, -nodes[::-1])
    for degree in (0, count - count % 2, 2 * count - 2):
        assert np.sum(weights * nodes**degree) == pytest.approx(2.0 / (degree + 1), rel=1e-13), degree
