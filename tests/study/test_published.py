# SPDX-License-Identifier: GPL-3.0-or-later
"""What others published of layered surfaces is what `adding` says, and the committed table is of this code."""

import pytest

from lamina.study.charts import published
from lamina.study.tables import FIGURES, read_rows


@pytest.fixture(scope="module")
def rows():
    return published.rows()


def test_cloudy_slabs_are_those_of_another_adding_doubling(rows):
    slabs = [row for row in rows if row[0] == "prahl"]
    assert len(slabs) == 20
    for _, surface, light, stated, refined, own in slabs:
        # five digits, and a slab of depth 60 for one without end
        assert own == pytest.approx(stated if refined is None else refined, abs=5e-5), (surface, light)


def test_smooth_layers_differ_by_polarization_alone(rows):
    layers = [row for row in rows if row[0] == "byrnes"]
    assert len(layers) == 30
    for _, surface, light, stated, _, own in layers:
        # along the normal there is none; elsewhere it is stated, and worst in glass near 75 degrees
        assert own == pytest.approx(stated, abs=2e-5 if light == "0 deg" else 0.023), (surface, light)


def test_the_committed_table_is_of_this_code(rows):
    _, *committed = read_rows(FIGURES / "published.csv")
    assert [row[:3] for row in committed] == [list(row[:3]) for row in rows]
    assert [float(row[5]) for row in committed] == pytest.approx([row[5] for row in rows], abs=2e-5)


def test_every_source_has_its_licence():
    assert all(source["licence"].startswith("MIT, Copyright") and source["source"] for source in published.published().values())
