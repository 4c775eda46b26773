# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed in tables: rows are told by their words, whatever their order."""

import pytest

from lamina.study.compare_figures import compare

TABLE = [["name", "tier", "error", "share"], ["a", "auto", "0.02", "10 %"], ["b", "auto", "0.04", "50 %"], ["b", "auto", "1.0", "50 %"]]


def test_a_table_is_itself_in_any_order_of_different_rows():
    change = compare(TABLE, [TABLE[0], *TABLE[2:], TABLE[1]])
    assert change.rows == (3, 0) and change.median == change.largest == 0.0


def test_the_largest_change_is_named():
    after = [TABLE[0], ["a", "auto", "0.03", "10 %"], *TABLE[2:]]
    change = compare(TABLE, after)
    assert change.place == "error of a, auto" and change.largest == pytest.approx(0.01 / (0.02 + 0.01 * 1.0)) and change.median == 0.0


def test_rows_of_one_alone_are_counted():
    assert compare(TABLE, [*TABLE[:3], ["c", "auto", "1.0", "1 %"]]).rows == (2, 2)
