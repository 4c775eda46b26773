# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one fit in a process of its own, so that a window stays responsive and a cancelled fit is gone at once.

Reads a request as a line of JSON from stdin; prints lines "progress SHARE" and at last "result JSON" (see `outcome`, with its `lines`; those of `SENTENCES`
are packed) or "error JSON", a packed `Sentence`. `addon.jobs.process.worker` has the command.
"""

import json
import sys

from ..errors import LaminaError, Sentence

MODULE = "fit.fit_process"
SENTENCES = ("found", "warnings", "lines")
"""What of a result is lists of sentences for people."""


def request(file: str, layers: int | str, base: str, model: str, cloudy: bool = False) -> str:
    """What `main` reads."""
    return json.dumps({"file": file, "layers": layers, "base": base, "model": model, "cloudy": cloudy})


def main() -> None:
    """Serve one request."""
    from .layer_count import select
    from .outcome import lines, outcome
    from .readers.by_suffix import read

    data = json.loads(sys.stdin.readline())
    try:
        measurement = read(data["file"])
        selection = select(measurement, data["layers"], data["base"], data["model"], progress=_progress, cloudy=data["cloudy"])
        result = outcome(measurement, selection)
        result["lines"] = lines(result)
    except (LaminaError, MemoryError) as error:
        told = error.sentence if isinstance(error, LaminaError) else Sentence("not enough memory")
        print(f"error {json.dumps(told.packed())}", flush=True)
        return
    print(f"result {json.dumps(result | {name: [sentence.packed() for sentence in result[name]] for name in SENTENCES})}", flush=True)


def _progress(share: float) -> None:
    print(f"progress {share:.3f}", flush=True)
