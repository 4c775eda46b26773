# SPDX-License-Identifier: GPL-3.0-or-later
"""Documents quote the committed tables: `python -m lamina.study.numbers` fills in what these tests ask for."""

import re

import pytest

from lamina.reference_py.errors import LaminaError
from lamina.study import named_numbers, numbers
from lamina.study.named_numbers import NUMBERS, percent, plain, span, where, within_two_percent
from lamina.study.numbers import DOCUMENTS, differences, filled, main, names_in


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(numbers.ROOT)))
def test_documents_say_what_the_tables_say(path):
    assert differences(path.read_text(encoding="utf-8")) == [], "run python -m lamina.study.numbers"


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(numbers.ROOT)))
def test_no_line_of_words_begins_with_a_number(path):
    """Markdown takes such a line for HTML, which ends the paragraph and leaves its links as they are; a table stands alone."""
    assert re.findall(r"^ {0,3}<!--n:[^>]*-->(?!$).*", path.read_text(encoding="utf-8"), re.MULTILINE) == []


def test_every_named_number_is_quoted():
    quoted = {name for path in DOCUMENTS for name in names_in(path.read_text(encoding="utf-8"))}
    assert quoted == set(NUMBERS)


def test_a_number_that_differs_is_told_and_filled_in(tmp_path, capsys):
    document = tmp_path / "a.md"
    document.write_text("They agree on <!--n:truths agree-->71<!--/n--> of <!--n:suite-->73<!--/n--> stacks.\n")
    assert main(["--check"], [document]) == 1
    assert "truths agree is '71', in the tables '73'" in capsys.readouterr().out and "71" in document.read_text()
    assert main([], [document]) == 0
    assert document.read_text() == "They agree on <!--n:truths agree-->73<!--/n--> of <!--n:suite-->73<!--/n--> stacks.\n"
    assert main(["--check"], [document]) == 0


def test_a_table_that_changes_makes_documents_differ(monkeypatch):
    rows = [{**row, "albedo_worst": "0.02"} for row in named_numbers.rows("preset_errors")]
    text = filled("at most <!--n:presets energy-->?<!--/n-->")
    monkeypatch.setattr(named_numbers, "rows", lambda table: rows)
    assert differences(text) == ["presets energy is '1.0 %', in the tables '2.0 %'"]


@pytest.mark.parametrize("text, said", (
    ("<!--n:suit-->73<!--/n-->", "unknown number 'suit'; choose .*suite"),
    ("<!--n:suite-->73", "no other end"),
    ("73<!--/n-->", "no other end"),
    ("<!--n:suite-->73 <!--n:stacks-->83<!--/n-->", "no other end"),
))  # fmt: skip
def test_wrong_markers_are_refused(tmp_path, capsys, text, said):
    with pytest.raises(LaminaError, match=said):
        filled(text)
    document = tmp_path / "a.md"
    document.write_text(text)
    assert main([], [document]) == 2 and document.read_text() == text


def test_a_row_that_is_not_there_is_named():
    with pytest.raises(LookupError, match="figures/pareto.csv has no row with .*'method': 'baked_9'"):
        where("pareto", method="baked_9")


def test_how_numbers_are_written():
    assert (plain(0.645, 1), plain(52.3, 0), percent(0.0064, 2), percent(0.0, 1)) == (".6", "52", ".64 %", ".0 %")
    assert span([1.284, 1.028], 2) == "1.03 to 1.28"


def test_on_every_surface_a_bake_within_two_percent_costs_no_more_than_principled():
    assert max(within_two_percent()) <= 1.0
