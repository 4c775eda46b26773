# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `figures`: the paper's figures, computed, drawn and held against its sentences."""

import json
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path

from ...addon.session import say
from ...reference_py.atomic import output_folder, replacing, write_text
from ...reference_py.errors import LaminaError
from ..paper import FIGURES, FigureData, module
from ..tables import write_table


def figures(options) -> None:
    """Write NAME.csv, NAME.json and, with matplotlib, NAME.png per figure; print what holds and what does not."""
    if not 16 <= options.size <= 1024:
        raise LaminaError(f"--size {options.size}: a sphere's width in pixels; choose 16 to 1024")
    names = options.only or FIGURES
    modules = [module(name) for name in names]
    folder = output_folder(options.output)
    report = say("figures")
    pictures = _has_matplotlib(report)
    for i, (name, figure) in enumerate(zip(names, modules)):
        report(f"{100 * i // len(names):3} % {name}")
        data = figure.compute(options.size)
        _write_numbers(folder, data)
        if pictures:
            with replacing(folder / f"{name}.png") as temporary:
                figure.draw(data).savefig(temporary, pil_kwargs={"optimize": True})
        print(data.title)
        for statement in data.statements:
            print(f"  {statement.text()}")
    report(f"wrote {folder}")


def _has_matplotlib(report) -> bool:
    found = find_spec("matplotlib") is not None
    if not found:
        report("no pictures: matplotlib is not installed (pip install lamina[figures])")
    return found


def _write_numbers(folder: Path, data: FigureData) -> None:
    rows = [[value if isinstance(value, str) else f"{value:.5g}" for value in row] for row in data.rows]
    write_table(folder / f"{data.name}.csv", ("lamina figures",), data.columns, rows)
    statements = [{**asdict(s), "holds": bool(s.holds), "numbers": {k: float(f"{v:.5g}") for k, v in s.numbers.items()}} for s in data.statements]
    record = {"figure": data.title, "statements": statements}
    write_text(folder / f"{data.name}.json", json.dumps(record, indent=1, ensure_ascii=False) + "\n")
