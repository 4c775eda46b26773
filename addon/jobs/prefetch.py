# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of many stacks at once, before something without a window needs them one after the other."""

import os
import time
from collections.abc import Callable, Iterable, Iterator

from ...reference_py.errors import Sentence
from ...reference_py.lobes.methods import bake_process
from ..blender.user_folders import cache_folder
from ..material.state import Wanted
from .process import Process, worker

# a process holds up to 270 MB
MOST = 8
_POLL_SECONDS = 0.05


class Baker(Process):
    """A process that takes one after the other of what is left; `made` are what it has baked, with their results."""

    def __init__(self, left: Iterator[Wanted]):
        self.made: list[tuple[Wanted, list[dict]]] = []
        super().__init__(Sentence("a bake"), worker(bake_process.MODULE), self._requests_for(left))

    def _requests_for(self, left: Iterator[Wanted]) -> Iterator[str]:
        for wanted in left:
            self.result = None
            yield wanted.request(cache_folder())
            if self.result is not None:
                self.made.append((wanted, self.result))


def prefetch(wanted: Iterable[Wanted], report: Callable[[str], None]) -> None:
    """Compute what is wanted and not yet known in as many processes as there are cores: starting one costs as much as a small bake.

    A bake that fails is left to whoever asks for it next, who then learns why.
    """
    unknown = {w.key: w for w in wanted if not w.is_cached()}
    if len(unknown) < 2:
        return
    left, bakers, done = iter(unknown.values()), [], 0
    try:
        for _ in range(min(os.cpu_count() or 1, MOST, len(unknown))):
            bakers.append(Baker(left))
        is_done = False
        while not is_done:
            time.sleep(_POLL_SECONDS)
            is_done = all(baker.is_done for baker in bakers)
            for baker in bakers:
                while baker.made:
                    one, result = baker.made.pop(0)
                    one.put(one.key, result)
                    done += 1
                    report(f"{done} of {len(unknown)} bakes are done")
    finally:
        for baker in bakers:
            baker.cancel()
