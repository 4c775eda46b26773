# SPDX-License-Identifier: GPL-3.0-or-later
"""How far bakes of every stack of `chart tiers` are off, beside a former commit's, both against this one's truth (twenty minutes).

    bake_errors.py [COMMIT]

Albedo and shape as that chart has them, at its views and at some between two knots. Prints medians, and each stack that is worse by more
than a tenth of itself.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.serialize import unpack_tables
from lamina.reference_py.lobes.view_table import middle_cosines
from lamina.reference_py.models.adding.adding_model import Adding
from lamina.study.charts.tiers import GLOSSY, THETA_DEG
from lamina.study.stamp import ROOT
from lamina.study.suite import charted

FORMER = "b2eb242"
# Middles of cells, by number from grazing, to 88 degrees.
BETWEEN = (4, 6, 8, 12, 16)
# A tenth of less than this is not counted.
LEAST = {"albedo": 2e-3, "shape worst": 5e-3, "shape median": 5e-3}
_BAKE = """
import json, sys
from lamina.reference_py.lobes.baked import Baker, pack_lobes
from lamina.reference_py.lobes.methods.baking import is_bare_oren_nayar
from lamina.reference_py.lobes.truth import truth_of
from lamina.study.suite import charted
for name, stack in charted().items():
    if not is_bare_oren_nayar(stack):
        baker = Baker(stack, truth_of(stack))
        print(json.dumps([name, {count: pack_lobes(baker.bake(count).lobe_set) for count in map(int, sys.argv[1:])}]))
"""


def bakes(tree: Path) -> dict[str, dict]:
    """By stack, packed bakes by number of glossy lobes, by the code under tree/lamina."""
    environment = os.environ | {"PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", _BAKE, *map(str, GLOSSY)], env=environment, capture_output=True, text=True, check=True)
    return dict(json.loads(line) for line in done.stdout.splitlines())


def main() -> None:
    former = sys.argv[1] if len(sys.argv) > 1 else FORMER
    with tempfile.TemporaryDirectory() as folder:
        trees = [Path(folder) / "before", Path(folder) / "now"]
        for tree in trees:
            tree.mkdir()
        (trees[1] / "lamina").symlink_to(ROOT)
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", ROOT, trees[0] / "lamina"], check=True)
        subprocess.run(["git", "-C", trees[0] / "lamina", "checkout", "--quiet", former], check=True)
        both = [bakes(tree) for tree in trees]
    cosines = np.concatenate([np.cos(np.radians(THETA_DEG)), middle_cosines()[list(BETWEEN)]])
    found: dict[int, list] = {count: [] for count in GLOSSY}
    for name, stack in charted().items():
        if name not in both[0]:
            continue
        estimator = ErrorEstimator(stack, Adding(stack), cosines)
        for count in GLOSSY:
            errors = [estimator.errors(unpack_tables(side[name][str(count)]["tables"], stack)) for side in both]
            found[count].append((name, np.array([(np.max(e.albedo), np.max(e.shape), np.median(e.shape)) for e in errors])))
    for count, rows in found.items():
        for place, (kind, least) in enumerate(LEAST.items()):
            before, now = np.array([values[:, place] for _, values in rows]).T
            worse = now > 1.1 * np.maximum(before, least)
            better = before > 1.1 * np.maximum(now, least)
            print(
                f"{count} glossy, {kind}: median {100 * np.median(before):.3f} % before, {100 * np.median(now):.3f} % now;"
                f" of {len(rows)} stacks {worse.sum()} worse by a tenth, {better.sum()} better"
            )
            for i in np.flatnonzero(worse):
                print(f"    {rows[i][0]} {100 * before[i]:.3f} {100 * now[i]:.3f}")


if __name__ == "__main__":
    main()
