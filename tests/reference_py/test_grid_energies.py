# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of grids: truths that are asked side by side are those of each stack alone, and curves and modes lose nothing that they can tell."""

import numpy as np
import pytest
from support.coats import METAL, MILK, VARNISH, WOOD

from lamina.reference_py.lobes.axes import NumberAxis, Scale
from lamina.reference_py.lobes.baked.grid_energies import _cubic, _modes
from lamina.reference_py.lobes.baked.side_by_side import in_groups
from lamina.reference_py.lobes.samples import view_of
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack

VIEWS = np.stack([view_of(c) for c in (0.2, 0.6, 1.0)])


@pytest.mark.parametrize(
    "layers, base, place, values",
    [
        ([VARNISH], WOOD, Place(0, "thickness"), (0.0, 0.4, 3.0)),
        ([VARNISH], METAL, Place(None, "reflectance"), ((0.9, 0.5, 0.1), (0.2, 0.3, 0.4))),
        ([MILK], WOOD, Place(0, "density"), (0.1, 5.0)),
        ([MILK], METAL, Place(0, "scatter_color"), ((0.9, 0.5, 0.1), (0.2, 0.3, 0.4))),
        ([VARNISH], WOOD, Place(0, "roughness"), (0.2, 0.6)),
    ],
)
def test_truths_side_by_side_are_those_of_each_alone(layers, base, place, values):
    stacks = [place.with_value(Stack.from_dict({"layers": layers, "base": base}), value) for value in values]
    counts = []

    def of(truth, count):
        counts.append(count)
        return np.split(truth.albedo(VIEWS), count, axis=-1)

    for stack, albedo in zip(stacks, in_groups(stacks, of)):
        np.testing.assert_allclose(albedo, truth_of(stack).albedo(VIEWS), rtol=1e-6)
    assert counts == ([1, 1] if place.name == "roughness" else [len(values)])


def test_curves_through_cubics_are_these():
    places = np.linspace(0.0, 6.0, 31)
    np.testing.assert_allclose(_cubic(7, places) @ np.arange(7.0) ** 3, places**3, atol=1e-10)


def test_modes_tell_what_few_of_them_make():
    rng = np.random.default_rng(3)
    left = np.tensordot(rng.normal(size=(5, 6, 7, 2)), rng.normal(size=(2, 1, 24, 3)), 1)
    coefficients, modes = _modes(left, 0.002)
    assert coefficients.shape == (5, 6, 7, 3) and modes.shape == (1, 3, 24, 3)
    np.testing.assert_allclose(np.tensordot(coefficients, modes[0], 1), left[..., 0, :, :], atol=0.02)


def test_bent_knots_are_found_where_they_are():
    scale = Scale(0.05, 1.0, 13, 0.7)
    cell, way = scale.place(scale.knots)
    np.testing.assert_allclose(cell + way, np.arange(13), atol=1e-9)
    axis = NumberAxis((Place(0, "roughness"),), scale, scale, scale)
    assert np.diff(axis.fine.knots)[0] < 0.5 * np.diff(axis.fine.knots)[-1]
