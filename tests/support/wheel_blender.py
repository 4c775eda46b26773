# SPDX-License-Identifier: GPL-3.0-or-later
"""The bpy wheel in the clothes of a `blender` that knows -b and --python, and no Lamina."""

import stat
import sys
from pathlib import Path

_PROGRAM = """#!{python}
import runpy, sys
from pathlib import Path
import bpy
python = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
sys.path.append(str(python / f"python{{sys.version_info.major}}.{{sys.version_info.minor}}" / "site-packages"))
sys.path = [p for p in sys.path if not (Path(p) / "lamina").exists()]
runpy.run_path(sys.argv[sys.argv.index("--python") + 1], run_name="__main__")
"""


def blender_program(folder: Path) -> str:
    """Write the program into a folder; returns its path."""
    program = folder / "blender"
    program.write_text(_PROGRAM.format(python=sys.executable))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)
