# SPDX-License-Identifier: GPL-3.0-or-later
"""Install the built extension in a real Blender and use it with a real mouse: the steps of `first_hour.py`.

    LAMINA_BLENDER=/path/to/blender python3 tests/window/window.py dist/lamina-*.zip FOLDER

Needs Linux with Xvfb and xdotool; with ImageMagick's `import` it leaves pictures in FOLDER. Uses a throw-away profile
and the standard library alone, so any Python will do. Prints one line per step. Exit: 0 good, 1 something
failed, 77 skipped, with the reason.
"""

import sys
from pathlib import Path

from driver import SKIPPED, Skip, Window, needed
from first_hour import use


def main(archive: str, folder: str) -> int:
    try:
        blender = needed()
    except Skip as reason:
        print(f"skipped: {reason}")
        return SKIPPED
    pictures = Path(folder).resolve()
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
