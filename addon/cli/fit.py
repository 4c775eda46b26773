# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina fit`: measured reflectance in, an editable stack out, with its error."""

import json
import sys
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path

from ...reference_py.atomic import replacing, require_writable, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.fit.compare import compare, of_fit
from ...reference_py.fit.forward import evaluate
from ...reference_py.fit.layer_count import require_choices, select
from ...reference_py.fit.outcome import lines, outcome
from ...reference_py.fit.readers import SUFFIXES
from ...reference_py.fit.readers.by_suffix import read
from ...reference_py.fit.readers.measurement import STEEPEST_DEG, Measurement
from ...reference_py.fit.readers.sampled import PAIRS, sample_model
from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ...reference_py.registry import MODELS
from ..session import say, tenths

_PICTURES = (".png", ".svg", ".pdf")
_MOST_ANGLES = 6


def fit(options) -> None:
    """Write the fitted stack, and the picture if asked for; print errors and what the data do not determine."""
    report = say(options.command)
    for option, path, suffixes in (("-o", options.output, (".json",)), ("--report", options.report, _PICTURES)):
        if not path:
            continue
        if Path(path).suffix.lower() not in suffixes:
            raise LaminaError(f"{option} {path}: choose a name that ends in {', '.join(suffixes)}")
        if Path(path).resolve() == Path(options.file).resolve():
            raise LaminaError(f"{option} {path}: this is what is read; choose another name")
        require_writable(path)
    require_choices(options.layers, options.base, options.model, options.samples, options.cloudy)
    if options.report:
        _require_matplotlib()
    if options.theta is not None and not (len(options.theta) <= _MOST_ANGLES and all(0.0 <= angle <= STEEPEST_DEG for angle in options.theta)):
        raise LaminaError(f"--theta {' '.join(f'{a:g}' for a in options.theta)}: choose up to {_MOST_ANGLES} angles from 0 to {STEEPEST_DEG:g} degrees")
    measurement, stack = _measurement(options, report)
    for sentence in measurement.found:
        report(sentence)
    selection = select(
        measurement, options.layers, options.base, options.model, options.samples, options.seed, tenths(report), report, options.cloudy,
    )  # fmt: skip
    result = outcome(measurement, selection)
    if not result["explains"]:
        report(
            f"no stack that was tried explains this measurement: the best is {100.0 * result['error']:.0f} % off "
            "(all that were tried are isotropic, and reflect no more than they receive)"
        )
    for warning in result["warnings"]:
        report(f"warning: {warning}")
    if options.output:
        write_text(options.output, selection.best.stack.to_json())
        report(f"wrote {options.output}")
    if options.report:
        _draw(options, measurement, selection.best, stack)
        report(f"wrote {options.report}")
    if not options.json:
        print("\n".join(lines(result)))
    if options.compare:
        report("comparing with other models")
        rows, _ = compare(measurement, selection.best, options.seed)
        result["comparison"] = [asdict(row) for row in rows]
        for row in () if options.json else rows:
            print(f"  {row.name:40} {row.parameters:3d} parameters   error {100.0 * row.error:6.2f} %   L1 {100.0 * row.shape:6.2f} %")
    if options.json:
        print(json.dumps(result))


def _measurement(options, report) -> tuple[Measurement, Stack | None]:
    """The data, and the stack that they are samples of."""
    if options.sample is None:
        if Path(options.file).suffix.lower() == ".json" or options.file in presets.names():
            raise LaminaError(
                f"{options.file} is a stack, not a measurement; give --sample MODEL to fit samples of a model of it, "
                f"or a file that ends in {', '.join(SUFFIXES)}"
            )
        return read(options.file, options.wavelength, options.steepest), None
    if options.sample not in MODELS:
        raise LaminaError(f"--sample {options.sample}: unknown model; choose {', '.join(MODELS)}")
    stack = presets.load(options.file)
    report(f"taking {PAIRS} samples of the model {options.sample}{', which walks: this takes minutes' if MODELS[options.sample].stochastic else ''}")
    return sample_model(options.sample, stack, options.wavelength, seed=options.seed), stack


def _require_matplotlib() -> None:
    if find_spec("matplotlib") is None:
        raise LaminaError(f"--report needs matplotlib, which this Python has not; install it: {sys.executable} -m pip install matplotlib")


def _draw(options, measurement: Measurement, best, stack: Stack | None) -> None:
    from ...reference_py.fit.fit_picture import INCIDENT_DEG, picture

    truth = None
    if stack is not None and options.wavelength is None:

        def truth(wi, wo):
            return evaluate(options.sample, {}, stack, wo, wi, 3)

    with replacing(options.report) as temporary:
        picture(measurement, best, of_fit(best), truth, angles=options.theta or INCIDENT_DEG).savefig(temporary)
