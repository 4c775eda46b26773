# SPDX-License-Identifier: GPL-3.0-or-later
"""The two truths agree on the suite. `lamina chart suite -o figures` compares all of it, here a few stacks and few walks."""

import csv
import random
from pathlib import Path

import numpy as np
import pytest

from lamina.reference_py import agreement as module
from lamina.reference_py.agreement import ADDING_ALBEDO, ADDING_F, COLUMNS, NARROW, SIGMAS, agreement, direction_grid
from lamina.reference_py.models import make_model
from lamina.reference_py.suite import suite, suite_stack

TABLE = Path(__file__).parents[2] / "figures" / "suite_agreement.csv"
# What walks take a minute to say is left to the chart.
SHORT = [name for name, stack in suite().items() if len(stack.layers) <= 2]
SUBSET = random.Random(7).sample(SHORT, 6) + ["three_smooth"]


def committed():
    rows = [row for row in csv.reader(TABLE.read_text().splitlines()) if not row[0].startswith("#")]
    header, *rows = rows
    return {row[0]: dict(zip(header[1:], row[1:])) for row in rows}


@pytest.mark.parametrize("name", SUBSET)
def test_truths_agree(name):
    result = agreement(suite_stack(name), most_walks=8192, f_walks=150, seed=3)
    assert result.sigmas <= SIGMAS
    assert result.mean <= SIGMAS * result.stderr + ADDING_ALBEDO
    if result.narrowest == 0.0 or result.narrowest >= NARROW:
        assert result.f_beyond <= ADDING_F


def test_the_committed_table_has_every_stack_and_all_agree():
    rows = committed()
    assert list(rows) == list(suite()), "run lamina chart suite -o figures"
    assert len(rows) >= 60
    assert [name for name, row in rows.items() if "no" in (row["albedo_agrees"], row["f_agrees"])] == []


@pytest.mark.parametrize("name", ["lambert_grey", "plastic_grey_0", "plastic_tinted"])
def test_committed_figures_are_those_of_this_code(name):
    row, result = committed()[name], agreement(suite_stack(name))
    for column in COLUMNS:
        assert float(row[column]) == pytest.approx(getattr(result, column), rel=0.01, abs=1e-6), column


def test_a_wrong_truth_is_seen(monkeypatch):
    """Five hundredths on an index are 3 % of the albedo of a grey plastic."""
    stack = suite_stack("plastic_grey_0")
    off = type(stack).from_dict({**stack.to_dict(), "layers": [{**stack.layers[0].to_dict(), "ior": 1.55}]})

    def wrong(name, given, **options):
        return make_model(name, off if name == "adding" else given, **options)

    monkeypatch.setattr(module, "make_model", wrong)
    result = agreement(stack, most_walks=65_536, f_walks=100)
    assert not result.albedo_agrees and not result.f_agrees


def test_the_grid_is_above_the_surface_and_off_the_mirror_direction():
    wo, wi = direction_grid()
    assert np.all(wo[:, 2] > 0.1) and np.all(wi[:, 2] > 0.1)
    assert np.min(np.linalg.norm(wo[:, :2] + wi[:, :2], axis=-1)) > 0.05
