# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch of 200 pictures is killed (-9) five times at random and finished; it must equal one that nobody disturbed.

    killed_batch.py [TABLE.csv]      about ten minutes of one core

Each kill comes after a random number of pictures and a random part of a second. Prints a row for each start and writes them as a table. Exit code 1 if anything differs.
"""

import csv
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from lamina.study.stamp import module_blender, stamp
from lamina.study.tables import write_table

RUN = [sys.executable, "-c", "from lamina.addon.cli.main import main; main()", "batch"]
KILLS, SEED = 5, 20
JOB = {
    "name": "Roughness of two metals", "stacks": ["clean_copper", "frosted_metal"], "qualities": ["weidlich_wilkie"],
    "sweeps": [{"parameter": "base.roughness", "from": 0.1, "to": 0.9, "steps": 10}],
    "views": [0, 40], "frames": "1-5", "samples": 4, "size": 32, "seed": 7,
}  # fmt: skip
TIMES = ("seconds",)


def rows(folder: Path) -> list[dict]:
    """The batch's table without what time it took."""
    with open(folder / "batch.csv", newline="") as file:
        return [{k: v for k, v in row.items() if k not in TIMES} for row in csv.DictReader(file)]


def pictures_in(folder: Path) -> int:
    return sum(not file.name.startswith(".") for file in folder.glob("*.exr"))


def main() -> int:
    table = [("start", "ended_after_s", "how", "pictures_there")]
    with tempfile.TemporaryDirectory() as home:
        job = Path(home, "job.json")
        job.write_text(json.dumps(JOB))
        calm, killed = Path(home, "calm"), Path(home, "killed")
        subprocess.run([*RUN, job, "-o", calm, "--processes", "1"], check=True, stderr=subprocess.DEVNULL)
        wanted = rows(calm)
        moments = random.Random(SEED)
        for start in range(1, KILLS + 2):
            began = time.monotonic()
            process = subprocess.Popen([*RUN, job, "-o", killed, "--processes", "2"], stderr=subprocess.DEVNULL)
            if start <= KILLS:
                wanted_now = pictures_in(killed) + moments.randint(1, 30)
                while process.poll() is None and pictures_in(killed) < wanted_now:
                    time.sleep(0.02)
                time.sleep(moments.uniform(0.0, 0.5))
                process.send_signal(signal.SIGKILL)
            how = process.wait()
            there = pictures_in(killed)
            table.append((start, f"{time.monotonic() - began:.1f}", "killed" if how < 0 else f"code {how}", there))
            print("  ".join(f"{v!s:>14}" for v in table[-1]), flush=True)
        same = rows(killed) == wanted
        left = sorted(f.name for f in killed.iterdir() if f.suffix not in (".exr", ".csv", ".png"))
        left += [f.name for f in killed.glob(".*.exr")]
    verdict = f"{len(wanted)} pictures, {'all equal' if same else 'NOT equal'} to the undisturbed run's; left over: {left or 'nothing'}"
    print(verdict)
    if len(sys.argv) > 1:
        columns, *starts = table
        write_table(Path(sys.argv[1]), (f"make killed-batch: {verdict}",), columns, starts, stamps=[stamp(module_blender())])
    return 0 if same and not left else 1


if __name__ == "__main__":
    sys.exit(main())
