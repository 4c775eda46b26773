# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of MaterialX files: every file has its row, and a color that was read wrong shows."""

import pytest

pytest.importorskip("colour")

from lamina.addon.cli.main import run
from lamina.reference_py.exchange import materialx_graph
from lamina.study.charts.exchange import row_of
from lamina.study.tables import read_table

FILE = (
    '<materialx version="1.39" colorspace="acescg"><open_pbr_surface name="s" type="surfaceshader">'
    '<input name="base_color" type="color3" value="0.3, 0.4, 0.2"/></open_pbr_surface></materialx>'
)


def test_every_file_has_its_row(tmp_path):
    (tmp_path / "leaf.mtlx").write_text(FILE)
    (tmp_path / "hair.mtlx").write_text(FILE.replace("open_pbr_surface", "some_hair"))
    assert run(["chart", "exchange", "--files", str(tmp_path), "-o", str(tmp_path)]) == 0
    hair, leaf = read_table(tmp_path / "exchange.csv")
    assert hair["lost"] == "refused" and leaf["unsaid"] == "no" and float(leaf["read_ciede2000"]) < 0.1
    assert run(["chart", "exchange", "-o", str(tmp_path)]) == 2


def test_a_wrong_color_space_shows(tmp_path, monkeypatch):
    (tmp_path / "leaf.mtlx").write_text(FILE)
    monkeypatch.setattr(materialx_graph, "to_linear_rec709", lambda color, _: color)
    row = row_of(tmp_path / "leaf.mtlx")
    assert float(row[8]) > 1.0 and row[9] == "yes"
