# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of many stacks at once, before something without a window needs them one after the other."""

import os
import time
from collections.abc import Callable, Iterable

from ..material.state import Wanted
from .bakes import Bake

# a bake holds up to 270 MB
MOST = 8
_POLL_SECONDS = 0.05


def prefetch(wanted: Iterable[Wanted], report: Callable[[str], None]) -> None:
    """Compute what is wanted and not yet known, each in a process of its own, as many at a time as there are cores.

    A bake that fails is left to whoever asks for it next, who then learns why.
    """
    left = {w.key: w for w in wanted if not w.is_cached()}
    total, running = len(left), []
    if total < 2:
        return
    try:
        while left or running:
            while left and len(running) < min(os.cpu_count() or 1, MOST):
                running.append(Bake(left.pop(next(iter(left)))))
            time.sleep(_POLL_SECONDS)
            for bake in [bake for bake in running if bake.is_done]:
                running.remove(bake)
                if bake.result is not None:
                    bake.wanted.put(bake.key, bake.result)
                report(f"{total - len(left) - len(running)} of {total} bakes are done")
    finally:
        for bake in running:
            bake.cancel()
