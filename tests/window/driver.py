# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender with a window on a screen of its own, and its mouse and keys. Standard library alone."""

import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

SKIPPED = 77
SIZE = (1280, 1000)
ROW = 20  # pixels of a button at scale 1
PATIENCE = 60.0
# Places of buttons in the panel, as shares of its width: beside the list, in its middle, and the dot of a value.
BESIDE, MIDDLE, DOT = 1.0, 0.5, 0.409
# What Blender copies of a button: its command, or the path of its value.
COMMAND, VALUE = "ctrl+c", "ctrl+alt+shift+c"


class Skip(Exception):
    """Why there is nothing to test."""


def needed() -> str:
    """The Blender to test. Raises Skip where it, or a tool, is missing."""
    blender = os.environ.get("LAMINA_BLENDER", "")
    if not blender:
        raise Skip("LAMINA_BLENDER names no Blender")
    if shutil.which(blender) is None:
        raise Skip(f"LAMINA_BLENDER is {blender}, which is no program")
    missing = [tool for tool in ("Xvfb", "xdotool") if shutil.which(tool) is None]
    if missing:
        raise Skip(f"{' and '.join(missing)} missing: a window needs a screen and a mouse")
    return blender


class Window:
    """A Blender with a window on a screen of its own."""

    def __init__(self, blender: str, archive: Path, folder: Path, inside: str = "inside.py", size: tuple[int, int] = SIZE):
        self.folder, self._started = folder, []
        self._work = Path(tempfile.mkdtemp(prefix="lamina-window-"))
        self.state_file = self._work / "state.json"
        self.environment = os.environ | {
            "BLENDER_USER_RESOURCES": str(self._work / "user"), "LAMINA_STATE": str(self.state_file),
            "LAMINA_CACHE": str(self._work / "bakes"), "LIBGL_ALWAYS_SOFTWARE": "1", "SDL_AUDIODRIVER": "dummy",
        }  # fmt: skip
        self.environment.pop("WAYLAND_DISPLAY", None)
        (self._work / "user").mkdir()
        install = [blender, "--command", "extension", "install-file", "-r", "user_default", "-e", str(archive)]
        done = subprocess.run(install, env=self.environment, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)
        if "Installed" not in done.stdout and "Reinstalled" not in done.stdout:
            raise AssertionError(f"not installed: {done.stdout}{done.stderr}")
        self._open_screen(size)
        self.log = (folder / "blender.log").open("w", encoding="utf-8")
        self._start([blender, "--no-window-frame", "-p", "0", "0", *map(str, size), "--python", str(Path(__file__).with_name(inside))])

    def _open_screen(self, size: tuple[int, int]) -> None:
        reader, writer = os.pipe()
        screen = ["Xvfb", "-displayfd", str(writer), "-screen", "0", f"{size[0]}x{size[1]}x24", "-nolisten", "tcp"]
        self._started.append(subprocess.Popen(screen, pass_fds=[writer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        os.close(writer)
        with os.fdopen(reader) as pipe:
            self.environment["DISPLAY"] = f":{pipe.readline().strip()}"

    def _start(self, command: list[str]) -> None:
        self._started.append(subprocess.Popen(command, env=self.environment, stdout=self.log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL))

    def close(self) -> None:
        for process in reversed(self._started):
            process.kill()
            process.wait()
        shutil.rmtree(self._work, ignore_errors=True)

    def state(self) -> dict:
        """What the script inside Blender last told."""
        try:
            return json.loads(self.state_file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def wait_for(self, what: str, is_true, patience: float = PATIENCE) -> dict:
        """The first state of which `is_true`. Raises AssertionError after `patience` seconds."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            state = self.state()
            if state and is_true(state):
                return state
            if self._started[-1].poll() is not None:
                break
            time.sleep(0.1)
        raise AssertionError(f"waited in vain for: {what}; the last state: {self.state()}")

    def mouse(self, *words) -> None:
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True, timeout=20)

    def click(self, x: float, y: float) -> None:
        self.mouse("mousemove", int(x), int(y))
        time.sleep(0.3)
        self.mouse("click", 1)

    def key(self, name: str) -> None:
        self.mouse("key", name)

    def find(self, command: str, place: float = BESIDE, keys: str = COMMAND) -> tuple[int, int]:
        """Where the button of an operator, or with the keys VALUE of a value, is: in the column beside the list, or at a share of the panel's width."""
        panel = self.state()["panel"]
        x = int(panel["right"] - 4 if place == BESIDE else panel["left"] + place * (panel["right"] - panel["left"]))
        for y in range(panel["top"] + 3 * ROW, panel["bottom"] - ROW, ROW - 4):
            self.mouse("mousemove", x, y)
            time.sleep(0.12)
            if command in self.copied(keys):
                return x, y + 4
        raise AssertionError(f"no button {command} in the panel")

    def write(self, text: str) -> None:
        """Type into the field that was clicked, in place of what it holds."""
        time.sleep(1.0)
        self.key("ctrl+a")
        self.mouse("type", "--delay", "30", text)
        time.sleep(0.5)
        self.key("Return")
        time.sleep(1.5)

    def copied(self, keys: str = COMMAND) -> str:
        """The command, or the path, of what is under the mouse, or chosen in a menu; empty where that is none."""
        count = self.state()["tick"]
        self.key(keys)
        self.wait_for("the clipboard", lambda s: s["tick"] >= count + 3)
        tick, text = self.state()["copied"]
        return text if tick > count else ""

    def pick(self, *commands: str) -> bool:
        """Choose with the arrow keys in the menu that is open, through its submenus, the last of which is an operator; whether they are there."""
        for command in commands:
            for _ in range(60):
                self.key("Down")
                text = self.copied() or self.copied()  # a busy machine may miss a key
                if command in text:
                    self.key("Return" if command == commands[-1] else "Right")
                    time.sleep(0.5)
                    break
            else:
                return False
        return True

    def picture(self, name: str) -> None:
        if shutil.which("import"):
            time.sleep(4.0)  # a window without a graphics card takes its time
            subprocess.run(["import", "-window", "root", str(self.folder / f"{name}.png")], env=self.environment, timeout=60)
