# SPDX-License-Identifier: GPL-3.0-or-later
"""Every deliberate fault of `make faults` can still be put in, and the tests that must see it are there."""

from types import SimpleNamespace

import deliberate_faults
import pytest
from deliberate_faults import FAULTS, ROOT, Fault


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_can_be_put_in(fault):
    assert (ROOT / fault.file).read_text(encoding="utf-8").count(fault.old) == 1 and fault.old != fault.new
    for test in fault.tests:
        file, name = test.split("::")
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8")


def test_names_are_told_apart():
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A tree of one file, and tests by name that end as pytest would end on it with its text."""
    (tmp_path / "sum.py").write_text("a + b")

    def run(tests, tree):
        text = (tree / "sum.py").read_text()
        (name,) = tests
        return SimpleNamespace(returncode={"fails": int(text != "a + b"), "passes": 0, "is missing": 4}[name])

    monkeypatch.setattr(deliberate_faults, "run", run)
    return tmp_path


@pytest.mark.parametrize("tests, found", [
    (("fails",), "caught"),
    (("fails", "fails"), "caught"),
    (("passes",), "SURVIVED: passes passes"),
    (("fails", "passes"), "SURVIVED: passes passes"),
    (("is missing",), "SURVIVED: is missing does not run (pytest says 4)"),
])
def test_what_is_said_of_a_fault(tree, tests, found):
    assert deliberate_faults.verdict(Fault("a fault", "sum.py", "a + b", "a - b", tests), tree) == found
    assert (tree / "sum.py").read_text() == "a + b"


@pytest.mark.parametrize("file, old, times", [("sum.py", "a / b", 0), ("gone.py", "a + b", 0), ("sum.py", " ", 2)])
def test_text_that_is_gone_is_no_catch(tree, file, old, times):
    told = deliberate_faults.verdict(Fault("a fault", file, old, "b", ("fails",)), tree)
    assert told == f"{old!r} stands {times} times in {file}, not once"
