# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart`: the names that its charts had before, and what it needs."""

import argparse
import sys
from importlib import import_module

import pytest

from lamina.addon.cli.main import BAD_INPUT, run
from lamina.study.commands import CHARTS, OLD_NAMES, add_commands


@pytest.fixture
def parser():
    parser = argparse.ArgumentParser()
    add_commands(parser.add_subparsers())
    return parser


@pytest.mark.parametrize("old", OLD_NAMES)
def test_old_names_of_charts_are_accepted_and_said(parser, capsys, old):
    assert OLD_NAMES[old] in CHARTS and parser.parse_args(["chart", old]).chart == OLD_NAMES[old]
    with pytest.raises(SystemExit):
        parser.parse_args(["chart", "--help"])
    assert f"{OLD_NAMES[old]} (also {old})" in " ".join(capsys.readouterr().out.split())


def test_other_names_are_refused_with_the_choices(parser, capsys):
    with pytest.raises(SystemExit):
        parser.parse_args(["chart", "lever"])
    assert "cost_factors" in capsys.readouterr().err


@pytest.mark.parametrize("chart", ("pair", "pareto", "viewport"))
def test_without_colour_science_it_says_so_before_any_work(tmp_path, monkeypatch, capsys, chart):
    monkeypatch.setitem(sys.modules, "colour", None)
    assert run(["chart", chart, "-o", str(tmp_path)]) == BAD_INPUT
    error = capsys.readouterr().err
    assert "colour-science: pip install lamina[figures]" in error and len(error.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_every_chart_has_its_function():
    for name in CHARTS.values():
        assert callable(import_module(f"lamina.study.charts.{name}").chart), name
