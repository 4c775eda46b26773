# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables say where they come from, and who reads them does not meet it."""

import subprocess
import sys
from datetime import date

import numpy as np
import pytest

from lamina.study import stamp as module
from lamina.study.stamp import ROOT, is_stamp, stamp
from lamina.study.tables import FIGURES, read_heading, read_rows, read_table, write_table

TABLES = sorted([*FIGURES.glob("*.csv"), *FIGURES.glob("paper/*.csv")])


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A repository with one commit, in the place of this one."""
    (tmp_path / "figures").mkdir()
    (tmp_path / "code.py").write_text("1\n")
    (tmp_path / "figures" / "table.csv").write_text("1\n")
    name = ["-c", "user.name=t", "-c", "user.email=t@t", "-c", "commit.gpgsign=false"]
    for arguments in (["init", "-q"], ["add", "."], [*name, "commit", "-qm", "one"]):
        subprocess.run(["git", "-C", tmp_path, *arguments], check=True)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    return tmp_path


def test_a_stamp_names_commit_blender_numpy_and_date(checkout, monkeypatch):
    head = subprocess.run(["git", "-C", checkout, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    monkeypatch.delitem(sys.modules, "bpy", raising=False)
    assert stamp() == f"commit {head}; no Blender; numpy {np.__version__}; {date.today().isoformat()}"
    assert stamp("Blender 4.5.15") == f"commit {head}; Blender 4.5.15; {date.today().isoformat()}"


def test_changes_of_the_code_are_stated_and_those_of_the_tables_are_not(checkout, monkeypatch):
    clean = module.commit()
    (checkout / "figures" / "table.csv").write_text("2\n")
    assert module.commit() == clean
    (checkout / "new.py").write_text("1\n")
    assert module.commit() == f"{clean}+changes"
    (checkout / "new.py").unlink()
    (checkout / "code.py").write_text("2\n")
    assert module.commit() == f"{clean}+changes"


def test_outside_of_git_the_commit_is_unknown(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "ROOT", tmp_path)
    assert module.commit() == "unknown"
    monkeypatch.setenv("PATH", str(tmp_path))  # no git at all
    assert stamp().startswith("commit unknown; ")


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.stem)
def test_every_committed_table_is_stamped(path):
    heading, stamps = read_heading(path)
    assert heading[0].startswith(("lamina ", "make ")) and stamps


@pytest.mark.parametrize("name", ("fuzz.txt", "matrix.txt", "openjd.txt"))
def test_every_committed_text_is_stamped(name):
    command, *cells = (FIGURES / name).read_text().splitlines()[0].split("; ")
    assert command.startswith("# make ") and is_stamp(cells[0])


def test_a_table_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "table.csv"
    write_table(path, ("make it, now", "a note"), ("name", "value"), [("#1, a row", 0.5)])
    assert read_heading(path) == (["make it, now", "a note"], [stamp()])
    assert read_rows(path) == [["name", "value"], ["#1, a row", "0.5"]] and read_table(path) == [{"name": "#1, a row", "value": "0.5"}]
    write_table(path, ("make it",), ("name",), [], stamps=["commit a; x", "commit b; y"])
    assert read_heading(path) == (["make it"], ["commit a; x", "commit b; y"]) and read_table(path) == []


def test_this_checkout_is_the_root():
    assert (ROOT / "blender_manifest.toml").exists() and FIGURES.is_dir()
