# SPDX-License-Identifier: GPL-3.0-or-later
"""Processor seconds of one fit of a whole MERL table, 90 x 90 x 180, from the file to the error on all of its data.

    fit_table.py [TABLE.csv [COMMIT]]

Without a table it prints; with one a former commit's is run in turn with it, and both are written. On one core; nothing is asserted. The tables are made
here: a blue paint that is none of our stacks (model `lafortune`), and a varnished metal of the paper's model with 5 % of noise, both
fitted by `adding`.
"""

import os
import re
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from lamina.reference_py.fit.layer_count import select
from lamina.reference_py.fit.outcome import outcome
from lamina.reference_py.fit.readers.by_suffix import read
from lamina.reference_py.fit.readers.merl import SCALES, cell_directions
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.registry import make_model

FORMER = "324623f"
COLUMNS = ("table", "former_s", "now_s", "ratio", "former_error_percent", "now_error_percent")
SIZES = (90, 90, 180)
VARNISH = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.35, "tint": [0.9, 0.7, 0.5]}],
        "base": {"kind": "conductor", "metal": "aluminium", "roughness": 0.6},
    }
)
TABLES = {"blue paint": ("lafortune", presets.load("blue_wall_paint"), 0.0), "varnished metal": ("weidlich_wilkie", VARNISH, 0.05)}


def write(path: Path, model: str, stack: Stack, noise: float) -> None:
    """A MERL file of a model's f; cells below the horizon are -1."""
    wi, wo = cell_directions(SIZES)
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    values = np.full((3, len(wi)), -1.0)
    f = make_model(model, stack).f(wo[above], wi[above])
    values[:, above] = (f * np.maximum(1.0 + noise * np.random.default_rng(0).standard_normal(f.shape), 0.0) / SCALES).T
    path.write_bytes(struct.pack("<3i", *SIZES) + values.astype("<f8").tobytes())


def compare(table: Path, former: str) -> None:
    """Write what this tree and a former commit print, processor seconds and errors."""
    from lamina.study.stamp import ROOT
    from lamina.study.tables import write_table

    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "lamina"
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", ROOT, tree], check=True)
        subprocess.run(["git", "-C", tree, "checkout", "--quiet", former], check=True)
        told = [printed(tree, {"PYTHONPATH": folder}), printed(ROOT, {})]
    rows = [
        [name, *(f"{told[i][name][0]:.1f}" for i in (0, 1)), f"{told[0][name][0] / told[1][name][0]:.1f}", *(f"{told[i][name][1]:.2f}" for i in (0, 1))]
        for name in TABLES
    ]
    write_table(table, ("make fit-table", f"beside {former}", "one core, processor seconds of a whole fit"), COLUMNS, rows, print)


def printed(tree: Path, more: dict[str, str]) -> dict[str, tuple[float, float]]:
    """By table, seconds and per cent of error that the script of a tree prints."""
    environment = os.environ | more | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    text = subprocess.run([sys.executable, str(tree / "tests/benchmarks/fit_table.py")], env=environment, check=True, capture_output=True, text=True).stdout
    print(text, end="", flush=True)
    return {
        name.strip(): (float(seconds), float(error)) for name, seconds, error in re.findall(r"^  (.+?) +([\d.]+) s: .* error ([\d.]+) %$", text, re.MULTILINE)
    }


def main() -> None:
    if sys.argv[1:]:
        compare(Path(sys.argv[1]), (*sys.argv[2:], FORMER)[0])
        return
    print(f"one fit of a {' x '.join(map(str, SIZES))} table by adding, auto layers and base, processor seconds")
    for name, (model, stack, noise) in TABLES.items():
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "table.binary"
            write(path, model, stack, noise)
            start = time.process_time()
            measurement = read(path)
            loaded = time.process_time()
            selection = select(measurement)
            fitted = time.process_time()
            told = outcome(measurement, selection)
            end = time.process_time()
        print(
            f"  {name:16} {end - start:5.1f} s: reading {loaded - start:.1f}, fitting {fitted - loaded:.1f}, error on all "
            f"{told['pairs']} pairs {end - fitted:.1f}; {selection.best.structure.name}, error {100.0 * told['error']:.2f} %",
            flush=True,
        )


if __name__ == "__main__":
    main()
