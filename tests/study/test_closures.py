# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart of Cycles' layered closures: what the committed table says of both Blenders, and Lamina's rows by this code."""

import numpy as np
import pytest

from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.charts.closures import COLUMNS, SURFACES, VIEWS_DEG, texts, truth
from lamina.study.tables import FIGURES, read_table


@pytest.fixture(scope="module")
def table():
    found = {}
    for row in read_table(FIGURES / "closures.csv"):
        assert list(row) == list(COLUMNS)
        found[row["blender"], row["surface"], row["closures"]] = [float(row[f"error_{view:g}"]) for view in VIEWS_DEG]
    return found


def test_lamina_is_closer_than_every_closure_of_a_coat(table):
    for (blender, surface, closures), errors in table.items():
        if "coat" in surface and blender != "all":
            ours = table["all", surface, "lamina"]
            assert max(ours) < 0.005 and min(errors) > 0.25, (blender, surface, closures)
    assert {blender for blender, _, _ in table} == {"4.5", "5.3", "all"}


def test_films_on_a_dielectric_are_of_5_3_alone(table):
    film = "film on a rough dielectric"
    assert max(table["5.3", film, "cycles dielectric_bsdf"]) < 0.06 and min(table["4.5", film, "cycles dielectric_bsdf"]) > 0.25


def test_lamina_rows_are_of_this_code(table):
    surface, wo = "smooth coat over paint", spherical(np.radians(VIEWS_DEG), 0.0)
    stack = SURFACES[surface]
    found = np.max(np.abs(make_model("closure_model", stack, method="baked").albedo(wo) / truth(stack).albedo(wo) - 1.0), axis=1)
    assert found == pytest.approx(table["all", surface, "lamina"], abs=1e-3)


@pytest.mark.blender
def test_shaders_of_one_blender_are_made_for_it_alone():
    pytest.importorskip("bpy")
    stack = SURFACES["rough coat over paint"]
    assert list(texts(stack, "4.5")) == ["layer"] and list(texts(stack, "5.3")) == ["layer", "coat_bsdf"]
    assert ", 0.36, 0.36," in texts(stack, "5.3")["layer"] and "coat_bsdf(color(1), 1.5, 0.6, N)" in texts(stack, "5.3")["coat_bsdf"]
