# SPDX-License-Identifier: GPL-3.0-or-later
"""A process that renders items for a batch, and the batch's end of it.

Lines of JSON go both ways: in come items as `Item.to_dict` gives them, out goes {"ready": true} and then, for each
item, {"id": ...} with "error" if it failed, with "scene" if so will all items of its scene, else with "notices" of what its scene shows
wrong and its "megabytes". {"reads": BLEND, "frames": [...]} asks for the "files" that the file reads and what is "missing" at these frames, or why it
cannot be opened, "error". At the end of the input it leaves at once.
"""

import json
import os
import queue
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

from ...reference_py.errors import LaminaError
from .items import Item

_ROOT = Path(__file__).resolve().parents[2]
# Outside of Blender the package may be installed under any name; it is imported by its place.
_START = """
import importlib.util, sys
root = sys.argv[1]
spec = importlib.util.spec_from_file_location("lamina", root + "/__init__.py", submodule_search_locations=[root])
sys.modules["lamina"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["lamina"])
from lamina.addon.cli.main import run
import os
code = run(["batch", "--worker", *sys.argv[2:]])
os._exit(code)
"""


def command(folder: Path, threads: int) -> list[str]:
    """The command line of a worker: this Blender again, or this Python with its bpy."""
    import bpy

    ours = ["-o", str(folder), "--threads", str(threads)]
    if bpy.app.module:
        return [sys.executable, "-c", _START, str(_ROOT), *ours]
    return [bpy.app.binary_path, "-b", "--command", "lamina", "batch", "--worker", *ours]


class Answer(NamedTuple):
    """Why an item failed, or an empty text; whether all items of its scene will; what its scene shows wrong, a sentence each; the process's memory, 0 if unknown."""

    error: str
    is_scene: bool = False
    notices: tuple[str, ...] = ()
    megabytes: float = 0.0


class Worker:
    """A worker process as seen by the batch. It ends with `stop`, and when the batch is gone."""

    def __init__(self, folder: Path, work: Path, threads: int):
        self._log = open(work / f"worker-{os.urandom(4).hex()}.log", "w+b")
        # a session of its own: Ctrl-C in a terminal is for the batch, which then ends the worker
        # TMPDIR: what Blender leaves behind when it is killed is cleared away with the folder
        self._process = subprocess.Popen(
            command(folder, threads), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, text=True, start_new_session=True,
            env=os.environ | {"TMPDIR": str(work), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip

    def wait_until_ready(self) -> None:
        """Raises LaminaError when the process ends instead."""
        self._await("did not start")

    def render(self, item: Item, limit: float | None) -> Answer:
        """Render an item.

        Raises LaminaError when the process ends instead, which it does when it has not answered after `limit` seconds.
        """
        watch = threading.Timer(limit or 0.0, self._process.kill)
        watch.daemon = True
        started = time.monotonic()
        if limit:
            watch.start()
        try:
            answer = self.ask(item.to_dict())
            return Answer(answer.get("error", ""), "scene" in answer, tuple(answer.get("notices", ())), answer.get("megabytes", 0.0))
        except LaminaError:
            if limit and time.monotonic() - started >= limit:
                raise LaminaError(f"took longer than the job's time_limit of {limit:g} s") from None
            raise
        finally:
            watch.cancel()

    def ask(self, question: dict) -> dict:
        """The answer to a question. Raises LaminaError when the process ends instead."""
        try:
            self._process.stdin.write(json.dumps(question) + "\n")
            self._process.stdin.flush()
        except OSError:
            pass  # it ended; the answer says why
        return self._await("ended")

    def _await(self, what: str) -> dict:
        for line in self._process.stdout:
            if line.startswith("{"):  # Blender talks too
                return json.loads(line)
        code = self._process.wait()
        how = f"killed by signal {-code}" if code < 0 else f"code {code}"
        raise LaminaError(f"its process {what} ({how}){self._last_words()}")

    def _last_words(self) -> str:
        self._log.seek(0)
        lines = [line.strip() for line in self._log.read()[-4000:].decode("utf-8", "replace").splitlines() if line.strip()]
        return f": {lines[-1][:300]}" if lines else ""

    def stop(self) -> None:
        self._process.kill()
        self._process.wait()


def serve(folder: Path, threads: int) -> None:
    """Be a worker."""
    from ..session import blender
    from .scene import SceneError, Stage

    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    items: queue.SimpleQueue = queue.SimpleQueue()

    def receive() -> None:
        for line in sys.stdin:
            items.put(line)
        os._exit(0)  # the batch is done or gone: whatever renders is for nobody

    def answer(data: dict) -> None:
        channel.write("\n" + json.dumps(data) + "\n")
        channel.flush()

    with blender(lambda text: None):
        stage = Stage(threads)
        threading.Thread(target=receive, daemon=True).start()
        answer({"ready": True})
        while True:
            question = json.loads(items.get())
            if blend := question.get("reads"):
                answer(_reads(blend, question["frames"]))
                continue
            item = Item.from_dict(question)
            try:
                stage.render(item, folder)
                answer({"id": item.id, "notices": stage.notices, "megabytes": memory()})
            except LaminaError as error:
                answer({"id": item.id, "error": " ".join(str(error).split())} | ({"scene": True} if isinstance(error, SceneError) else {}))
            except MemoryError:
                answer({"id": item.id, "error": "out of memory"})


def memory() -> float:
    """What this process holds in memory, in MB; 0 where the system does not say."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except OSError:
        pass
    try:
        import resource
    except ImportError:  # Windows
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6  # macOS, in bytes, and the most that it was


def _reads(blend: str, frames: list[int]) -> dict:
    from ..blender.blend_files import open_file
    from ..blender.dependencies import files_read, missing

    try:
        open_file(blend)
    except LaminaError as error:
        return {"error": str(error)}
    return {"files": files_read(), "missing": missing(frames)}
