# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake costs from nothing, beside a former commit: `lamina shader STACK --tier auto` with an empty cache, in turns.

    bakes.py [TABLE.csv [COMMIT]]

CPU time of the process and its children on one core, the least of two rounds; the former's of one. Memory is the process's peak.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from lamina.study.stamp import ROOT
from lamina.study.tables import write_table

FORMER = "324623f"
STACKS = ("frosted_metal", "metallic_car_paint", "clear_coat_car_paint", "metal_foil", "frosted_paint", "clean_copper", "glazed_mug")
COLUMNS = ("stack", "former_s", "now_s", "ratio", "former_mb", "now_mb")
_RUN = "import sys; from lamina.addon.cli.main import main; sys.argv = ['lamina', 'shader', sys.argv[1], '--tier', 'auto']; main()"


def bake(tree: Path, stack: str) -> tuple[float, float]:
    """CPU seconds, and peak memory in MB, of a bake by the code under tree/lamina."""
    with tempfile.TemporaryDirectory() as cache:
        # modules are compiled once, as where Lamina is installed
        own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"} | {"PYTHONPYCACHEPREFIX": str(tree / "compiled")}
        environment = own | {"PYTHONPATH": str(tree), "LAMINA_CACHE": cache, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        process = subprocess.Popen([sys.executable, "-c", _RUN, stack], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"lamina: a bake of {stack} by {tree / 'lamina'} failed")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def main() -> None:
    table, former = Path(sys.argv[1]) if len(sys.argv) > 1 else None, sys.argv[2] if len(sys.argv) > 2 else FORMER
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        now, before = Path(folder) / "now", Path(folder) / "before"
        now.mkdir()
        (now / "lamina").symlink_to(ROOT)
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", ROOT, before / "lamina"], check=True)
        subprocess.run(["git", "-C", before / "lamina", "checkout", "--quiet", former], check=True)
        for tree in (now, before):
            bake(tree, STACKS[-1])
        for stack in STACKS:
            first, (former_s, former_mb), second = bake(now, stack), bake(before, stack), bake(now, stack)
            now_s = min(first[0], second[0])
            rows.append((stack, f"{former_s:.2f}", f"{now_s:.2f}", f"{former_s / now_s:.1f}", f"{former_mb:.0f}", f"{max(first[1], second[1]):.0f}"))
            print(*rows[-1], flush=True)
    if table:
        write_table(table, ("make bakes", f"beside {former}", "one core, CPU time"), COLUMNS, rows, print)


if __name__ == "__main__":
    main()
