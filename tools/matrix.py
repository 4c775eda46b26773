# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the tests on every supported Blender whose Python this machine has, and print a table.

    matrix.py [-o TABLE.txt] [PYTEST_ARGUMENT...]     such as tests/addon/test_batch_job.py; exit code 1 if any test failed

Without arguments the two halves of the suite run side by side, as `make test` has them, and with them what `make thorough` runs. What failed is named on stderr and in the file.
"""

import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from runpy import run_path

ROOT = Path(__file__).resolve().parent.parent
BLENDERS = ("4.5", "5.0", "5.1", "5.2", "5.3")
FIRST_HALF = (ROOT / "tests/first_half.txt").read_text(encoding="utf-8").split()
HALVES = (FIRST_HALF, ["tests", *(f"--ignore={file}" for file in FIRST_HALF)])


def run(blender: str, arguments: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """One row (Blender, its versions, passed, failed, skipped, minutes), and pytest's lines of what failed."""
    venv = ROOT / ".venv"
    is_own = any(venv.glob(f"lib/python*/site-packages/bpy-{blender}.*.dist-info"))  # that of `make test` will do
    venv = venv if is_own else ROOT / f".venv-{blender}"
    environment = os.environ | {"LAMINA_BPY": "" if is_own else blender}
    made = subprocess.run(["make", "--no-print-directory", str(venv.relative_to(ROOT) / "ready")], cwd=ROOT, env=environment, capture_output=True, text=True)
    if made.returncode:
        said = (made.stdout + made.stderr).strip().splitlines()
        why = next((line for line in said if line.startswith("lamina:")), said[-1] if said else "make failed")
        return (blender, f"not here: {why[:100]}", "", "", "", ""), []
    python = venv / "bin" / "python"
    versions = subprocess.run(
        [
            python,
            "-c",
            "import sys, numpy; from importlib.metadata import version; print('bpy', version('bpy') + ',', "
            "'Python', sys.version.split()[0] + ',', 'numpy', numpy.__version__)",
        ],
        capture_output=True,
        text=True,
    ).stdout.strip()
    began = time.monotonic()
    counts = dict.fromkeys(("passed", "failed", "skipped", "error"), 0)
    failed: list[str] = []
    # Blender-free tests in a process of their own
    parts = [arguments] if arguments else HALVES
    print(f"{blender}: {'; '.join(map(' '.join, parts))}", file=sys.stderr, flush=True)
    with ThreadPoolExecutor(len(parts)) as pool:
        for output in pool.map(lambda part: _pytest(python, part), parts):
            summary = output.strip().splitlines()[-1] if output.strip() else "1 error"
            for number, what in re.findall(r"(\d+) (passed|failed|skipped|error)", summary):
                counts[what] += int(number)
            failed += [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    print("".join(f"{line}\n" for line in failed), end="", file=sys.stderr, flush=True)
    minutes = f"{(time.monotonic() - began) / 60.0:.1f}"
    return (blender, versions, str(counts["passed"]), str(counts["failed"] + counts["error"]), str(counts["skipped"]), minutes), failed


def _pytest(python: Path, arguments: list[str]) -> str:
    return subprocess.run(
        [python, "-m", "pytest", "-q", "-rfE", *arguments], cwd=ROOT, env=os.environ | {"LAMINA_THOROUGH": "1"}, capture_output=True, text=True
    ).stdout


def main() -> int:
    arguments = sys.argv[1:]
    table = Path(arguments[1]) if arguments[:1] == ["-o"] else None
    rows, lines = [("Blender", "versions", "passed", "failed", "skipped", "minutes")], []
    for blender in BLENDERS:
        row, failed = run(blender, arguments[2:] if table else arguments)
        rows.append(row)
        lines += [f"{blender}: {line}" for line in failed]
    text = "".join(f"{name:8} {versions:44} " + " ".join(f"{n:>8}" for n in numbers) + "\n" for name, versions, *numbers in rows)
    print(text, end="")
    if table:
        stamp = run_path(str(ROOT / "study/stamp.py"))["stamp"]  # a plain Python runs this, without the package
        table.write_text(f"# make matrix; {stamp('Blender and numpy as below')}\n{text}" + "".join(f"{line}\n" for line in lines), encoding="utf-8")
    return 1 if any(row[3] not in ("", "0") for row in rows[1:]) else 0


if __name__ == "__main__":
    sys.exit(main())
