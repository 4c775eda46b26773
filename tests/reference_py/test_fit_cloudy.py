# SPDX-License-Identifier: GPL-3.0-or-later
"""A base below a medium that scatters is found again, and what a plain layer says as well is said to be plain.

Data and fits are of the same coarse settings of the truth, which are as hard to invert.
"""

from dataclasses import replace

import numpy as np
import pytest

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.fit import fitting, layer_count, stand_in
from lamina.reference_py.fit.fitting import Start, corrected
from lamina.reference_py.fit.metric import Metric
from lamina.reference_py.fit.parameters import Parameters, Structure
from lamina.reference_py.fit.readers.measurement import checked, spread_pairs
from lamina.reference_py.fit.solve import Solution
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.registry import make_model

COARSE = {"nodes": 8, "modes": 2}
CLOUDY = Structure.of(1, "lambert", cloudy=True)
TRUE = {"ior": 1.5, "roughness": 0.5, "scatter_color": [0.7] * 3, "density": 0.8, "scatter_g": 0.3}


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    monkeypatch.setattr(stand_in, "_COARSE", COARSE)
    monkeypatch.setattr(fitting, "_DIRECT_STEPS", 5)


def stack(**values):
    return Stack.from_dict({"layers": [{"kind": "dielectric", **values}], "base": {"kind": "lambert", "color": [0.25] * 3}})


def metric_of(one: Stack, pairs=30) -> Metric:
    wo, wi = spread_pairs(pairs, np.random.default_rng(3))
    f = make_model("adding", one, **COARSE).f(wo, wi)[:, :1]
    return Metric(checked(wi, wo, f, "samples", ()))


def test_coordinates_are_the_inverse_of_a_cloudy_stack():
    parameters = Parameters(Structure.of(2, "conductor", cloudy=True), 3)
    data = {
        "layers": [{"kind": "dielectric", "ior": 1.3}, {"kind": "dielectric", **TRUE}],
        "base": {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [0.8] * 3},
    }
    again = parameters.stack(parameters.coordinates(Stack.from_dict(data)))
    assert again.layers[1]["density"] == pytest.approx(0.8) and again.layers[1]["scatter_g"] == pytest.approx(0.3)
    assert again.layers[1]["scatter_color"] == pytest.approx(TRUE["scatter_color"]) and "density" not in again.layers[0]
    x, step = parameters.coordinates(again), 1e-6
    assert (parameters.values(x + step) - parameters.values(x - step)) / (2.0 * step) == pytest.approx(parameters.slopes(x), rel=1e-5)
    for x in (np.zeros(parameters.size), np.ones(parameters.size)):
        parameters.stack(x)  # the ends are within the schema's bounds


def test_a_base_under_a_cloudy_layer_is_found():
    metric = metric_of(stack(**TRUE))
    begin = Parameters(CLOUDY, 1).coordinates(stack(**TRUE | {"density": 0.6, "scatter_g": 0.2}))
    begin[-1] += 0.05
    fit = corrected(metric, Start(CLOUDY, begin), "adding")
    assert fit.error < 2e-3
    assert fit.stack.base["color"][0] == pytest.approx(0.25, abs=0.01) and fit.stack.layers[0]["density"] == pytest.approx(0.8, abs=0.08)


@pytest.mark.parametrize("one, is_told", [(stack(ior=1.5, roughness=0.5), False), (stack(**TRUE | {"density": 1.5, "scatter_g": -0.3}), True)])
def test_a_plain_layer_is_said_to_be_plain_and_a_cloudy_one_is_told(one, is_told, monkeypatch):
    """Beside a plain fit, of one base and from one place."""
    begin = Parameters(CLOUDY, 1).coordinates(stack(**TRUE | {"density": 1.4 if is_told else 0.1, "scatter_g": -0.3}))
    monkeypatch.setattr(layer_count, "rough_fits", lambda *given: [(CLOUDY, Solution(begin, np.zeros(1), 0))])
    monkeypatch.setattr(fitting, "_DIRECT_STEPS", 3)
    metric, structure = metric_of(one), Structure.of(1, "lambert")
    plain = corrected(metric, Start(structure, Parameters(structure, 1).coordinates(stack(ior=1.5, roughness=0.5))), "adding", 2, options=COARSE)
    search = layer_count._Search(metric, "adding", np.random.default_rng(1))
    found = search.cloudy(layer_count.Selection(plain, (plain,), "plain"), ("lambert",), None)
    assert found.best.structure.cloudy == is_told and [fit.structure.cloudy for fit in found.tried] == [False, True]
    said = "a medium that scatters above the base brings the error" if is_told else "plain; a cloudy layer cannot be told from a plain one by these data"
    assert found.reason.startswith(said)


def test_without_it_no_structure_is_cloudy():
    found = Parameters(Structure.of(1, "lambert"), 3)
    assert found == replace(found, structure=Structure.of(1, "lambert", cloudy=False)) and not any("scatter" in name for name in found.names)


def test_bad_choices_are_one_line(capsys):
    with pytest.raises(LaminaError, match="without a layer nothing above the base is cloudy"):
        Structure.of(0, "lambert", cloudy=True)
    assert run(["fit", "glazed_mug", "--sample", "schlick", "--model", "schlick", "--cloudy"]) == 2
    assert "a cloudy layer goes with the model adding" in capsys.readouterr().err
