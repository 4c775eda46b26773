# SPDX-License-Identifier: GPL-3.0-or-later
"""Install the built extension in a real Blender and use it with a real mouse: convert there and back, preset, add, move, undo, rust by a mask.

    LAMINA_BLENDER=/path/to/blender python3 tests/window/window.py dist/lamina-*.zip FOLDER

Needs Linux with Xvfb and xdotool; with ImageMagick's `import` it leaves pictures in FOLDER. Uses a throw-away profile
and the standard library alone, so any Python will do. Prints one line per step. Exit: 0 good, 1 something
failed, 77 skipped, with the reason.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SKIPPED = 77
SIZE = (1280, 1000)
ROW = 20  # pixels of a button at scale 1
PATIENCE = 60.0
# Where menus are opened, in buttons below that which removes a layer.
ADD, SPECIALS = -1.0, 1.4


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

    def find_button(self, command: str, is_beside: bool = True) -> tuple[int, int]:
        """Where the button of an operator is in the column beside the list, or across the panel: Ctrl+C over a button copies its command."""
        panel = self.state()["panel"]
        x = panel["right"] - 4 if is_beside else (panel["left"] + panel["right"]) // 2
        for y in range(panel["top"] + 3 * ROW, panel["top"] + 26 * ROW, ROW // 2):
            self.mouse("mousemove", x, y)
            time.sleep(0.12)
            if command in self.copied():
                return x, y + 4
        raise AssertionError(f"no button {command} in the panel")

    def copied(self) -> str:
        """The command of what is under the mouse, or chosen in a menu; empty where that is none."""
        count = self.state()["tick"]
        self.key("ctrl+c")
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


def use(window: Window) -> None:
    """The session; every step says what it proved."""
    panel = window.wait_for("the window", lambda s: s["ready"])["panel"]
    x = (panel["left"] + panel["right"]) // 2
    convert(window)
    # below the slots and their buttons, one of which would make a material of another name
    for y in range(panel["top"] + 10 * ROW + 8, panel["top"] + 16 * ROW, ROW // 2):
        window.click(x, y)
        time.sleep(0.5)
        window.key("Down")
        window.key("Return")
        try:
            state = window.wait_for("a preset", lambda s: s["layers"], patience=2.5)
            break
        except AssertionError:
            window.key("Escape")
    else:
        raise AssertionError("no menu of presets in the panel")
    assert state["name"] == state["stack"], state
    told(f"preset: {state['stack']}, {len(state['layers'])} layer(s)")
    window.picture("preset")

    first = state["layers"]
    for number, letter in enumerate("df", 1):  # Dielectric, Frost: a menu takes the letters that it underlines
        state = add_layer(window, letter, len(first) + number)
    assert state["layers"][2:] == first and state["active"] == 0, state
    told(f"add: {', '.join(state['layers'])}")
    window.picture("added")

    before = state["layers"]
    state = move_down(window, before)
    assert state["layers"] == [before[1], before[0], *before[2:]] and state["active"] == 1, state
    told(f"move: {', '.join(state['layers'])}")

    select_rows(window, state)
    told("select: the row that was clicked, and no material was evaluated")

    window.mouse("mousemove", x, panel["bottom"] - 10)
    for undone, wanted in ((1, before), (2, before[1:]), (3, first)):
        window.key("ctrl+z")
        window.wait_for(f"undo {undone}", lambda s, w=wanted: s["layers"] == w)
    told("undo: three steps back")
    for redone, wanted in enumerate((before[1:], before, state["layers"]), 1):
        window.key("ctrl+shift+z")
        window.wait_for(f"redo {redone}", lambda s, w=wanted: s["layers"] == w)
    told("redo: three steps forth")
    assert window.state()["findings"] == [], window.state()
    rust_by_a_mask(window)
    window.picture("done")


def convert(window: Window) -> None:
    """Blender's own new material to Lamina and a Principled copy of that; then the object has none again."""
    window.click(*window.find_button("material.new", is_beside=False))
    window.wait_for("a new material", lambda s: s["name"])
    window.click(*window.find_button("lamina.convert_principled", is_beside=False))
    state = window.wait_for("what it is as layers", lambda s: s["layers"])
    window.key("Escape")  # the report
    told(f"convert: {', '.join(state['layers'])}")
    before = state["materials"]
    pick(window, SPECIALS, "LAMINA_MT_exchange", "lamina.principled_copy()")
    state = window.wait_for("a Principled copy", lambda s: len(s["materials"]) > len(before))
    window.key("Escape")
    told(f"back: {', '.join(set(state['materials']) - set(before))}")
    window.picture("converted")
    window.click(*window.find_button("material_slot_remove"))
    window.wait_for("an object without a material", lambda s: not s["name"])


def rust_by_a_mask(window: Window) -> None:
    """The ready layer Rust, which has a mask of its own, and a plain layer that gets one from the menu."""
    before = window.state()["layers"]
    pick(window, ADD, "layer_add_ready(ready='rust')")
    state = window.wait_for("rust", lambda s: len(s["layers"]) == len(before) + 1)
    assert state["masked"][state["active"]], state
    told(f"rust by its mask: {', '.join(state['layers'])}")
    pick(window, ADD, "layer_add(kind='dielectric')")
    state = window.wait_for("a plain layer", lambda s: len(s["layers"]) == len(before) + 2)
    assert not state["masked"][state["active"]], state
    pick(window, SPECIALS, "LAMINA_MT_add_mask", "edges")
    window.wait_for("its mask", lambda s: s["masked"][s["active"]])
    told(f"a mask: {', '.join(state['layers'])}")


def pick(window: Window, below: float, *commands: str) -> None:
    """Open a menu of the column beside the list, so many buttons below the one that removes a layer, and choose; thrice, as a busy machine may miss a click."""
    for _ in range(3):
        x, y = window.find_button("lamina.layer_remove")
        window.click(x, y + below * ROW)
        time.sleep(2.0)
        if window.pick(*commands):
            return
        for _ in range(3):
            window.key("Escape")
    raise AssertionError(f"no menu has {commands[-1]}")


def add_layer(window: Window, letter: str, count: int) -> dict:
    """Pick from the menu above the button that removes a layer. The panel may have moved, as when a bake is done, so thrice."""
    for _ in range(3):
        x, y = window.find_button("lamina.layer_remove")
        window.click(x, y - ROW)
        time.sleep(2.0)
        window.key(letter)
        try:
            return window.wait_for("a new layer", lambda s: len(s["layers"]) == count, patience=6.0)
        except AssertionError:
            window.key("Escape")
    raise AssertionError(f"no layer was added; the last state: {window.state()}")


def select_rows(window: Window, before: dict) -> None:
    """Click rows of the list, left of its buttons, of which the one that removes a layer is as high as the second row."""
    x, y = window.find_button("lamina.layer_remove")
    time.sleep(1.0)
    evaluated = window.state()["evaluated"]
    for row in (2, 0, 1):
        window.click(before["panel"]["left"] + 100, y + (row - 1) * ROW)
        window.wait_for(f"row {row}", lambda s, r=row: s["active"] == r, patience=15.0)
    assert window.state()["evaluated"] == evaluated, (evaluated, window.state())


def move_down(window: Window, before: list[str]) -> dict:
    """Click the button that moves a layer down; thrice, as a busy machine may miss a click."""
    for _ in range(3):
        window.click(*window.find_button("lamina.layer_move(direction='DOWN')"))
        try:
            return window.wait_for("a layer that moved", lambda s: s["layers"] != before, patience=15.0)
        except AssertionError:
            continue
    raise AssertionError(f"no layer moved; the last state: {window.state()}")


def told(text: str) -> None:
    print(text, flush=True)


def main(archive: str, folder: str) -> int:
    try:
        blender = needed()
    except Skip as reason:
        print(f"skipped: {reason}")
        return SKIPPED
    pictures = Path(folder)
    pictures.mkdir(parents=True, exist_ok=True)
    window = None
    try:
        window = Window(blender, Path(archive).resolve(), pictures)
        use(window)
        faults = [line for line in (pictures / "blender.log").read_text(encoding="utf-8").splitlines() if "Traceback" in line or "Error:" in line]
        assert not faults, faults
    except AssertionError as error:
        print(f"failed: {error}")
        if window is not None:
            window.picture("failed")
        return 1
    finally:
        if window is not None:
            window.close()
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
