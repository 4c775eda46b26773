# SPDX-License-Identifier: GPL-3.0-or-later
import os
import subprocess
import sys
from pathlib import Path

SETUP = Path(__file__).parents[1] / "tools/setup.sh"


def test_a_link_is_refused_and_what_it_leads_to_stays(tmp_path):
    shared = tmp_path / "shared"
    shared.mkdir()
    (shared / "kept").write_text("yes")
    link = tmp_path / "venv"
    link.symlink_to(shared)
    result = subprocess.run(["bash", SETUP, link], capture_output=True, text=True, timeout=60)
    assert result.returncode == 1
    assert result.stderr.startswith(f"lamina: {link} is a link to {shared}") and result.stderr.count("\n") == 1
    assert (shared / "kept").read_text() == "yes"


def test_a_case_that_takes_long_runs_where_it_is_named():
    """And not with its file."""
    root = Path(__file__).resolve().parents[1]
    case = (root / "tests" / "thorough.txt").read_text(encoding="utf-8").splitlines()[0]
    environment = {name: value for name, value in os.environ.items() if name != "LAMINA_THOROUGH"}
    for named in (case, case.partition("::")[0]):
        command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", named]
        said = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, timeout=120).stdout
        assert (case in said.splitlines()) == (named == case), said
