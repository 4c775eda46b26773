# SPDX-License-Identifier: GPL-3.0-or-later
"""Do all models and methods still say what they said at another commit? `python -m lamina.study.compare_commits COMMIT`

Both checkouts evaluate albedo and f of every model, and the energy of every live method's lobes, for the presets of the paper and some stacks of
the suite. Prints the largest differences, as shares of the value and 1 % of the largest; exits with 1 where one is beyond `TOLERANCE`.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from ..reference_py.errors import LaminaError

ROOT = Path(__file__).parents[1]
TOLERANCE = 1e-6
# What a process begins with that runs in a checkout, its argument: names are given as the tree had them before and has them now.
START = """
import importlib, importlib.util, json, sys
root = sys.argv[1]
spec = importlib.util.spec_from_file_location("lamina", root + "/__init__.py", submodule_search_locations=[root])
sys.modules["lamina"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["lamina"])

def one_of(*names):
    for name in names:
        module, _, attribute = name.rpartition(":")
        try:
            found = importlib.import_module("lamina." + module)
        except ModuleNotFoundError:
            continue
        if hasattr(found, attribute):
            return getattr(found, attribute)
    raise SystemExit("none of " + ", ".join(names))

"""
EVALUATE = (
    START
    + """import numpy as np
load, PAPER = (one_of(f"reference_py.material.presets:{name}", f"reference_py.presets:{name}") for name in ("load", "PAPER"))
make_model = one_of("reference_py.registry:make_model", "reference_py.models:make_model")
MODELS = one_of("reference_py.registry:MODELS", "reference_py.models:MODELS")
make_lobes = one_of("reference_py.lobes.methods:make_lobe_set", "reference_py.network:make_network")
lobe_energy = one_of("reference_py.lobes.closure:lobe_energy", "reference_py.network.closure:lobe_energy")
suite = one_of("study.suite:suite", "reference_py.suite:suite")
spherical = one_of("reference_py.optics.frame:spherical", "reference_py.frame:spherical")
theta = np.radians([0.0, 40.0, 70.0, 85.0])
wo, wi = spherical(theta, 0.0), spherical(np.radians([30.0, 45.0, 20.0, 60.0]), np.radians([180.0, 150.0, 40.0, 180.0]))
stacks = {name: load(name) for name in PAPER} | dict(list(suite().items())[::9])
found = {}
for name, stack in stacks.items():
    for model in MODELS:
        if model in ("mirror", "closure_model"):
            continue
        options = {"walks": 32} if model == "position_free" else {}
        try:
            made = make_model(model, stack, **options)
            found[f"{model}, f of {name}"] = made.f(wo, wi).tolist()
            if model != "position_free":
                found[f"{model}, albedo of {name}"] = made.albedo(wo).tolist()
        except ValueError as error:
            found[f"{model}, f of {name}"] = str(type(error).__name__)
    for method in ("weidlich_wilkie", "analytic"):
        lobes = make_lobes(stack, method).lobes(np.cos(theta))
        found[f"{method}, energy of {name}"] = sum(lobe_energy(lobe, np.cos(theta)) for lobe in lobes).tolist()
print(json.dumps(found))
"""
)


def values_of(checkout: Path) -> dict[str, list]:
    """What a checkout says, by words. Raises LaminaError where it cannot."""
    done = subprocess.run([sys.executable, "-c", EVALUATE, str(checkout)], capture_output=True, text=True)
    if done.returncode:
        raise LaminaError(f"{checkout} cannot be evaluated: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def difference(before: list, after: list) -> float:
    """The largest difference of two nested lists, over the value and 1 % of the largest."""
    import numpy as np

    a, b = np.array(before, float), np.array(after, float)
    return float(np.max(np.abs(a - b) / (np.abs(a) + 0.01 * np.max(np.abs(a)) + 1e-12)))


def main() -> int:
    """Compare with the commit of the command line."""
    commit = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder, "tree")
        tree.mkdir()
        archive = subprocess.run(["git", "-C", str(ROOT), "archive", commit], check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", str(tree)], input=archive, check=True)
        before = values_of(tree)
    after = values_of(ROOT)
    worst: dict[str, tuple[float, str]] = {}
    for words in before.keys() & after.keys():
        model = words.partition(",")[0]
        worst[model] = max(worst.get(model, (0.0, words)), (difference(before[words], after[words]), words))
    for model, (gap, words) in sorted(worst.items(), key=lambda row: -row[1][0]):
        print(f"{gap:9.1e}  {words}")
    print(f"{len(before.keys() & after.keys())} figures compared with {commit}, {len(before.keys() ^ after.keys())} in one alone")
    return int(any(gap > TOLERANCE for gap, _ in worst.values()))


if __name__ == "__main__":
    sys.exit(main())
