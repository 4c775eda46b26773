# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina export`: a stack for other renderers and for fits, as a table of the truth whose error is stated, or as explicit layers."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.writers import csv_table, error, merl, mitsuba, pbrt, rgl
from ...reference_py.exchange.writers.truth import Progress, Truth, is_isotropic
from ...reference_py.fit.readers.rgl import Material
from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import reflectance_to_rgb
from ...reference_py.version import version
from ..session import say, tenths
from .print_values import load_stack

LAYERS = "layers"
# Degrees between the rows of a .csv, which for anisotropic stacks has an angle more.
_STEP_DEG, _ANISOTROPIC_STEP_DEG = 5.0, 10.0


@dataclass(frozen=True, eq=False, repr=False)
class _Table:
    """Refuses a stack it cannot hold; makes what it holds; writes that; reads a file back, at directions (wi, wo)."""

    suffix: str
    refuse: Callable[[Stack], None]
    make: Callable
    write: Callable
    read_back: Callable[[Path], Callable[[np.ndarray, np.ndarray], np.ndarray]]


def _rgl(spectral: bool) -> _Table:
    def make(truth: Truth, options, progress: Progress):
        return rgl.fields(truth, f"{truth.stack.name or 'a stack'}: {truth.name} of lamina {version()}", progress, spectral)

    def read_back(path: Path):
        material = Material.load(path)
        return (lambda wi, wo: reflectance_to_rgb(material.f(wi, wo), material.wavelength_nm)) if spectral else material.f

    return _Table(".bsdf", rgl.require_holdable, make, rgl.write, read_back)


def _csv(truth: Truth, options, progress: Progress) -> str:
    step = options.step or (_STEP_DEG if is_isotropic(truth.stack) else _ANISOTROPIC_STEP_DEG)
    return csv_table.text(truth, step, progress)


TABLES = {
    "merl": _Table(".binary", merl.require_holdable, lambda truth, options, progress: merl.table(truth, progress), merl.write, merl.reader),
    "rgl": _rgl(spectral=False),
    "csv": _Table(".csv", csv_table.require_holdable, _csv, csv_table.write, lambda path: csv_table.Interpolation(path).f),
}


@dataclass(frozen=True)
class _Scene:
    """Text for a renderer: of a table, by a name and the file's, or of a stack as layers."""

    suffix: str
    table: _Table
    measured: Callable[[str, str], str]
    layers: Callable[[Stack], str]


SCENES = {
    "mitsuba": _Scene(".xml", TABLES["rgl"], mitsuba.measured_scene, mitsuba.slab_scene),
    "pbrt": _Scene(".pbrt", _rgl(spectral=True), pbrt.measured_material, pbrt.layered_material),
}


def export(options) -> None:
    """Write the file, and print what it is made of and its error."""
    scene, path, report = SCENES.get(options.to), Path(options.output), say(options.command)
    form = scene.table if scene else TABLES[options.to]
    suffix = scene.suffix if scene else form.suffix
    if path.suffix.lower() != suffix:
        raise LaminaError(f"-o {path}: --to {options.to} writes a file that ends in {suffix}")
    _refuse_what_has_no_effect(options)
    table = path.with_suffix(form.suffix)
    for file in {path} if options.form == LAYERS else {path, table}:
        require_writable(file)
    stack = load_stack(options.stack)
    name = stack.name or Path(options.stack).stem
    if scene and options.form == LAYERS:
        write_text(path, scene.layers(stack))
        print(f"{path}: {name} as layers with single facets; compare with lamina albedo {options.stack} --surface single")
        return
    _write_table(form, stack, table, options, report)
    if scene:
        write_text(path, scene.measured(name, table.name))
        print(f"{path}: a scene with {table.name}")


def _refuse_what_has_no_effect(options) -> None:
    if options.form and options.to not in SCENES:
        raise LaminaError(f"--as {options.form} goes with --to {' or '.join(SCENES)}, not with {options.to}")
    if options.form == LAYERS and options.surface == "multiple":
        raise LaminaError("--as layers has the renderer's own facets, which light meets once: leave out --surface multiple")
    if options.step and options.to != "csv":
        raise LaminaError(f"--step goes with --to csv, not with {options.to}")


def _write_table(form: _Table, stack: Stack, path: Path, options, report) -> None:
    form.refuse(stack)
    truth = Truth(stack, options.walks, options.surface)
    for note in filter(None, (truth.note, f"{truth.name}: {options.walks} walks for each value" if truth.stochastic else None)):
        report(note)
    form.write(form.make(truth, options, tenths(report)), path)
    report("reading it back")
    print(f"{path}: {truth.name} of {stack.name or options.stack}; {error.of_table(truth, form.read_back(path))}")
