# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender for the commands that need it: the wheel's module or the running application."""

import os
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..reference_py.errors import LaminaError
from .blender.environment import ensure_osl_query_on_path
from .blender.interrupt import SIGNALS, deferred

REPORT_SECONDS = 2.0
GRACE_SECONDS = 1.5


@contextmanager
def blender(report: Callable[[str], None]) -> Iterator[None]:
    """A Blender with Lamina registered and OSL at hand. Its chatter is silent; `report` gets the render's state.

    Raises LaminaError where bpy is not installed.
    """
    # from the first import on: some versions of Blender talk while they start
    with _silent_stdout():
        with deferred():
            try:
                import bpy
            except ImportError as error:
                raise LaminaError(f"this command needs Blender: pip install bpy, or blender --command lamina ... ({error})") from None
            ensure_osl_query_on_path()
            if not hasattr(bpy.types.Material, "lamina"):
                from . import registration

                registration.register()
        # persistent: commands load files, which drops other handlers
        listener = bpy.app.handlers.persistent(_render_listener(report))
        bpy.app.handlers.render_stats.append(listener)
        try:
            with _leaving_promptly():
                yield
        finally:
            bpy.app.handlers.render_stats.remove(listener)


@contextmanager
def _leaving_promptly() -> Iterator[None]:
    """Ends the process soon after Ctrl-C or SIGTERM, whatever Blender is doing.

    Python handles a signal only when Blender next calls back, which may take minutes. So a thread waits for it, gives
    the orderly way `GRACE_SECONDS`, and then leaves. Unfinished pictures are in a temporary folder, which goes too.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    folder = tempfile.mkdtemp(prefix="lamina.")
    source, sink = os.pipe()
    os.set_blocking(sink, False)
    stderr = os.dup(2)

    def wait() -> None:
        while (number := os.read(source, 1)[0]) not in SIGNALS:
            pass
        time.sleep(GRACE_SECONDS)
        os.write(stderr, b"lamina: cancelled\n")
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(128 + number)

    threading.Thread(target=wait, daemon=True).start()
    before = signal.set_wakeup_fd(sink, warn_on_full_buffer=False)
    tempfile.tempdir = folder
    try:
        yield
    finally:
        tempfile.tempdir = None
        signal.set_wakeup_fd(before)
        shutil.rmtree(folder, ignore_errors=True)


def _render_listener(report):
    """Passes on Cycles' own progress every few seconds."""
    last = time.monotonic()

    def listen(*arguments) -> None:
        nonlocal last
        text = next((a for a in arguments if isinstance(a, str)), "")
        if "Sample" in text and time.monotonic() - last > REPORT_SECONDS:
            last = time.monotonic()
            report(text[text.index("Sample") :].split("|")[0].strip())

    return listen


@contextmanager
def _silent_stdout() -> Iterator[None]:
    """Blender prints every step of a render on stdout, where our numbers belong."""
    sys.stdout.flush()
    saved, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)


def say(command: str) -> Callable[[str], None]:
    """A reporter that writes one line at a time to stderr."""

    def report(text: str) -> None:
        print(f"lamina {command}: {text}", file=sys.stderr, flush=True)

    return report


def tenths(report: Callable[[str], None]) -> Callable[[float], None]:
    """A progress callback that says every tenth of the way."""
    said = 0

    def progress(done: float) -> None:
        nonlocal said
        if done < 1.0 and int(10 * done) > said:
            said = int(10 * done)
            report(f"{10 * said} %")

    return progress
