# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line in a process of its own, checked as its user sees it."""

import subprocess
import sys

RUN = [sys.executable, "-c", "from lamina.addon.cli.main import main; main()"]


def lamina(*arguments, code=0, **options):
    """Run the command; returns (stdout, stderr) after checking the exit code."""
    result = subprocess.run([*RUN, *map(str, arguments)], capture_output=True, text=True, timeout=300, **options)
    assert result.returncode == code, result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    return result.stdout, result.stderr
