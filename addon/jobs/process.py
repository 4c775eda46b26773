# SPDX-License-Identifier: GPL-3.0-or-later
"""One worker in a process beside Blender's, and what it tells."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress

from ...reference_py.errors import LaminaError, Sentence


def worker(module: str) -> list[str]:
    """The command line of a worker of `reference_py`."""
    from ...reference_py.lobes.methods.bake_process import command  # with the first process, not with Blender's start

    return command(sys.executable, module)


class Process:
    """A worker that reads a request and tells its progress in lines; `result` or `error`, which can be translated, is there once it is done.

    It gets the next of `requests`, a line each, when it has answered one. Raises LaminaError, which names `what`, where no process
    can be started.
    """

    def __init__(self, what: Sentence, command: list[str], requests: Iterable[str] = ()):
        from ...reference_py.lobes.methods.bake_process import ENVIRONMENT

        self.share, self.error, self.result = 0.0, Sentence(""), None
        self._requests = iter(requests)
        try:
            self._process = subprocess.Popen(
                command, env=os.environ | ENVIRONMENT, text=True,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            self._send()
        except OSError as error:
            raise LaminaError("cannot start {what} with {command}: {reason}", what=what, command=command[0], reason=error.strerror or error) from None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _send(self) -> None:
        request = next(self._requests, None)
        if request is None:
            self._process.stdin.close()
        else:
            self._process.stdin.write(f"{request}\n")
            self._process.stdin.flush()

    def _read(self) -> None:
        for line in self._process.stdout:
            word, _, rest = line.strip().partition(" ")
            if word == "progress":
                self.share = float(rest)
            elif word in ("result", "error"):
                if word == "result":
                    self.result = json.loads(rest)
                else:
                    self.error = Sentence.unpacked(json.loads(rest))
                with suppress(OSError):  # it has ended
                    self._send()
        code = self._process.wait()
        if self.result is None and not self.error:
            self.error = Sentence("its process ended with code {code}", code=code)

    @property
    def is_done(self) -> bool:
        return not self._reader.is_alive()

    def wait(self) -> None:
        self._reader.join()

    def cancel(self) -> None:
        self._process.kill()
        self._reader.join()
