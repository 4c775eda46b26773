# SPDX-License-Identifier: GPL-3.0-or-later
"""What the extension adds to Blender's start: CPU time of one with it and one without, in turns, and the modules that it reads.

    start.py [TABLE.csv]

LAMINA_BLENDER names a Blender, in which the built zip is installed for the purpose; without it the module bpy is started
and Lamina registered in it. Each with Python's compiled files there, as from the second start on. The least of each, as other
work only adds, and beside their difference the median of the pairs'.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from lamina.study.stamp import ROOT
from lamina.study.tables import write_table

ROUNDS = 11
COLUMNS = ("blender", "without_ms", "with_ms", "added_ms", "median_added_ms", "added_mb", "modules", "of_numpy")
_COUNT = "import sys; read = [n for n, m in sys.modules.items() if type(m).__name__ != '_Unread']; "
_COUNT += "print('READ', bpy.app.version_string, sum('.lamina.' in '.' + n + '.' for n in read), sum(n.split('.')[0] == 'numpy' for n in read), flush=True)"
_DISABLE = "import bpy; bpy.ops.preferences.addon_disable(module='bl_ext.user_default.lamina'); bpy.ops.wm.save_userpref()"
_LEAVE = "; import os; os._exit(0)"


def started(command: list[str], environment: dict) -> tuple[float, float, list[str]]:
    """CPU seconds of a process and its children, peak MB, and the words that it printed behind READ."""
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    line = next((line for line in said.splitlines() if line.startswith("READ ")), None)
    if status or line is None:
        raise SystemExit(f"lamina: {' '.join(command[:3])} ... ended with status {status}: {said[-500:]}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0, line.split("READ ")[1].rsplit(" ", 2)


def commands(folder: Path) -> tuple[tuple[list[str], dict], tuple[list[str], dict]]:
    """Command line and environment of a start without the extension and of one with it."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"} | {"LAMINA_CACHE": str(folder / "cache")}
    blender = os.environ.get("LAMINA_BLENDER")
    if blender is None:
        environment["PYTHONPYCACHEPREFIX"] = str(folder / "compiled")
        alone = [sys.executable, "-c", f"import bpy; {_COUNT}{_LEAVE}"]
        return (alone, environment), ([sys.executable, "-c", f"import bpy, lamina; lamina.register(); {_COUNT}{_LEAVE}"], environment)
    subprocess.run([sys.executable, ROOT / "tools" / "extension.py", "build", folder], check=True, capture_output=True)
    profiles = [environment | {"BLENDER_USER_RESOURCES": str(folder / name)} for name in ("without", "with")]
    for profile in profiles:  # installed in both, as preferences and extensions cost Blender itself time
        install = [blender, "-b", "--command", "extension", "install-file", "-r", "user_default", "-e", str(next(folder.glob("*.zip")))]
        subprocess.run(install, check=True, capture_output=True, env=profile)
    subprocess.run([blender, "-b", "--python-expr", _DISABLE], check=True, capture_output=True, env=profiles[0])
    start = [blender, "-b", "--python-expr", f"import bpy; {_COUNT}"]
    return (start, profiles[0]), (start, profiles[1])


def main() -> None:
    table = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as folder:
        without, own = commands(Path(folder))
        pairs = [(started(*without), started(*own)) for _ in range(ROUNDS + 1)][1:]
    added = [1000.0 * (b[0] - a[0]) for a, b in pairs]
    plain, full = (1000.0 * min(pair[i][0] for pair in pairs) for i in (0, 1))
    version, modules, of_numpy = pairs[0][1][2]
    megabytes = statistics.median(b[1] - a[1] for a, b in pairs)
    row = [version, f"{plain:.0f}", f"{full:.0f}", f"{full - plain:.0f}", f"{statistics.median(added):.0f}", f"{megabytes:.1f}", modules, of_numpy]
    print(*COLUMNS)
    print(*row)
    if table:
        write_table(table, ("make start", f"{ROUNDS} pairs, CPU time"), COLUMNS, [row], print)


if __name__ == "__main__":
    main()
