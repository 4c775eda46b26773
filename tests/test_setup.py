# SPDX-License-Identifier: GPL-3.0-or-later
import subprocess
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
