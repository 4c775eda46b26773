# SPDX-License-Identifier: GPL-3.0-or-later
"""No cell of figures/stress.csv gets worse. `lamina chart stress -o figures` measures all of them anew."""

from dataclasses import asdict

import numpy as np
import pytest

from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import MODELS
from lamina.study.stress import CASES, COLUMNS, MODELS_AND_METHODS, REFUSED, Case, is_refused, measure, pairs, relative_difference
from lamina.study.tables import FIGURES, read_rows

TABLE = FIGURES / "stress.csv"
# What other processors' rounding may add; three digits are written.
MARGIN, ABSOLUTE = 0.02, 1e-6
# Rounding of directions is amplified by chance.
DRIFT = 3.0

# Cases that take long in models that cost much: the chart alone measures these.
COSTLY = {"closure_model:weidlich_wilkie", "adding", "position_free", "closure_model:baked", "closure_model:analytic", "belcour", "openpbr_coat", "kelemen"}
QUICK_CASES = {
    "grazing, rough over metal",
    "equal indices",
    "denser above thinner, smooth",
    "air gap",
    "alpha 0",
    "alpha 1",
    "thickness 0",
    "absorption 0 and huge",
    "smooth over rough",
    "white, smooth",
    "white, rough",
    "below the horizon",
    "view on the horizon",
    "no half vector",
}
# Each case is a bake.
BAKED_CASES = {"air gap", "alpha 1", "absorption 0 and huge", "white, rough", "below the horizon", "no half vector"}


def committed():
    header, *rows = read_rows(TABLE)
    assert header == ["model", "case", *COLUMNS]
    return {(row[0], row[1]): dict(zip(COLUMNS, row[2:])) for row in rows}


@pytest.mark.parametrize("name", MODELS_AND_METHODS)
def test_no_cell_is_worse_than_the_committed_one(name):
    worse = []
    for case in CASES:
        if name in COSTLY and case not in (BAKED_CASES if name == "closure_model:baked" else QUICK_CASES):
            continue
        before = committed()[name, case]
        for column, value in asdict(measure(name, CASES[case])).items():
            if not is_no_worse(column, value, before[column]):
                worse.append(f"{case}: {column} is {value}, was {before[column]}")
    assert not worse


def is_no_worse(column, value, before):
    if value is None or isinstance(value, bool):
        return before == {None: "", True: "yes", False: "no"}[value] or value is True
    factor = DRIFT if column == "float32_drift" else 1.0 + MARGIN
    return value <= factor * float(before) + ABSOLUTE


def test_the_table_has_every_model_and_case():
    expected = {(name, case) for name in MODELS_AND_METHODS for case in CASES} | {("(all)", case) for case in REFUSED}
    assert set(committed()) == expected, "run lamina chart stress -o figures"


def test_no_model_breaks_down():
    """Whatever else is wrong, values are finite, none is negative, and nothing shines below the horizon."""
    for key, row in committed().items():
        if key[0] != "(all)":
            assert (row["finite"], row["non_negative"], row["below_horizon"]) == ("yes", "yes", "0"), key


@pytest.mark.parametrize("case", REFUSED)
def test_bad_parameters_reach_no_model(case):
    assert is_refused(REFUSED[case]) and committed()["(all)", case]["finite"] == "refused"


@pytest.mark.parametrize("truth", ["adding", "position_free"])
def test_the_truths_neither_gain_nor_lose_energy(truth):
    for (name, case), row in committed().items():
        # 90 degrees is a limit, where a grid's directions end; a white Oren-Nayar base is one to 3e-4 only
        if name == truth and case != "view on the horizon":
            assert float(row["energy_excess"]) < 3e-4, case
            assert float(row["exact_error"] or 0.0) < 1e-6, case
            assert float(row["reciprocity"]) < 1e-6, case


class Faulty:
    """A model with every fault that the table has a column for."""

    stochastic = False

    def f(self, wo, wi):
        bad = np.where(wo[..., 2] > 0.9, np.nan, -1.0 - 2.0 * wo[..., 2] + 1e3 * (np.asarray(wo).dtype == np.float32))
        return np.repeat(bad[..., None], 3, axis=-1)

    def albedo(self, wo):
        return np.full(wo.shape, 1.25)


def test_faults_are_counted(monkeypatch):
    monkeypatch.setitem(MODELS, "faulty", Faulty)
    monkeypatch.setattr("lamina.study.stress.make_model", lambda name, stack: Faulty())
    row = measure("faulty", CASES["white, smooth"])
    assert not row.finite and not row.non_negative
    assert row.energy_excess == row.exact_error == 0.25
    assert row.reciprocity > 0.1 and row.float32_drift > 0.9
    assert measure("faulty", CASES["below the horizon"]).below_horizon >= 1.25


def test_noise_is_no_fault():
    value, error = np.ones((5, 3)), np.full((5, 3), 0.1)
    assert relative_difference((value, error), (1.2 * value, error)) == 0.0
    assert relative_difference((value, error), (2.0 * value, error)) == pytest.approx((1.0 - 0.4 * 2.0**0.5) / 2.001)


def test_pairs_cover_what_their_case_is_about():
    for case in CASES.values():
        wo, wi = pairs(case)
        assert wo.shape == wi.shape and np.allclose(np.linalg.norm(wo, axis=-1), 1.0)
    wo, wi = pairs(CASES["below the horizon"])
    assert np.all((wo[:, 2] < 0.0) | (wi[:, 2] < 0.0))
    wo, wi = pairs(CASES["no half vector"])
    assert np.min(np.linalg.norm(wo + wi, axis=-1)) == 0.0
    wo, wi = pairs(Case(CASES["white, bare"].stack, (30.0,)))
    assert np.allclose(wi[0], spherical(np.radians(30.0), 0.3 + np.pi)) and np.array_equal(wi[1], wo[1])
