# SPDX-License-Identifier: GPL-3.0-or-later
"""What a farm's task costs beside its pictures: `openjd run` of one bundle, with 1, 2, 4 and 8 pictures per task.

    farm_tasks.py [TABLE.csv LOG.txt]

Prints and writes a row for each, and what `openjd` says of two tasks. Seconds are of the clock, on one machine, where tasks run one after the other. The program
`blender` is what LAMINA_BLENDER names, else the bpy wheel in its clothes.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))
from support.commands import RUN
from support.wheel_blender import blender_program

from lamina.study.stamp import module_blender, stamp
from lamina.study.tables import write_table

PICTURES = 8
JOB = {"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "frames": f"1-{PICTURES}", "size": 32, "samples": 4}


def _version_of(blender: str) -> str:
    return subprocess.run([blender, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]


def main() -> int:
    rows = [("pictures_per_task", "tasks", "seconds", "seconds_per_task", "seconds_per_picture")]
    with tempfile.TemporaryDirectory() as home:
        job = Path(home, "job.json")
        job.write_text(json.dumps(JOB))
        subprocess.run([*RUN, "farm", job, "-o", f"{home}/bundle"], check=True, stderr=subprocess.DEVNULL)
        named = os.environ.get("LAMINA_BLENDER")
        blender = named or blender_program(Path(home))
        made_by = stamp(_version_of(named) if named else module_blender())
        openjd = Path(sys.executable).with_name("openjd")
        for chunk in (1, 2, 4, 8):
            told = subprocess.run([openjd, "run", f"{home}/bundle/template.json", "--step", "Render", f"-pBlender={blender}", f"-pPicturesPerTask={chunk}",
                                   f"-pOutput={home}/out{chunk}"], check=True, capture_output=True, text=True).stdout  # fmt: skip
            if chunk == PICTURES // 2 and len(sys.argv) > 2:
                paths = {home: "/job", r"/\S*OpenJD/\w+": "/tmp/OpenJD/SESSION"}
                told_briefly = re.sub(r"^.*\t(Fra:.*|Saved: .*|Time: .*|)\n", "", told, flags=re.MULTILINE)  # without Blender's every step
                log = f"# make farm-tasks; {made_by}\n$ openjd run /job/bundle/template.json --step Render -p Blender=blender -p PicturesPerTask={chunk} -p Output=/job/out{chunk}\n{told_briefly}"
                for path, shown in paths.items():
                    log = re.sub(path, shown, log)
                Path(sys.argv[2]).write_text(log, encoding="utf-8")
            seconds, tasks = float(re.search(r"Duration: ([\d.]+)", told)[1]), int(re.search(r"Chunks run: (\d+)", told)[1])
            rows.append((chunk, tasks, f"{seconds:.1f}", f"{seconds / tasks:.2f}", f"{seconds / PICTURES:.2f}"))
            print("  ".join(f"{v!s:>18}" for v in rows[-1]), flush=True)
    if len(sys.argv) > 1:
        heading = ("make farm-tasks: openjd run, 8 pictures of 32 pixels and 4 samples of one material",)
        write_table(Path(sys.argv[1]), heading, rows[0], rows[1:], stamps=[made_by])
    return 0


if __name__ == "__main__":
    sys.exit(main())
