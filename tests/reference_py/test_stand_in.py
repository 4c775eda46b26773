# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in for a slow model: the closures of the method `analytic`, many stacks at once."""

import numpy as np
import pytest

from lamina.reference_py.fit.forward import ModelForward
from lamina.reference_py.fit.metric import Metric, rms
from lamina.reference_py.fit.parameters import Parameters, Structure
from lamina.reference_py.fit.readers.measurement import checked, spread_pairs
from lamina.reference_py.fit.stand_in import stand_in
from lamina.study.fit_recovery import random_stack, random_structure


def both(structure: Structure, channels: int = 3, pairs: int = 120):
    wi, wo = spread_pairs(pairs, np.random.default_rng(0))
    f = np.linspace(0.1, 0.5, channels * pairs).reshape(pairs, channels)
    parameters, metric = Parameters(structure, channels), Metric(checked(wi, wo, f, "numbers"))
    many, is_other = stand_in("adding", parameters, metric)
    assert is_other
    return many, ModelForward(parameters, metric, "closure_model", {"method": "analytic"})


@pytest.mark.parametrize("layers", [0, 1, 2])
@pytest.mark.parametrize("number", [0, 1, 2, 4])
def test_it_is_the_closures_of_the_method(layers, number):
    structure = random_structure(layers, number)
    many, one = both(structure)
    x = np.stack([many.parameters.coordinates(random_stack(structure, np.random.default_rng(seed))) for seed in range(4)])
    apart = [rms(a - b) for a, b in zip(many.compressed_at(x), one.compressed_at(x))]
    # what a cubic over 24 views leaves of the tables' cells (.2 % measured)
    assert max(apart) < 0.003


@pytest.mark.parametrize("channels", [1, 3])
def test_stacks_of_different_ways_go_together(channels):
    """Media that are denser than those above, thinner, and no others; bases with facets and without."""
    many, one = both(Structure.of(2, "oren_nayar"), channels)
    names = many.parameters.names
    x = np.tile(np.where([name.startswith("roughness") for name in names], 0.5, 0.4), (5, 1))
    first, second, facets = (names.index(name) for name in ("ior of layer 0", "ior of layer 1", "sigma_deg of the base"))
    x[:, first], x[:, second] = [0.2, 0.2, 0.2, 0.0, 0.0], [0.3, 0.1, 0.2, 0.1, 0.0]
    x[::2, facets] = 0.0
    together, alone = many.compressed_at(x), np.stack([many.compressed(each) for each in x])
    assert together == pytest.approx(alone, abs=1e-12)
    assert max(rms(a - b) for a, b in zip(together, one.compressed_at(x))) < 0.003
    slopes = many.jacobian(x[1])
    assert rms(slopes - one.jacobian(x[1])) < 0.02 * rms(slopes)


def test_it_is_lifted_by_what_it_lacks():
    many, _ = both(Structure.of(1, "lambert"))
    lacking = np.linspace(-0.1, 0.1, many.target.size)
    lifted, _ = stand_in("adding", many.parameters, many.metric, lacking)
    x = np.full(many.parameters.size, 0.4)
    assert lifted.residual(x) - many.residual(x) == pytest.approx(lacking)
    assert lifted.jacobian(x) == pytest.approx(many.jacobian(x), abs=1e-8)
