# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a batch: what is there already is verified and skipped, the rest is shared out among worker processes."""

import os
import queue
import shutil
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from ...reference_py.errors import LaminaError
from .items import Item
from .outputs import Output, verified
from .worker import Answer, Worker

WORK = ".work"
_POLL_SECONDS = 0.2
# Cycles with OSL and persistent data grows with every frame, for Lamina's materials and for others: at this a worker is started anew.
GROWTH_MB = 512.0


def run_items(items: Sequence[Item], folder: Path, processes: int, limit: float | None, report: Callable[[str], None], replace: bool = False) -> list[Output]:
    """Render what is not there yet, each within `limit` seconds; returns one output per item, failed ones with their problem.

    A scene that fails is tried once. Raises LaminaError when every scene does, when no worker can be started, and before anything is rendered when whole pictures of other inputs
    have the names of some, unless `replace`; KeyboardInterrupt when cancelled; workers are gone then.
    """
    from .task import OTHER_INPUTS

    outputs = {item.id: verified(item, folder) for item in items}
    left = [item for item in items if outputs[item.id].problem]
    others = [output.item.file for output in outputs.values() if output.problem == OTHER_INPUTS]
    if others and not replace:
        raise LaminaError(
            f"{folder}: {len(others)} pictures of other inputs (another job, or this one as it was) have the names of this job's, "
            f"such as {others[0]}; choose another folder, or give --replace to render them anew"
        )
    report(f"{len(items)} pictures, {len(items) - len(left)} of them are there and whole")
    clear_leftovers(folder)
    if not left:
        return list(outputs.values())
    _require_space(left, folder, report)
    work = folder / WORK
    work.mkdir(exist_ok=True)
    try:
        _render(left, outputs, folder, work, max(1, min(processes, len(left))), limit, report)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    if all(output.scene_failed for output in outputs.values()):
        raise LaminaError("; ".join(dict.fromkeys(output.problem for output in outputs.values())))
    return list(outputs.values())


def _require_space(items: Sequence[Item], folder: Path, report: Callable[[str], None]) -> None:
    """Raise LaminaError for a disk that cannot take one picture, report one that may not take all. Pictures pack by no more than can be told before."""
    sizes = [16 * item.size[0] * item.size[1] for item in items if item.size]  # a scene's own size is told by its .blend alone
    free = shutil.disk_usage(folder).free
    if not sizes or free > sum(sizes):
        return
    sentence = f"{folder}: {len(sizes)} pictures take up to {sum(sizes) / 1e6:.1f} MB, {max(sizes) / 1e6:.2f} MB each, and {free / 1e6:.2f} MB are free"
    if free < max(sizes):
        raise LaminaError(f"{sentence}; choose another disk, or make room")
    report(sentence)


def clear_leftovers(folder: Path) -> None:
    """Remove what a killed batch left half-made. Only for who owns the folder."""
    shutil.rmtree(folder / WORK, ignore_errors=True)
    for half in folder.glob(".*.exr"):
        half.unlink(missing_ok=True)


class _Left:
    """Items that wait, by scene and material, whose bake and shader each process makes for itself: two processes share a
    material only when no other is left."""

    def __init__(self, items: Sequence[Item]):
        self._lock = threading.Lock()
        self._groups: dict[tuple, list[Item]] = {}
        for item in reversed(items):
            self._groups.setdefault(self._key(item), []).append(item)
        self._fresh = list(self._groups)

    @staticmethod
    def _key(item: Item) -> tuple:
        return item.blend, item.scene.object, item.stack.to_json(), item.tier, item.backend

    def take(self, last: Item | None) -> Item | None:
        """An item for the process whose last one was `last`; None when none is left."""
        with self._lock:
            key = self._key(last) if last else None
            if key not in self._groups:
                key = self._fresh.pop() if self._fresh else max(self._groups, key=lambda k: len(self._groups[k]), default=None)
            if key is None:
                return None
            item = self._groups[key].pop()
            if not self._groups[key]:
                del self._groups[key]
            return item

    def take_scene(self, item: Item) -> list[Item]:
        """All that wait of an item's scene."""
        with self._lock:
            taken = [self._groups.pop(key) for key in list(self._groups) if key[:2] == self._key(item)[:2]]
            self._fresh = [key for key in self._fresh if key in self._groups]
        return [other for group in taken for other in reversed(group)]

    def clear(self) -> None:
        with self._lock:
            self._groups, self._fresh = {}, []


def _render(waiting: Sequence[Item], outputs: dict, folder: Path, work: Path, processes: int, limit: float | None, report) -> None:
    threads = max(1, (os.cpu_count() or 1) // processes)
    done: queue.Queue = queue.Queue()
    left = _Left(waiting)
    hands = [_Hand(left, done, limit, (folder, work, threads)) for _ in range(processes)]
    total, started = len(waiting), time.monotonic()
    said: set[str] = set()
    for hand in hands:
        hand.start()
    try:
        finished = 0
        while finished < total:
            try:
                answered, (error, is_scene, notices, _) = done.get(timeout=_POLL_SECONDS)
            except queue.Empty:
                if not any(hand.is_alive() for hand in hands):
                    raise LaminaError(f"no worker is left: {hands[0].problem}") from None
                continue
            finished += len(answered)
            for notice in notices:
                if notice not in said:
                    said.add(notice)
                    report(notice)
            for item in answered:
                outputs[item.id] = Output(item, error, {}, is_scene) if error else verified(item, folder)
            problem = outputs[answered[0].id].problem
            name = answered[0].id if len(answered) == 1 else f"{len(answered)} pictures of scene {answered[0].scene.name}"
            seconds = (time.monotonic() - started) / finished * (total - finished)
            # why a scene failed is said in the end, with all else that did
            how = ("failed" if is_scene else f"failed: {problem}") if problem else "done"
            report(f"{finished}/{total}, {100 * finished // total} %, {_time_left(seconds)}: {name} {how}")
    finally:
        left.clear()
        for hand in hands:
            hand.stop()


def _time_left(seconds: float) -> str:
    if seconds < 90:
        return f"about {seconds:.0f} s left"
    return f"about {seconds / 60:.0f} min left" if seconds < 5400 else f"about {seconds / 3600:.1f} h left"


class _Hand(threading.Thread):
    """Feeds one worker, and a new one when an item takes it down."""

    def __init__(self, left: _Left, done: queue.Queue, limit: float | None, where: tuple[Path, Path, int]):
        super().__init__(daemon=True)
        self._left, self._done, self._limit, self._where = left, done, limit, where
        self._worker: Worker | None = None
        self._stopped = False
        self._grown: tuple[tuple, float, int] | None = None
        self.problem = ""

    def run(self) -> None:
        item = None
        while not self._stopped:
            try:
                if self._worker is None:
                    self._worker = Worker(*self._where)
                    self._worker.wait_until_ready()
            except (LaminaError, OSError) as error:
                self.problem = f"cannot start Blender for rendering: {error}"
                self._drop()
                return
            if (item := self._left.take(item)) is None:
                break
            try:
                answer = self._worker.render(item, self._limit)
            except LaminaError as why:  # the process is gone
                self._drop()
                answer = Answer(str(why))
            answer = self._bounded(item, answer)
            self._done.put(([item, *(self._left.take_scene(item) if answer.is_scene else ())], answer))
        self._drop()

    def _bounded(self, item: Item, answer: Answer) -> Answer:
        """End a worker that grew too much since its first picture of a scene; the answer says so."""
        scene = (item.blend, item.scene.object)
        if self._worker is None or not answer.megabytes:
            self._grown = None
            return answer
        if self._grown is None or self._grown[0] != scene:
            self._grown = scene, answer.megabytes, 0
        _, first, pictures = self._grown
        self._grown = scene, first, pictures + 1
        if answer.megabytes - first <= GROWTH_MB:
            return answer
        self._drop()
        self._grown = None
        sentence = f"a worker grew by {answer.megabytes - first:.0f} MB in {pictures} pictures, above {GROWTH_MB:g} MB, and is started anew"
        return answer._replace(notices=(*answer.notices, sentence))

    def _drop(self) -> None:
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.stop()

    def stop(self) -> None:
        self._stopped = True
        worker = self._worker
        if worker is not None:
            worker.stop()
        self.join(timeout=5.0)
        self._drop()  # one that it started meanwhile
