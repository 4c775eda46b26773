# SPDX-License-Identifier: GPL-3.0-or-later
"""One batch at a time in a folder. The system drops the lock with its process, however that ends. Needs no bpy."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...reference_py.errors import LaminaError


@contextmanager
def sole_owner(folder: Path) -> Iterator[None]:
    """Holds the folder; the file of the lock is gone in the end. Raises LaminaError when another batch does."""
    path = folder / ".lamina-batch"
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            _lock(handle)
            if not os.path.samestat(os.fstat(handle), os.stat(path)):  # its former owner removed it just now
                raise FileNotFoundError
        except OSError:
            holder = os.read(handle, 32).decode("ascii", "replace").strip()
            raise LaminaError(f"{folder}: another batch works there, process {holder or 'unknown'}; wait for it, or choose another folder") from None
        try:
            os.ftruncate(handle, 0)
            os.write(handle, b"%d\n" % os.getpid())
            yield
        finally:
            with suppress(OSError):
                path.unlink()  # while it is held: afterwards it may be another's
    finally:
        os.close(handle)
        if os.name == "nt":  # no open file can be removed there, nor one that another has opened meanwhile
            with suppress(OSError):
                path.unlink()


def _lock(handle: int) -> None:
    try:
        import fcntl
    except ImportError:  # Windows
        import msvcrt

        # one byte far behind the text, which others may go on reading
        os.lseek(handle, 1 << 20, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        os.lseek(handle, 0, os.SEEK_SET)
        return
    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
