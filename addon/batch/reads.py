# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scenes of a job read besides their .blend files, as a part of what their pictures depend on. Needs no bpy."""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ...reference_py.errors import LaminaError
from .items import Item
from .worker import Worker

# A file up to here counts by its content; to read a larger one anew at every start would take longer than its picture.
LARGE = 64 << 20


@dataclass(frozen=True)
class Reads:
    """Of one .blend: the files that a render reads, and a phrase for each thing that is missing."""

    files: tuple[str, ...]
    missing: tuple[str, ...]


def reads_of(items: Iterable[Item]) -> dict[str, Reads]:
    """By .blend; asked of a Blender of its own, as a file may take it down. What cannot be opened is left out: its pictures will say so."""
    frames: dict[str, set[int]] = {}
    for item in items:
        if item.blend:
            frames.setdefault(item.blend, set()).add(item.frame)
    found = {}
    worker = None
    with tempfile.TemporaryDirectory() as work:
        try:
            for blend, shown in frames.items():
                try:
                    if worker is None:
                        worker = Worker(Path(work), Path(work), 1)
                        worker.wait_until_ready()
                    answer = worker.ask({"reads": blend, "frames": sorted(shown)})
                except LaminaError:  # it is gone
                    if worker is not None:
                        worker.stop()
                    worker = None
                    continue
                if "error" not in answer:
                    found[blend] = Reads(tuple(answer["files"]), tuple(answer["missing"]))
        finally:
            if worker is not None:
                worker.stop()
    return found


def with_reads(items: Sequence[Item], reads: dict[str, Reads], report: Callable[[str], None]) -> list[Item]:
    """The items, whose hash of inputs knows now of all files that are read. Raises LaminaError."""
    digests = {}
    for blend, read in reads.items():
        large = [path for path in read.files if _size(path) > LARGE]
        if large:
            names = ", ".join(os.path.basename(path) for path in large[:3]) + (f" and {len(large) - 3} more" if len(large) > 3 else "")
            report(f"{Path(blend).name}: {len(large)} of {len(read.files)} files that it reads are above {LARGE >> 20} MB and count by size and time: {names}")
        rows = [(_relative(path, blend), *_content(path)) for path in read.files]
        digests[blend] = hashlib.sha256(json.dumps(rows).encode()).hexdigest() if rows else ""
    return [replace(item, inputs=_with(item.inputs, digests[item.blend])) if digests.get(item.blend) else item for item in items]


def _with(inputs: str, digest: str) -> str:
    return hashlib.sha256(f"{inputs} {digest}".encode()).hexdigest()


def _relative(path: str, blend: str) -> str:
    """As the .blend sees it: a folder that moves as a whole stays the same."""
    try:
        return os.path.relpath(path, os.path.dirname(blend))
    except ValueError:  # another drive of Windows
        return path


def _size(path: str) -> int:
    try:
        return os.stat(path).st_size
    except OSError:
        return 0


def _content(path: str) -> tuple:
    try:
        about = os.stat(path)
        if about.st_size > LARGE:
            return about.st_size, about.st_mtime_ns
        with open(path, "rb") as file:
            return (hashlib.file_digest(file, "sha256").hexdigest(),)
    except OSError as error:
        return (error.strerror,)
