# SPDX-License-Identifier: GPL-3.0-or-later
"""The committed tables of errors are those of this code: a few rows of each are measured again."""

import numpy as np
import pytest

from lamina.addon.cli.stack_errors import errors_of
from lamina.reference_py.material import presets
from lamina.reference_py.models.distance import distance
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.charts import error_by_angle
from lamina.study.stress import make_model_or_method
from lamina.study.tables import FIGURES, read_rows

PRESET_ERRORS = FIGURES / "preset_errors.csv"


@pytest.mark.parametrize("name", error_by_angle.COMPARED)
def test_albedo_errors_by_angle_are_those_of_this_code(name):
    rows = {(row[0], row[1]): row[2:] for row in read_rows(FIGURES / "error_by_angle.csv")}
    assert {key for key in rows if key[0] in presets.PAPER} == {(p, m) for p in presets.PAPER for m in error_by_angle.COMPARED}
    preset, chosen = "metallic_car_paint", np.array([0, 6, 10])
    stack, wo = presets.load(preset), spherical(np.radians(error_by_angle.THETA_DEG[chosen]), 0.0)
    measured = error_by_angle.worst_channel(make_model_or_method(name, stack).albedo(wo), make_model("adding", stack).albedo(wo))
    assert measured == pytest.approx(np.array(rows[preset, name], float)[chosen], abs=2e-4)


@pytest.mark.parametrize("name", presets.PAPER)
def test_errors_of_the_papers_tier_are_those_of_this_lobe_set(name):
    header, *rows = read_rows(FIGURES / "lobe_errors.csv")
    rows = [row for row in rows if row[0] == name]
    columns = [header.index("30deg"), header.index("75deg")]
    stack = presets.load(name)
    gap = distance(stack, make_model("closure_model", stack, method="weidlich_wilkie"), make_model("weidlich_wilkie", stack), np.radians([30.0, 75.0]))
    for row, measured in zip(rows, (gap.albedo, gap.shape)):
        assert measured == pytest.approx([float(row[c]) for c in columns], abs=2e-4)
    assert gap.albedo.max() <= 0.01
    assert gap.shape.max() <= 0.19


def test_every_preset_has_its_error_stated():
    rows = read_rows(PRESET_ERRORS)
    told = {row[0]: row[1:] for row in rows[1:]}
    assert sorted(told) == presets.names()
    for name, (chosen, closures, truth, albedo, stderr, shape) in told.items():
        assert chosen and int(closures) > 0 and 0.0 <= float(albedo) < 0.15, name
        assert (truth == "adding") == (shape != "") == (float(stderr) == 0.0), name


@pytest.mark.parametrize("name", ["polished_chrome", "blued_steel"])
def test_the_stated_error_is_that_of_this_code(name):
    row = next(row for row in read_rows(PRESET_ERRORS) if row[0] == name)
    found = errors_of(presets.load(name))
    assert [found.chosen, str(found.closures), found.truth] == row[1:4]
    assert found.albedo == pytest.approx(float(row[4]), abs=2e-4 + 4.0 * float(row[5]))
