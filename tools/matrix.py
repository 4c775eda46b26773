# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the tests on every supported Blender whose Python this machine has, and print a table.

    matrix.py [PYTEST_ARGUMENT...]     such as tests/addon/test_batch_job.py; exit code 1 if any test failed
"""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLENDERS = ("4.5", "5.0", "5.2")


def run(blender: str, arguments: list[str]) -> tuple[str, ...]:
    """One row: Blender, its versions, passed, failed, skipped, minutes."""
    environment = os.environ | {"LAMINA_BPY": blender}
    venv = ROOT / f".venv-{blender}"
    made = subprocess.run(["make", "--no-print-directory", str(venv.relative_to(ROOT) / "ready")], cwd=ROOT, env=environment, capture_output=True, text=True)
    if made.returncode:
        said = (made.stdout + made.stderr).strip().splitlines()
        why = next((line for line in said if line.startswith("lamina:")), said[-1] if said else "make failed")
        return blender, f"not here: {why[:100]}", "", "", "", ""
    python = venv / "bin" / "python"
    versions = subprocess.run([python, "-c", "import sys, numpy; from importlib.metadata import version; print('bpy', version('bpy') + ',', "
                               "'Python', sys.version.split()[0] + ',', 'numpy', numpy.__version__)"], capture_output=True, text=True).stdout.strip()
    began = time.monotonic()
    counts = dict.fromkeys(("passed", "failed", "skipped", "error"), 0)
    # as make test does: Blender-free tests in a process of their own
    for part in [arguments] if arguments else [["tests/reference_py"], ["tests/addon", "tests/test_package.py", "tests/test_trust.py"]]:
        print(f"{blender}: {' '.join(part)}", file=sys.stderr, flush=True)
        told = subprocess.run([python, "-m", "pytest", "-q", "-rfE", *part], cwd=ROOT, capture_output=True, text=True).stdout
        summary = told.strip().splitlines()[-1] if told.strip() else "1 error"
        for number, what in re.findall(r"(\d+) (passed|failed|skipped|error)", summary):
            counts[what] += int(number)
        print("".join(f"{line}\n" for line in told.splitlines() if line.startswith(("FAILED", "ERROR"))), end="", file=sys.stderr, flush=True)
    minutes = f"{(time.monotonic() - began) / 60.0:.1f}"
    return blender, versions, str(counts["passed"]), str(counts["failed"] + counts["error"]), str(counts["skipped"]), minutes


def main() -> int:
    rows = [("Blender", "versions", "passed", "failed", "skipped", "minutes"), *(run(blender, sys.argv[1:]) for blender in BLENDERS)]
    for name, versions, *numbers in rows:
        print(f"{name:8} {versions:44} " + " ".join(f"{n:>8}" for n in numbers))
    return 1 if any(row[3] not in ("", "0") for row in rows[1:]) else 0


if __name__ == "__main__":
    sys.exit(main())
