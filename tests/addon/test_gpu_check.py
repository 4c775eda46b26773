# SPDX-License-Identifier: GPL-3.0-or-later
"""`make gpu`: its rows, here by the CPU alone, and its one line where there is no card."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "gpu.py"
pytestmark = pytest.mark.blender


@pytest.fixture
def check():
    spec = importlib.util.spec_from_file_location("gpu_check", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_rows_of_a_preset_say_how_far_each_branch_is_from_the_model(blender, check):
    script, nodes = check.rows_of("polished_chrome", ["CPU"], {})
    assert script[1:4] == ("CPU", "CPU", "osl") and nodes[3] == "nodes" and script[6] == nodes[6] == "yes"
    assert float(script[4]) < 1e-4 and float(script[5]) == 0.0


def test_without_a_card_it_says_so_in_one_line(blender, check, tmp_path):
    if check.cards():
        pytest.skip("this machine has a card")
    table = tmp_path / "gpu.csv"
    for devices, words in (((), "finds no OPTIX or CUDA or HIP or ONEAPI or METAL device"), (("GLIDE",), "unknown device GLIDE; choose OPTIX")):
        done = subprocess.run([sys.executable, SCRIPT, "--", table, *devices], capture_output=True, text=True, timeout=120)
        said = [line for line in done.stdout.splitlines() if line.startswith("make gpu")]
        assert done.returncode == 2 and len(said) == 1 and words in said[0] and not done.stderr.strip() and not table.exists()
