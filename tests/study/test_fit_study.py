# SPDX-License-Identifier: GPL-3.0-or-later
"""The study of fits: its bound, and how it goes on where it stopped."""

import numpy as np
from support.measured import paint

from lamina.reference_py.fit.metric import Metric
from lamina.reference_py.fit.readers.measurement import checked, spread_pairs
from lamina.study.charts import fit_charts as chart
from lamina.study.fit_bound import least_error
from lamina.study.tables import write_table


def test_no_stack_comes_closer_than_the_best_sum_of_lobes():
    wi, wo = spread_pairs(150, np.random.default_rng(3))
    mine = Metric(checked(wi, wo, paint(wi, wo)[:, :1], "paint"))
    assert least_error(mine) < 0.02
    stripes = np.where(np.sin(25.0 * wo[:, :1]) > 0.0, 3.0, 0.01)
    assert least_error(Metric(checked(wi, wo, stripes, "stripes"))) > 0.3


def test_a_study_goes_on_where_it_stopped_and_an_ended_one_begins_anew(tmp_path):
    path, heading = tmp_path / "fit_recovery.csv", ("lamina chart fit", "random stacks, with a comma")
    rows = [tuple(f"{i}" for _ in chart._RECOVERY_COLUMNS) for i in range(3)]
    assert chart._begun(path, heading, 4) == []
    write_table(path, heading, chart._RECOVERY_COLUMNS, rows)
    assert chart._begun(path, heading, 4) == rows
    assert chart._begun(path, heading, 3) == []
    assert chart._begun(path, ("lamina chart fit", "another study"), 4) == []
