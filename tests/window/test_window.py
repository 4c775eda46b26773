# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Blender, named by LAMINA_BLENDER, with a window and a mouse: see window.py, which does it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from driver import Skip, needed

HERE = Path(__file__).parent
ROOT = HERE.parent.parent


def test_preset_add_move_undo_with_a_mouse(tmp_path):
    try:
        needed()
    except Skip as reason:
        pytest.skip(str(reason))
    pytest.importorskip("bpy")  # whose build tool makes the zip
    subprocess.run([sys.executable, ROOT / "tools" / "extension.py", "build", tmp_path], check=True, capture_output=True)
    archive = next(tmp_path.glob("*.zip"))
    done = subprocess.run([sys.executable, HERE / "window.py", archive, tmp_path / "pictures"], capture_output=True, text=True, timeout=1500)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(("blender", "said"), [("", "LAMINA_BLENDER names no Blender"), ("/no/blender", "which is no program")])
def test_without_a_blender_it_says_so_and_skips(tmp_path, blender, said):
    environment = {**os.environ, "LAMINA_BLENDER": blender}
    done = subprocess.run([sys.executable, HERE / "window.py", "no.zip", tmp_path / "p"], env=environment, capture_output=True, text=True)
    assert done.returncode == 77 and said in done.stdout and not (tmp_path / "p").exists()
