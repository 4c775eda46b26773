# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart of tints as spectra: the committed table is what the code gives, and spectra of smooth laws over diffuse bases are right."""

import numpy as np
import pytest

from lamina.study.charts.tint_spectrum import BASES, COLUMNS, DEPTHS, THICKNESS, compare
from lamina.study.tables import FIGURES, read_rows


def test_the_committed_table_is_what_the_code_gives():
    header, *rows = read_rows(FIGURES / "tint_spectrum.csv")
    assert header == list(COLUMNS) and len(rows) == len(DEPTHS) * len(BASES) * len(THICKNESS)
    errors, _ = compare(np.exp(-DEPTHS["amber"]), "white", 5.0)
    row = next(r for r in rows if r[:3] == ["amber", "white", "5"])
    assert [float(v) for v in row[3:9]] == pytest.approx(errors.ravel(), abs=1e-3)


def test_smooth_laws_over_diffuse_bases_are_within_two_percent():
    rows = [r for r in read_rows(FIGURES / "tint_spectrum.csv")[1:] if r[0] in ("amber", "melanin") and r[1] in ("white", "grey")]
    assert max(float(v) for r in rows for v in r[6:9]) < 0.021 and max(float(v) for r in rows for v in r[3:6]) > 0.15
