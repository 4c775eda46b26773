# SPDX-License-Identifier: GPL-3.0-or-later
"""The field test: a Lamina material beside a Principled one through the rest of Blender.

    tests/field TABLE.csv [WORD ...]

Writes a row for each case into TABLE.csv and keeps there the rows of other Blenders; with words, prints the cases whose names
have one of them and writes nothing. Each group of cases runs in a process of its own, which a crash of Blender ends.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from lamina.study.stamp import stamp
from lamina.study.tables import read_heading, read_table, write_table

sys.path[0] = str(Path(__file__).resolve().parents[1])

LONGEST = 300  # seconds that a case may take
ROWS, NAMES = "--rows", "--names"
_SIDE_BY_SIDE = 2


def main() -> int:
    if sys.argv[1] in (ROWS, NAMES):
        return _in_blender(*sys.argv[1:])
    table, words, begin = Path(sys.argv[1]), sys.argv[2:], time.monotonic()
    # only a process of its own knows Blender's version, and so which cases there are
    listed = json.loads(_called(NAMES, table).splitlines()[-1])
    wanted = {group: [n for n in names if not words or any(w in n for w in words)] for group, names in listed["groups"].items()}
    with tempfile.TemporaryDirectory() as bakes, ThreadPoolExecutor(_SIDE_BY_SIDE) as pool:
        # nothing that other runs computed is used; each process has a core to itself
        os.environ |= {"LAMINA_CACHE": os.environ.get("LAMINA_CACHE", bakes), "OMP_NUM_THREADS": "1"}
        rows = [row for part in pool.map(_group, wanted.values()) for row in part]
    seconds = time.monotonic() - begin
    print(f"{len(rows)} cases in {seconds:.0f} s: {dict(Counter(r['verdict'] for r in rows))}")
    if not words:
        _write(table, rows, listed["blender"], listed["stamp"])
    return 0


def _called(*arguments) -> str:
    return subprocess.run([sys.executable, __file__, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True).stdout


def _group(names: list[str]) -> list[dict]:
    """The rows of some cases; one that ends Blender costs its own row alone."""
    rows: list[dict] = []
    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder, "rows")
        while left := names[len(rows) :]:
            told.write_text("")
            child = subprocess.run([sys.executable, __file__, ROWS, str(told), *left], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            lines = [json.loads(line) for line in told.read_text(encoding="utf-8").splitlines()]
            if not lines:
                raise SystemExit(f"the field test did not start:\n{child.stderr[-2000:]}")
            if "verdict" not in lines[-1]:
                reason = f"no end after {LONGEST} s" if child.returncode == -signal.SIGALRM else f"Blender ended with {child.returncode}"
                lines.append(lines[-1] | {"lamina": f"WRONG: {reason}", "principled": "", "verdict": "fails", "seconds": 0.0})
            done = [line for line in lines if "verdict" in line]
            for row in done:
                _say(row)
            rows += done
    return rows


def _in_blender(task: str, told: str, *names: str) -> int:
    from lamina.addon.blender.environment import ensure_osl_query_on_path

    ensure_osl_query_on_path()
    import lamina

    lamina.register()
    from field import CASES
    from field.case import blender

    if task == NAMES:
        groups: dict[str, list[str]] = {}
        for case in CASES.values():
            if case.is_here():
                groups.setdefault(case.group, []).append(case.name)
        print(json.dumps({"blender": blender(), "stamp": stamp(), "groups": groups}), flush=True)
        os._exit(0)
    with open(told, "a", encoding="utf-8", buffering=1) as file:
        for case in map(CASES.__getitem__, names):
            file.write(json.dumps({"case": case.name, "blender": blender(), "note": case.told}) + "\n")
            signal.alarm(LONGEST)
            begin = time.process_time()
            row = case.run()
            signal.alarm(0)
            file.write(json.dumps(asdict(row) | {"seconds": time.process_time() - begin}) + "\n")
    os._exit(0)  # Blender 4.5's wheel can hang for ever in its exit handlers


def _say(row: dict) -> None:
    told = f": {row['lamina']} | {row['principled']}" if row["verdict"] != "ok" else ""
    print(f"{row['verdict']:>5} {row['seconds']:5.1f} s  {row['case']}{told}", flush=True)


def _write(table: Path, rows: list[dict], blender: str, made_by: str) -> None:
    """Put the rows in the table, in place of what this Blender had there; each Blender has its stamp."""
    columns = ("case", "blender", "lamina", "principled", "verdict", "note")
    kept, stamps = [], []
    if table.exists():
        kept = [row for row in read_table(table) if row["blender"] != blender]
        stamps = [s for s in read_heading(table)[1] if f"Blender {blender}." not in s]
    whole = sorted(kept + rows, key=lambda r: tuple(map(int, r["blender"].split("."))))
    heading = ("make field: a Lamina material beside a Principled one; got and expected values",)
    write_table(table, heading, columns, [[row[c] for c in columns] for row in whole], stamps=sorted([*stamps, made_by]))


if __name__ == "__main__":
    sys.exit(main())
