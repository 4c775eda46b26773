# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina export`: a stack as a table of the truth for other renderers and for fits, its error stated."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.writers import error, merl, rgl
from ...reference_py.exchange.writers.truth import Progress, Truth
from ...reference_py.fit.readers.rgl import Material
from ...reference_py.material.stack import Stack
from ...reference_py.version import version
from ..session import say, tenths
from .numbers import load_stack


@dataclass(frozen=True)
class _Format:
    """A row of FORMATS: refuses a stack it cannot hold, writes a table, and reads it back at directions (wi, wo)."""

    suffix: str
    refuse: Callable[[Stack], None]
    write: Callable[[Truth, Path, Progress], None]
    read_back: Callable[[Path], Callable[[np.ndarray, np.ndarray], np.ndarray]]


def _write_merl(truth: Truth, path: Path, progress: Progress) -> None:
    merl.write(merl.table(truth, progress), path)


def _write_rgl(truth: Truth, path: Path, progress: Progress) -> None:
    rgl.write(rgl.fields(truth, f"{truth.stack.name or 'a stack'}: {truth.name} of lamina {version()}", progress), path)


FORMATS = {
    "merl": _Format(".binary", merl.require_holdable, _write_merl, lambda path: lambda wi, wo: merl.lookup(path, wi, wo)),
    "rgl": _Format(".bsdf", rgl.require_holdable, _write_rgl, lambda path: Material.load(path).f),
}


def export(options) -> None:
    """Write the file, and print what it is made of and its error."""
    form, path, report = FORMATS[options.to], Path(options.output), say(options.command)
    if path.suffix.lower() != form.suffix:
        raise LaminaError(f"-o {path}: --to {options.to} writes a file that ends in {form.suffix}")
    require_writable(path)
    stack = load_stack(options.stack)
    form.refuse(stack)
    truth = Truth(stack, options.walks, options.surface)
    for note in filter(None, (truth.note, f"{truth.name} walks {options.walks} times for each value" if truth.stochastic else None)):
        report(note)
    form.write(truth, path, tenths(report))
    report("reading it back")
    print(f"{path}: {truth.name} of {stack.name or options.stack}; {error.of_table(truth, form.read_back(path))}")
