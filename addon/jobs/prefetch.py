# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of many stacks at once, and what exporters find of them, before something without a window needs them one after the other."""

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence

from ...reference_py.errors import Sentence
from ...reference_py.exchange import conversion_process
from ...reference_py.lobes.cache import stack_key
from ..material.hand_over import WantedHandOver
from ..material.state import Wanted
from .process import Process, worker

# a process holds up to 270 MB
MOST = 8
_POLL_SECONDS = 0.05


class Baker(Process):
    """A process that takes one after the other of the groups that are left; `made` is what it has computed, with the results."""

    def __init__(self, left: Iterator[Sequence[Wanted | WantedHandOver]]):
        self.made: list[tuple[Wanted | WantedHandOver, list[dict] | dict]] = []
        super().__init__(Sentence("a bake"), worker(conversion_process.MODULE), self._requests_for(left))

    def _requests_for(self, left: Iterator[Sequence[Wanted | WantedHandOver]]) -> Iterator[str]:
        for group in left:
            for wanted in group:
                self.result = None
                yield wanted.request()
                if self.result is not None:
                    self.made.append((wanted, self.result))


def prefetch(wanted: Iterable[Wanted], hand_overs: Iterable[WantedHandOver], report: Callable[[str], None]) -> None:
    """Compute what is wanted and not yet known in as many processes as there are cores: starting one costs as much as a small bake.

    What is wanted of one stack is left to one process, which computes their truth once. What fails is left to whoever asks for it
    next, who then learns why.
    """
    unknown = {w.key: w for w in wanted if not w.is_cached()}
    if len(unknown) < 2:
        return
    groups: dict[str, list[Wanted | WantedHandOver]] = {}
    for bake in unknown.values():
        groups.setdefault(stack_key(bake.stack), []).append(bake)
    for hand_over in {h.key: h for h in hand_overs if not h.is_cached()}.values():
        if stack_key(hand_over.stack) in groups:
            groups[stack_key(hand_over.stack)].append(hand_over)
    left, bakers, done = iter(groups.values()), [], 0
    try:
        for _ in range(min(os.cpu_count() or 1, MOST, len(groups))):
            bakers.append(Baker(left))
        is_done = False
        while not is_done:
            time.sleep(_POLL_SECONDS)
            is_done = all(baker.is_done for baker in bakers)
            for baker in bakers:
                while baker.made:
                    one, result = baker.made.pop(0)
                    one.put(result)
                    if isinstance(one, Wanted):
                        done += 1
                        report(f"{done} of {len(unknown)} bakes are done")
    finally:
        for baker in bakers:
            baker.cancel()
