# SPDX-License-Identifier: GPL-3.0-or-later
"""The two truths agree on the suite. `lamina chart suite -o figures` compares all of it, here a few stacks and few walks."""

import random

import numpy as np
import pytest

from lamina.reference_py.registry import make_model
from lamina.study import agreement as module
from lamina.study.agreement import ADDING_ALBEDO, ADDING_F, COLUMNS, NARROW, SIGMAS, agreement, direction_grid
from lamina.study.suite import scattering_suite, suite, suite_stack
from lamina.study.tables import FIGURES, read_rows

TABLE = FIGURES / "suite_agreement.csv"
# What walks take a minute to say is left to the chart.
SHORT = [name for name, stack in suite().items() if len(stack.layers) <= 2]
SUBSET = random.Random(7).sample(SHORT, 6) + ["three_smooth"]


def committed():
    header, *rows = read_rows(TABLE)
    return {row[0]: dict(zip(header[1:], row[1:])) for row in rows}


@pytest.mark.parametrize("name", SUBSET)
def test_truths_agree(name):
    result = agreement(suite_stack(name), most_walks=8192, seed=3)
    assert result.sigmas <= SIGMAS
    assert result.mean <= SIGMAS * result.stderr + ADDING_ALBEDO
    if result.narrowest == 0.0 or result.narrowest >= NARROW:
        assert result.f_beyond <= ADDING_F


def test_the_committed_table_has_every_stack_and_all_albedos_agree():
    rows = committed()
    assert list(rows) == list(suite()), "run lamina chart suite -o figures"
    assert len(rows) >= 60
    assert [name for name, row in rows.items() if row["albedo_agrees"] != "yes"] == []


def test_f_agrees():
    rows = committed()
    assert [name for name, row in rows.items() if row["f_agrees"] != "yes"] == []
    assert max(float(row["f_median"]) for row in rows.values()) < 0.03


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
    result = agreement(stack, most_walks=65_536, f_walks=6000)
    assert not result.albedo_agrees and not result.f_agrees


def test_the_grid_is_above_the_surface_and_off_the_mirror_direction():
    wo, wi = direction_grid()
    assert np.all(wo[:, 2] > 0.1) and np.all(wi[:, 2] > 0.1)
    assert np.min(np.linalg.norm(wo[:, :2] + wi[:, :2], axis=-1)) > 0.05


def test_truths_agree_on_every_stack_whose_media_scatter():
    header, *rows = read_rows(FIGURES / "scattering_agreement.csv")
    told = {row[0]: dict(zip(header[1:], row[1:])) for row in rows}
    assert list(told) == list(scattering_suite()), "run lamina chart scattering -o figures"
    assert len(told) >= 24
    assert {(row["albedo_agrees"], row["f_agrees"]) for row in told.values()} == {("yes", "yes")}


@pytest.mark.parametrize("name", ["bare_haze_over_red", "smooth_forward_over_mirror", "rough_one_isotropic"])
def test_that_is_so_with_this_code(name):
    result = agreement(scattering_suite()[name], most_walks=8192, f_walks=2000, seed=3)
    assert result.sigmas <= SIGMAS and result.f_beyond <= ADDING_F


def test_half_spaces_and_explicit_slabs_are_as_they_should_be():
    header, *rows = read_rows(FIGURES / "half_space.csv")
    assert max(float(row[header.index(name)]) for row in rows for name in ("albedo_worst", "f_worst")) < 1e-4
    header, *rows = read_rows(FIGURES / "mitsuba_slabs.csv")
    assert len({row[0] for row in rows}) >= 6
    assert max(float(row[header.index("worst_error")]) for row in rows) <= 0.01
