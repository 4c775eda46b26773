# SPDX-License-Identifier: GPL-3.0-or-later
"""Take the pictures of the manual's first hour in a real Blender: `make manual-pictures`.

    LAMINA_BLENDER=/path/to/blender python3 tests/window/manual.py dist/lamina-*.zip FOLDER

Needs what window.py needs, and ImageMagick. Leaves first_hour_STEP.jpg in FOLDER, whole or not at all. Exit codes as window.py's.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from driver import SKIPPED, Skip, Window, needed

# As large as the picture that a listing on the extensions platform shows.
PATIENCE, SIZE = 1200.0, (1920, 1080)


def take(shown_in: Window, folder: Path) -> None:
    """A picture of each step, until the script inside says that all is done."""
    shown = ""
    while True:
        state = shown_in.wait_for("the next step", lambda s, last=shown: s.get("done") or s.get("failed") or s.get("shows", last) != last, PATIENCE)
        if state.get("done"):
            return
        if state.get("failed"):
            raise AssertionError(f"the step {state['failed']} failed; see {shown_in.folder / 'blender.log'}")
        shown = state["shows"]
        path = folder / f"first_hour_{shown}.jpg"
        new = path.with_suffix(".new.jpg")
        subprocess.run(["import", "-window", "root", "-quality", "82", str(new)], env=shown_in.environment, check=True, timeout=60)
        os.replace(new, path)
        shown_in.state_file.with_name(f"{shown}.taken").touch()
        print(f"wrote {path}", flush=True)


def main(archive: str, folder: str) -> int:
    try:
        blender = needed()
        if shutil.which("import") is None:
            raise Skip("ImageMagick's import is missing")
    except Skip as reason:
        print(f"skipped: {reason}")
        return SKIPPED
    with tempfile.TemporaryDirectory() as log:
        opened = Window(blender, Path(archive).resolve(), Path(log), "manual_inside.py", SIZE)
        try:
            take(opened, Path(folder))
        except AssertionError as error:
            print(f"failed: {error}\n{Path(log, 'blender.log').read_text(encoding='utf-8')[-2000:]}")
            return 1
        finally:
            opened.close()
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
