# SPDX-License-Identifier: GPL-3.0-or-later
"""What was computed for a stack, by content: names, sources, unknown keys and what float32 leaves out do not matter.

It is kept in memory, and, once `keep_in` named a folder, in files that outlive the process. A file's name also holds
a digest of the code that computed it, so that no other version's results are used.
"""

import hashlib
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypeVar

from ..atomic import write_text
from ..errors import LaminaError
from ..material.place import Place, places
from ..material.schema import COVERAGE, NORMAL
from ..material.stack import Stack

# What a shader reads live even where it holds all other values.
ALWAYS_LIVE = frozenset(p.name for feature in (COVERAGE, NORMAL) for p in feature.parameters)
_LIMIT = 256
FOLDER_VARIABLE = "LAMINA_CACHE"
# What a folder keeps at most, files and bytes; what was not used for longest goes first.
_FILES, _BYTES = 4096, 256 << 20
# A file's date says when it was last used; it is set anew when that is older than this, so that reading costs no writing.
_DAY = 86400.0
_HITS = "hits.txt"
_memory: dict[str, object] = {}
_folder: Path | None = None
_complain: Callable[[str], None] = print

T = TypeVar("T")


def keep_in(folder: Path | None, complain: Callable[[str], None] = print) -> None:
    """Keep what is computed in a folder too, which is made when first needed; None keeps it in memory alone.

    `complain` is called once, with a sentence, if the folder cannot be written to.
    """
    global _folder, _complain
    _folder, _complain = folder, complain


def cached(key: str, make: Callable[[], T], pack: Callable[[T], dict], unpack: Callable[[dict], T]) -> T:
    """What `make` gave under this key before, or gives now. `pack` makes JSON's types of it and `unpack` takes them."""
    found = get(key, unpack)
    if found is None:
        found = make()
        _keep(key, found)
        _write(key, pack(found))
    return found


def get(key: str, unpack: Callable[[dict], T]) -> T | None:
    """What is kept under a key; None if nothing is. A file that cannot be read counts as nothing."""
    if key not in _memory and _folder is not None:
        try:
            _keep(key, unpack(json.loads(_file(key).read_text(encoding="utf-8"))))
            _count_hit(_file(key))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
            return None
    return _memory.get(key)


def _keep(key: str, value) -> None:
    if len(_memory) >= _LIMIT:
        _memory.pop(next(iter(_memory)))
    _memory[key] = value


def _write(key: str, data: dict) -> None:
    """A folder that cannot be written to costs a bake the next time, nothing else."""
    global _folder
    if _folder is None:
        return
    try:
        _folder.mkdir(parents=True, exist_ok=True)
        write_text(_file(key), json.dumps(data))
        _bound(_file(key))
    except (OSError, LaminaError) as error:
        _complain(_cannot_keep(error))
        _folder = None


def _bound(written: Path) -> None:
    """Drop what was not used for longest. By their dates, which a clock may have set back: what was just written is not among them."""
    files = _by_use([file for file in _folder.glob("*.json") if file != written])
    count, size = len(files) + 1, sum(about.st_size for _, about in files) + written.stat().st_size
    for file, about in files:
        if count <= _FILES and size <= _BYTES:
            break
        file.unlink(missing_ok=True)
        count, size = count - 1, size - about.st_size


def _by_use(files: Iterable[Path]) -> list[tuple[Path, os.stat_result]]:
    """Files that are there, the longest unused first."""
    found = []
    for file in files:
        with suppress(OSError):  # another process removed it
            found.append((file, file.stat()))
    return sorted(found, key=lambda one: one[1].st_mtime)


def _count_hit(file: Path) -> None:
    """One byte for each hit, which processes can add at the same time; a folder that is read-only counts none."""
    with suppress(OSError):
        with open(_folder / _HITS, "ab") as hits:
            hits.write(b".")
        if time.time() - file.stat().st_mtime > _DAY:
            os.utime(file)


class Usage(NamedTuple):
    """Of a folder: files and bytes, how often one was found in it, and the days since the least and the most lately used one was."""

    files: int
    size: int
    hits: int
    oldest_days: float
    newest_days: float


def usage(folder: Path) -> Usage:
    """What a folder of `keep_in` holds; one that is not there holds nothing."""
    found = _by_use(folder.glob("*.json"))
    hits = 0
    with suppress(OSError):
        hits = (folder / _HITS).stat().st_size
    days = [max(time.time() - about.st_mtime, 0.0) / _DAY for _, about in found] or [0.0]
    return Usage(len(found), sum(about.st_size for _, about in found), hits, days[0], days[-1])


def clean(folder: Path, older_than_days: float = 0.0) -> Usage:
    """Remove what was not used for so long; returns what that was. Raises LaminaError."""
    removed, size = 0, 0
    for file, about in _by_use(folder.glob("*.json")):
        if time.time() - about.st_mtime < older_than_days * _DAY:
            continue
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            raise LaminaError("{file}: cannot remove: {reason}", file=file, reason=error.strerror) from None
        removed, size = removed + 1, size + about.st_size
    if not any(folder.glob("*.json")):
        (folder / _HITS).unlink(missing_ok=True)
    return Usage(removed, size, 0, 0.0, 0.0)


def require_writable(complain: Callable[[str], None]) -> None:
    """Complain now, and not after the first bake, of a folder that cannot be written to."""
    global _folder
    if _folder is None:
        return
    try:
        _folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=_folder):
            pass
    except OSError as error:
        complain(_cannot_keep(error.strerror or error))
        _folder = None


def _cannot_keep(why) -> str:
    return f"what is baked cannot be kept in {_folder}, so the next session bakes it again ({why}); {FOLDER_VARIABLE} names another folder"


def _file(key: str) -> Path:
    return _folder / f"{hashlib.sha256((_code() + key).encode()).hexdigest()[:32]}.json"


def prepare() -> None:
    """Read, once for a session, what every look for a bake needs."""
    _code()


@cache
def _code() -> str:
    """A digest of the reference's own text and data."""
    files, digest = [], hashlib.sha256()
    for folder, folders, names in os.walk(Path(__file__).resolve().parents[1]):  # in half the time of `Path.rglob`
        folders[:] = [name for name in folders if name != "presets"]
        files += [os.path.join(folder, name) for name in names if name.endswith((".py", ".json"))]
    for file in sorted(files):
        with open(file, "rb", buffering=0) as text:
            digest.update(text.read())
    return digest.hexdigest()


def stack_key(stack: Stack, live: tuple[Place, ...] = ()) -> str:
    """A hash of what a stack is made of. Of values that are live, and of what every shader reads live, only that they are there."""
    elements = [
        [e.kind, *((name, None if name in ALWAYS_LIVE or Place(i, name) in live else _rounded(value)) for name, value in sorted(e.values.items()))]
        for i, e in places(stack)
    ]
    return hashlib.sha256(json.dumps([elements, [place.pair() for place in live]]).encode()).hexdigest()


def _rounded(value):
    if isinstance(value, tuple):
        return [_rounded(v) for v in value]
    return f"{value:.5g}" if isinstance(value, float) else value
