# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C and SIGTERM. During a render Blender swallows the exception, prints its traceback and goes on as if all were well."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Terminated(KeyboardInterrupt):
    """SIGTERM, with which farms and systems end a process: all is left as after Ctrl-C."""


def _raise(number, _frame=None) -> None:
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt


def _set_back(number, handler) -> None:
    # None stands for one that Python did not set: a real Blender's own
    signal.signal(number, signal.SIG_DFL if handler is None else handler)


@contextmanager
def raising() -> Iterator[None]:
    """Lets signals raise KeyboardInterrupt in the block, as plain Python does for SIGINT; a real Blender would end at once."""
    own = {number: signal.getsignal(number) for number in SIGNALS}
    ending = [number for number, handler in own.items() if handler in (None, signal.SIG_DFL)]
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    for number in ending:
        signal.signal(number, _raise)
    try:
        yield
    finally:
        for number in ending:
            _set_back(number, own[number])


@contextmanager
def deferred() -> Iterator[None]:
    """Holds signals back to the end of the block: a Blender that is interrupted while it starts is left half-made."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    seen: list[int] = []
    before = {number: signal.signal(number, lambda n, _: seen.append(n)) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            _set_back(number, handler)
    if seen:
        _raise(seen[0])


@contextmanager
def interruptible() -> Iterator[None]:
    """Raises KeyboardInterrupt after the block if a signal came within it; what Blender says of it is not shown.

    Other threads than the main one, and Blender's window, where Esc cancels, are left alone.
    """
    import bpy

    if threading.current_thread() is not threading.main_thread() or not bpy.app.background:
        yield
        return
    seen: list[int] = []
    stderr, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)

    def stop(number, _frame) -> None:
        seen.append(number)
        os.dup2(sink, 2)
        _raise(number)  # ends the render, and Blender catches it

    before = {number: signal.signal(number, stop) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            _set_back(number, handler)
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(sink)
    if seen:
        _raise(seen[0])
