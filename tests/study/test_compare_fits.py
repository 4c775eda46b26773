# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits beside those of another commit: which are worse, and of those which the data prefer."""

from lamina.study.compare_fits import compared, fits

COLUMNS = ["layers", "noise", "number", "base", "distribution", "shape_error", "rms_log", "data_error", "true_data_error"]


def table(*errors):
    return fits([COLUMNS, *([str(1), noise, str(i), "lambert", "ggx", shape, shape, data, "0.030"] for i, (noise, shape, data) in enumerate(errors))])


def test_worse_and_better_fits_are_counted_with_what_the_data_say():
    before = table(("0", "0.00000", "0"), ("0.05", "0.010", "0.029"), ("0.05", "0.010", "0.029"), ("0.05", "0.010", "0.029"))
    after = table(("0", "0.00001", "0"), ("0.05", "0.012", "0.029"), ("0.05", "0.012", "0.031"), ("0.05", "0.008", "0.029"))
    without, _, noisy, _ = compared(before, after)
    assert "0 worse by a tenth" in without, "the table's last digit is no change"
    assert "2 worse by a tenth (to 0.012), 1 better; of the worse 1 nearer to the data" in noisy


def test_tables_that_share_no_fits_of_a_kind_say_so():
    _, _, noisy = compared(table(("0", "0.010", "0")), table(("0", "0.010", "0")))
    assert noisy == "with noise: the two tables share no fits"
