# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart` answers to the names that its charts had before."""

import argparse

import pytest

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
