# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as productions have them through batch, farm, apply, saves and a start of Blender, by a former commit's code and by the present one's.

    production.py [TABLE.csv [COMMIT]]     about ten minutes
    production.py first_save [COMMIT]      that part alone, printed: about two minutes

The scene is `support/production_scene`, made by the present code. CPU times are of one process on one core, the least of three.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))
from support.wheel_blender import blender_program

from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.study.stamp import ROOT, module_blender, stamp
from lamina.study.tables import write_table

FORMER = "2f71ff0"
PATIENCE = 90
COLUMNS = ("item", "what", "before", "now")
JOB = {"name": "Kitchen", "stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "size": 32, "samples": 2}
BLEND = "shots/Küche 厨房.blend"
_RUN = "from lamina.addon.cli.main import main; main()"
_BUILD = """
import sys
from pathlib import Path
import bpy, lamina
sys.path.append(sys.argv[1])
from lamina.addon.blender.environment import ensure_osl_query_on_path
ensure_osl_query_on_path()
lamina.register()
from support import production_scene
production_scene.build(Path(sys.argv[2]), *sys.argv[3:])
"""
# A first save of a scene whose bakes nobody made yet: what the values ask for is made then. Last are told seconds of CPU in Blender's own
# process, in those that bake, and of the clock: of the start of Blender and the making of the materials, and of the save.
_SAVE = """
import os, sys, time

def spent():
    used = os.times()
    return used.user + used.system, used.children_user + used.children_system, time.perf_counter()

begun = 0.0, 0.0, time.perf_counter()
import bpy, lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
ensure_osl_query_on_path()
lamina.register()
from lamina.addon.material import material
from lamina.reference_py.material import presets
for name in [n for n in presets.names() if presets.load(n).layers][:14]:
    made = bpy.data.materials.new(name)
    made.use_fake_user = True
    material.apply_stack(made, presets.load(name), "auto", "auto")
ready = spent()
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
saved = spent()
seconds = [after - before for pair in ((begun, ready), (ready, saved)) for before, after in zip(*pair)]
sys.stdout.write("\\n" + " ".join(map(str, seconds)))
sys.stdout.flush()
os._exit(0)
"""
_START = "import sys, os, bpy\nif len(sys.argv) > 1:\n    import lamina\n    lamina.register()\nsys.stdout.write(f'modules {len(sys.modules)}')\nsys.stdout.flush()\nos._exit(0)"


class Tree:
    """The code under folder/lamina, and a scene of its own to work on."""

    def __init__(self, folder: Path, scene: Path, blender: str):
        self.folder, self.scene, self.blender = folder, scene, blender
        # modules are compiled once, as where Lamina is installed
        own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"} | {"PYTHONPYCACHEPREFIX": str(folder / "compiled")}
        self.environment = own | {"PYTHONPATH": str(folder), "LAMINA_CACHE": str(folder / "cache"), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

    def run(self, *arguments, **variables) -> subprocess.CompletedProcess:
        command = [sys.executable, "-c", _RUN, *map(str, arguments)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment | variables)
        try:
            told = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            workers = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
            for pid in (process.pid, *map(int, workers)):
                os.kill(pid, signal.SIGKILL)
            told = (process.communicate()[0], f"hangs, ended after {PATIENCE} s")
        return subprocess.CompletedProcess(command, process.returncode, *told)

    def fresh(self, name: str, **keys) -> tuple[Path, Path]:
        """A copy of the scene with a job file; and the folder for its output."""
        home = self.folder / name
        shutil.copytree(self.scene, home)
        (home / "job.json").write_text(json.dumps(JOB | {"scenes": [{"blend": BLEND, "object": "Cup"}]} | keys))
        return home, self.folder / f"{name} out"

    def cpu(self, *command, **variables) -> tuple[float, str]:
        """Seconds of a command and its children, and what it printed."""
        process = subprocess.Popen(
            [sys.executable, *map(str, command)], env=self.environment | variables, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        told = process.stdout.read()
        _, _, usage = os.wait4(process.pid, 0)
        return usage.ru_utime + usage.ru_stime, told


def last(ran: subprocess.CompletedProcess) -> str:
    """The exit code, and what was said last."""
    lines = [line for line in (ran.stderr + "\n" + ran.stdout).splitlines() if line.strip()]
    said = next((line for line in reversed(ran.stderr.splitlines()) if line.strip()), lines[-1] if lines else "")
    trace = "a traceback; " if "Traceback" in ran.stderr else ""
    return f"code {ran.returncode}: {trace}{said if len(said) < 300 else said[:297] + '...'}"


CHANGED = {
    "a library": "lib/set.blend", "a library's library": "lib/parts.blend", "a library's picture": "tex/lid.png", "a picture": "tex/wood 漆.png",
    "a UDIM tile": "tex/tiles.1002.png", "a picture of a sequence": "tex/dirt_0002.png", "a font": "fonts/Schrift.woff2", "a sound": "tex/hum.wav",
}  # fmt: skip


def depends(tree: Tree) -> Iterator[tuple]:
    home, out = tree.fresh("changes")
    tree.run("batch", home / "job.json", "-o", out, "--no-sheet")
    for name, file in CHANGED.items():
        path = home / file
        before = path.read_bytes()
        path.write_bytes(before + b"\0")
        ran = tree.run("batch", home / "job.json", "-o", out, "--no-sheet")
        path.write_bytes(before)
        yield 1, f"{name} changed, batch again", "taken for done" if "1 of them are there and whole" in ran.stderr else last(ran)[:60]


def missing(tree: Tree) -> Iterator[tuple]:
    for name, file in (("library", "lib/set.blend"), ("texture", "tex/wood 漆.png")):
        home, out = tree.fresh(f"without {name}")
        (home / file).unlink()
        yield 2, f"batch without a {name}", last(tree.run("batch", home / "job.json", "-o", out, "--no-sheet"))
        yield (
            2,
            f"apply without a {name}",
            last(tree.run("apply", home / BLEND, "--stack", "clean_copper", "--object", "Cup", "-o", home / "new.blend", "--tier", "weidlich_wilkie")),
        )
    home, out = tree.fresh("bundled")
    tree.run("farm", home / "job.json", "-o", home / "bundle")
    elsewhere = tree.folder / "elsewhere"
    shutil.copytree(home / "bundle", elsewhere)
    hidden = home.rename(home.with_name("gone"))
    files = elsewhere / "files"
    ran = subprocess.run([tree.blender, "-b", "--python", files / "render_items.py", "--", "--items", files / "items.json", "--range", "0", "--output", out],
                         capture_output=True, text=True, env=tree.environment)  # fmt: skip
    hidden.rename(home)
    farmed = f"code {ran.returncode}"
    verified = tree.run("batch", home / "job.json", "-o", out, "--no-sheet").stderr
    tree.run("batch", home / "job.json", "-o", f"{out} here", "--no-sheet")
    yield 2, "a farm's folder copied elsewhere, task and batch", f"{farmed}; {'taken for done' if '1 of them are there and whole' in verified else 'not taken'}"
    yield 2, "its pixels beside the batch's own", _apart(Path(f"{out} here"), out)


def _apart(first: Path, second: Path) -> str:
    import numpy as np

    from lamina.addon.blender import oiio

    names = [f.name for f in first.glob("*.exr")]
    if not names or not all((second / n).exists() for n in names):
        return "no picture"
    apart = max(np.abs(oiio.read(first / n)[0][c] - oiio.read(second / n)[0][c]).max() for n in names for c in "RGB")
    return f"off by {apart:.3g}"


def linked(tree: Tree) -> Iterator[tuple]:
    home, _ = tree.fresh("linked")
    for name in ("Linked Cup", "Half Cup", "Twin A", "cup", "Prop 7"):
        ran = tree.run("apply", home / BLEND, "--stack", "clean_copper", "--object", name, "-o", home / "new.blend", "--tier", "weidlich_wilkie")
        yield 3 if "C" in name else 6, f"apply to {name!r}", last(ran)
    for name in ("Linked Cup", "Half Cup"):
        (home / "job.json").write_text(json.dumps(JOB | {"scenes": [{"blend": BLEND, "object": name}]}))
        yield 3, f"farm of {name!r}", last(tree.run("farm", home / "job.json", "-o", home / f"bundle {name}"))
        yield 3, f"batch of {name!r}", last(tree.run("batch", home / "job.json", "-o", home / f"out {name}", "--no-sheet"))


def told(tree: Tree) -> Iterator[tuple]:
    from lamina.addon.blender import oiio

    home, out = tree.fresh("told")
    tree.run("batch", home / "job.json", "-o", out, "--no-sheet")
    picture = next(out.glob("*.exr"))
    yield 5, "texts in a picture's header", ", ".join(sorted(oiio.read(picture)[1]))
    yield 5, "lamina info", last(tree.run("info", picture))


def faults(tree: Tree) -> Iterator[tuple]:
    home, out = tree.fresh("faults", samples=20000, size=256)
    process = subprocess.Popen([sys.executable, "-c", _RUN, "batch", home / "job.json", "-o", out], stderr=subprocess.PIPE, text=True, env=tree.environment)
    for line in process.stderr:
        if "0 of them" in line:
            break
    time.sleep(4.0)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate()
    left = sorted(f.name for f in out.iterdir())
    yield 7, "SIGTERM to a batch", f"code {process.returncode}: {(said.strip().splitlines() or [''])[-1]}; left: {', '.join(left) or 'nothing'}"
    (home / "no folder").write_text("")
    ran = tree.run("apply", home / BLEND, "--stack", "clean_copper", "--object", "Cup", "-o", home / "new.blend", LAMINA_CACHE=str(home / "no folder"))
    yield 7, "apply with an unwritable cache", "said" if "cannot be kept" in ran.stderr else "not said"
    yield 8, "lamina cache", last(tree.run("cache"))


def cost(tree: Tree) -> Iterator[tuple]:
    bare, with_it = ([tree.cpu("-c", _START, *arguments) for _ in range(3)] for arguments in ((), ("lamina",)))
    counts = [int(runs[0][1].rpartition("modules ")[2]) for runs in (bare, with_it)]
    yield 9, "CPU of a start over one without, ms", f"{1000 * (min(s for s, _ in with_it) - min(s for s, _ in bare)):.0f}"
    yield 9, "modules over a start without", counts[1] - counts[0]
    yield from first_save(tree)


def first_save(tree: Tree) -> Iterator[tuple]:
    # the first of two compiles modules, numpy's among them
    _, told = min(tree.cpu("-c", _SAVE, tree.folder / "saved.blend", LAMINA_CACHE=str(tree.folder / f"saved {i}")) for i in range(2))
    own_before, bakes_before, _, own, bakes, clock = map(float, told.rpartition("\n")[2].split())
    yield 9, "CPU of Blender's start and of making 14 materials, s", f"{own_before + bakes_before:.1f}"
    whole = "of a first save of 14 bakes"
    for what, seconds in (("CPU", own + bakes), ("CPU of Blender's own process", own), ("CPU of processes that bake", bakes), ("time", clock)):
        yield 9, f"{what} {whole}, s", f"{seconds:.1f}"


def rows(tree: Tree, parts: tuple) -> dict[tuple, str]:
    found = {}
    for part in parts:
        for item, what, value in part(tree):
            found[item, what] = str(value).replace(str(tree.folder), "")
            print(tree.folder.name, item, what, found[item, what], sep=" | ", flush=True)
    return found


def main() -> None:
    ensure_osl_query_on_path()
    target, former = sys.argv[1] if len(sys.argv) > 1 else "", sys.argv[2] if len(sys.argv) > 2 else FORMER
    parts = (first_save,) if target == first_save.__name__ else (depends, missing, linked, told, faults, cost)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        scene, blender = home / "scene", blender_program(home)
        trees = {"now": home / "now", "before": home / "before"}
        trees["now"].mkdir()
        (trees["now"] / "lamina").symlink_to(ROOT)
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", ROOT, trees["before"] / "lamina"], check=True)
        subprocess.run(["git", "-C", trees["before"] / "lamina", "checkout", "--quiet", former], check=True)
        subprocess.run([sys.executable, "-c", _BUILD, ROOT / "tests", scene, "weidlich_wilkie", "auto"], check=True, stdout=subprocess.DEVNULL)
        size = sum(f.stat().st_size for f in scene.rglob("*") if f.suffix != ".blend1")
        # what is timed alone has the machine for itself
        with ThreadPoolExecutor(1 if parts == (first_save,) else len(trees)) as both:
            running = {name: both.submit(rows, Tree(tree, scene, blender), parts) for name, tree in trees.items()}
            values = {name: each.result() for name, each in running.items()}
    if target and cost in parts:
        made = [(*key, values["before"].get(key, "-"), now) for key, now in values["now"].items()]
        heading = ("make production", f"beside {former}", f"a scene of {size / 1e6:.2f} MB")
        write_table(Path(target), heading, COLUMNS, made, print, stamps=[stamp(module_blender())])


if __name__ == "__main__":
    main()
