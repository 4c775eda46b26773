# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import LaminaError, Sentence


@contextmanager
def replacing(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path beside `path` (same suffix); on success it takes the place of `path`.

    Raises LaminaError when the folder is missing or not writable, or the disk is full.
    """
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem[:40]}.", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise LaminaError("{path}: cannot write into folder {folder}: {reason}", path=path, folder=path.parent, reason=error.strerror) from None
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp makes files private; give the result what a plain open() would have given
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except OSError as error:
        raise LaminaError("{path}: cannot write: {reason}", path=path, reason=error.strerror or error) from None
    finally:
        temporary.unlink(missing_ok=True)


def require_writable(path: str | os.PathLike) -> None:
    """Raise LaminaError now if `path` could not be written later, before long work starts."""
    if Path(path).is_dir():
        raise LaminaError("{path}: this is a folder; choose the name of a file", path=path)
    _try_folder(Path(path).parent, Sentence("{path}: cannot write into folder {folder}", path=path, folder=Path(path).parent))


def _try_folder(folder: Path, complaint: Sentence) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise LaminaError("{complaint}: {reason}", complaint=complaint, reason=error.strerror) from None


def output_folder(path: str | os.PathLike) -> Path:
    """The folder, made if need be. Raises LaminaError when it cannot be made or written to."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LaminaError("{folder}: cannot make this folder: {reason}", folder=folder, reason=error.strerror) from None
    _try_folder(folder, Sentence("{folder}: cannot write into this folder", folder=folder))
    return folder


def write_text(path: str | os.PathLike, text: str) -> None:
    """Write UTF-8 text, whole or not at all. Raises LaminaError."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
