# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lobe sets in a process of its own, so that a window stays responsive and a cancelled bake is gone at once.

Reads requests from stdin, a line of JSON each; prints for each lines "progress SHARE" and at last "result JSON" or "error JSON", a packed
`Sentence`. Stacks that are alike in part share what is computed; who asks keeps the result. The process is started by `command` and needs nothing but this package and numpy.
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from ...errors import LaminaError
from ...material.place import Place
from ...material.stack import Stack

MODULE = "lobes.methods.bake_process"
_ROOT = Path(__file__).resolve().parents[3]
# A bake's matrices are small, and the window needs the other cores. Where memory is glibc's, it is not given back between two of numpy's
# steps, which costs a fifteenth of a bake's time.
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MALLOC_MMAP_THRESHOLD_": f"{64 << 20}", "MALLOC_TRIM_THRESHOLD_": f"{256 << 20}",
}  # fmt: skip
# The package may be installed under any name; here it is imported by its place.
_START = """
import importlib, importlib.util, sys
root = sys.argv[1]
spec = importlib.util.spec_from_file_location("lamina", root + "/__init__.py", submodule_search_locations=[root])
sys.modules["lamina"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["lamina"])
importlib.import_module("lamina.reference_py." + sys.argv[2]).main()
"""


def command(python: str, module: str) -> list[str]:
    """The command line of a worker, a module of reference_py with a function `main`."""
    return [python, "-I", "-c", _START, str(_ROOT), module]


def request(stack: Stack, method: str, live: Sequence[Place], tolerance: float) -> str:
    """A line that `main` reads."""
    return json.dumps({"stack": stack.to_dict(), "method": method, "live": [place.pair() for place in live], "tolerance": tolerance})


def main() -> None:
    """Serve requests until there are no more."""
    for line in sys.stdin:
        serve(json.loads(line))


def serve(data: dict) -> None:
    """Answer one request."""
    from . import packed

    live = tuple(Place.of_pair(*pair) for pair in data["live"])
    try:
        result = packed(Stack.from_dict(data["stack"]), data["method"], live=live, tolerance=data["tolerance"], progress=_progress)
    except LaminaError as error:
        print(f"error {json.dumps(error.sentence.packed())}", flush=True)
        return
    print(f"result {json.dumps(result)}", flush=True)


def _progress(share: float) -> None:
    print(f"progress {share:.3f}", flush=True)
