# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C during a render. Blender swallows the KeyboardInterrupt, prints its traceback and goes on as if all were well."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def _set_back(handler) -> None:
    # None stands for one that Python did not set: a real Blender's own
    signal.signal(signal.SIGINT, signal.SIG_DFL if handler is None else handler)


@contextmanager
def raising() -> Iterator[None]:
    """Lets a SIGINT raise KeyboardInterrupt in the block, as plain Python does; a real Blender would end at once."""
    own = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or own not in (None, signal.SIG_DFL):
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        _set_back(own)


@contextmanager
def deferred() -> Iterator[None]:
    """Holds a SIGINT back to the end of the block: a Blender that is interrupted while it starts is left half-made."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    seen = []
    before = signal.signal(signal.SIGINT, lambda *_: seen.append(True))
    try:
        yield
    finally:
        _set_back(before)
    if seen:
        raise KeyboardInterrupt


@contextmanager
def interruptible() -> Iterator[None]:
    """Raises KeyboardInterrupt after the block if SIGINT came within it; what Blender says of it is not shown.

    Other threads than the main one, and Blender's window, where Esc cancels, are left alone.
    """
    import bpy

    if threading.current_thread() is not threading.main_thread() or not bpy.app.background:
        yield
        return
    interrupted = False
    stderr, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)

    def stop(_number, _frame) -> None:
        nonlocal interrupted
        interrupted = True
        os.dup2(sink, 2)
        raise KeyboardInterrupt  # ends the render, and Blender catches it

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        _set_back(before)
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(sink)
    if interrupted:
        raise KeyboardInterrupt
