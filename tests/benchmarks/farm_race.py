# SPDX-License-Identifier: GPL-3.0-or-later
"""Two workers of a farm side by side: two `openjd run` of disjoint ranges of tasks into one folder, killed (-9) and started again at random.

    farm_race.py [TABLE.csv [SECONDS]]     ten minutes, unless told otherwise

In the end both run to their end; then the pictures must equal an undisturbed run's, and none may have been made twice. Exit code 1 if not.
"""

import csv
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))
from support.commands import RUN
from support.wheel_blender import blender_program

from lamina.study.stamp import module_blender, stamp
from lamina.study.tables import write_table

SECONDS, SEED, FRAMES = 600.0, 11, 150
JOB = {"stacks": ["clean_copper", "frosted_metal"], "qualities": ["weidlich_wilkie"], "frames": f"1-{FRAMES}", "size": 48, "samples": 8}
COLUMNS = ("worker", "starts", "killed", "pictures")
TIMES = ("seconds",)


class Farm:
    """`openjd run` of a range of the bundle's pictures."""

    def __init__(self, template: Path, blender: str, pictures: str, output: Path):
        command = [Path(sys.executable).with_name("openjd"), "run", template, "--step", "Render", f"-pBlender={blender}", f"-pOutput={output}",
                   f"-pPictures={pictures}"]  # fmt: skip
        self._process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def is_alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        """The runner and all that it started."""
        found = [self._process.pid]
        for pid in found:
            told = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True).stdout.split()
            found += map(int, told)
        for pid in found:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self._process.wait()

    def wait(self) -> int:
        return self._process.wait()


def rows(folder: Path) -> list[dict]:
    with open(folder / "batch.csv", newline="") as file:
        return [{k: v for k, v in row.items() if k not in TIMES} for row in csv.DictReader(file)]


def main() -> int:
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else SECONDS
    moments = random.Random(SEED)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        job, calm, raced = home / "job.json", home / "calm", home / "raced"
        job.write_text(json.dumps(JOB))
        subprocess.run([*RUN, "batch", job, "-o", calm, "--no-sheet", "--processes", "1"], check=True, stderr=subprocess.DEVNULL)
        subprocess.run([*RUN, "farm", job, "-o", home / "bundle", "--chunk", "10"], check=True, stderr=subprocess.DEVNULL)
        blender, template = blender_program(home), home / "bundle" / "template.json"
        ranges = (f"0-{FRAMES - 1}", f"{FRAMES}-{2 * FRAMES - 1}")
        farms: list[Farm | None] = [None, None]
        starts, killed = [0, 0], [0, 0]
        first_seen: dict[str, tuple[int, int]] = {}
        twice: set[str] = set()

        def look() -> None:
            for file in raced.glob("[!.]*.exr"):
                about = file.stat()
                if first_seen.setdefault(file.name, (about.st_ino, about.st_mtime_ns)) != (about.st_ino, about.st_mtime_ns):
                    twice.add(file.name)

        ending = time.monotonic() + seconds
        while time.monotonic() < ending:
            for i in (0, 1):
                if farms[i] is None or not farms[i].is_alive():
                    farms[i] = Farm(template, blender, ranges[i], raced)
                    starts[i] += 1
            time.sleep(moments.uniform(0.5, 8.0))
            look()
            i = moments.randrange(2)
            if farms[i].is_alive():
                farms[i].kill()
                killed[i] += 1
                look()
        for i in (0, 1):
            farms[i].kill()
            farms[i] = Farm(template, blender, ranges[i], raced)
            starts[i] += 1
        codes = [farm.wait() for farm in farms]
        look()
        told = subprocess.run([*RUN, "batch", job, "-o", raced, "--no-sheet"], capture_output=True, text=True, check=True).stderr
        same = rows(raced) == rows(calm) and f"{2 * FRAMES} of them are there and whole" in told
        left = sorted(f.name for f in raced.iterdir() if f.suffix not in (".exr", ".csv") or f.name.startswith("."))
        count = len(rows(raced))
    is_good = same and not twice and not left and codes == [0, 0]
    verdict = (
        f"{count} pictures, {'all equal' if same else 'NOT equal'} to the undisturbed run's; made twice: {len(twice) or 'none'}; left over: {left or 'nothing'}"
    )
    print(verdict)
    made = [(i + 1, starts[i], killed[i], FRAMES) for i in (0, 1)]
    for row in made:
        print(*row)
    if len(sys.argv) > 1:
        write_table(Path(sys.argv[1]), (f"make farm-race: {verdict}", f"{seconds:g} s of kills"), COLUMNS, made, stamps=[stamp(module_blender())])
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
