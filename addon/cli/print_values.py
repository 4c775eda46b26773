# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands that print numbers and need no bpy: presets, models, albedo, eval, shader."""

import json
import sys
from collections.abc import Sequence

import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.material import presets as preset_files
from ...reference_py.material.schema import SCHEMA, SCHEMA_VERSION
from ...reference_py.optics.frame import spherical
from ...reference_py.version import version
from ..session import say, tenths


def presets(options) -> None:
    """Names and first words of the sources of all presets."""
    stacks = {name: preset_files.load(name) for name in preset_files.names()}
    if options.json:
        print(json.dumps({"presets": [{"name": n, "label": s.name, "source": s.source} for n, s in stacks.items()]}))
        return
    for name, stack in stacks.items():
        layers = f"{len(stack.layers)} layer{'s' * (len(stack.layers) != 1)} over {stack.base.kind}"
        print(f"{name:20} {layers}")


def schema(options) -> None:
    """Every kind and parameter of the schema."""
    groups = {"layers": SCHEMA.layers, "base": SCHEMA.bases}
    if options.json:
        rows = {group: {k.name: {p.name: _row(p) for p in k.all_parameters} for k in kinds.values()} for group, kinds in groups.items()}
        print(json.dumps({"schema_version": SCHEMA_VERSION, **rows}))
        return
    for group, kinds in groups.items():
        for kind in kinds.values():
            print(f'{group}: "kind": "{kind.name}"   {kind.help}')
            if kind.alternatives:
                print(f"  given by one of: {', '.join(kind.given_choices)}")
            _print_parameters(kind.parameters)
            for feature in kind.features:
                print(f"  optional: {feature.help}")
                _print_parameters(feature.parameters, "  ")


def _print_parameters(parameters, indent: str = "") -> None:
    for p in parameters:
        default = list(p.default) if isinstance(p.default, tuple) else p.default
        print(f"{indent}  {p.name:13} {p.allowed:32} default {json.dumps(default):18} {p.help}")


def _row(parameter) -> dict:
    return {"type": parameter.type, "default": parameter.default, "allowed": parameter.allowed, "help": parameter.help}


def models(options) -> None:
    """The registry of models."""
    from ...reference_py.registry import MODELS  # all models are read with it

    if options.json:
        print(json.dumps({"models": [{"name": n, "stochastic": m.stochastic} for n, m in MODELS.items()]}))
        return
    for name, model in MODELS.items():
        print(f"{name:25} {(model.__doc__ or '').strip().splitlines()[0]}")


def albedo(options) -> None:
    """Directional albedo by view angle."""
    theta = view_angles(options.theta)
    model, how = model_of(options)
    wo = spherical(np.radians(theta), 0.0)
    if model.stochastic:
        value, stderr = model.albedo_stderr(wo, progress=tenths(say(options.command)))
    else:
        value, stderr = model.albedo(wo), None
    print_albedo(model.name, theta, value, stderr, options.json, how)


def print_albedo(model: str, theta: Sequence[float], value: np.ndarray, stderr: np.ndarray | None, as_json: bool, how: dict | None = None) -> None:
    """One form for what models compute and what Cycles measures."""
    if as_json:
        result = {"model": model, **(how or {}), "theta_deg": list(theta), "albedo": value.tolist()}
        print(json.dumps(result if stderr is None else {**result, "stderr": stderr.tolist()}))
        return
    print(f"{model}: share of light reflected, red green blue")
    for i, angle in enumerate(theta):
        numbers = " ".join(f"{v:.5f}" for v in value[i])
        error = "" if stderr is None else "   +- " + " ".join(f"{v:.5f}" for v in stderr[i])
        print(f"{angle:6.2f} deg   {numbers}{error}")


def eval(options) -> None:
    """f for one view and any number of light directions."""
    angles = [_numbers(text) for text in options.wi] if options.wi else light_grid(options.grid)
    wo, wi = directions([_numbers(options.wo)])[0], directions(angles)
    if options.csv and options.json:
        raise LaminaError("--csv and --json exclude each other; choose one")
    model, how = model_of(options)
    if note := getattr(model, "f_note", None):
        print(f"lamina: {note}", file=sys.stderr)
    wo_all = np.broadcast_to(wo, wi.shape)
    if model.stochastic:
        value, stderr = model.f_stderr(wo_all, wi, progress=tenths(say(options.command)))
    else:
        value, stderr = model.f(wo_all, wi), None
    if options.json:
        result = {"model": model.name, **how, "wo_deg": _numbers(options.wo), "wi_deg": angles, "f": value.tolist()}
        print(json.dumps(result if stderr is None else {**result, "stderr": stderr.tolist()}))
        return
    if options.csv:
        _print_csv(_numbers(options.wo), angles, value, stderr)
        return
    print(f"{model.name}: f in 1/sr, red green blue, wo {options.wo}")
    for i, (theta, phi) in enumerate(angles):
        error = "" if stderr is None else "   +- " + " ".join(f"{v:.3g}" for v in stderr[i])
        text = f"{theta:g},{phi:g}"
        print(f"wi {text:12}   {' '.join(f'{v:.6g}' for v in value[i])}{error}")


def _print_csv(wo: list[float], wi: Sequence[list[float]], value: np.ndarray, stderr: np.ndarray | None) -> None:
    errors = [] if stderr is None else [f"{channel}_stderr" for channel in "rgb"]
    print(",".join(["theta_o", "phi_o", "theta_i", "phi_i", *"rgb", *errors]))
    columns = [np.broadcast_to(wo, (len(wi), 2)), np.array(wi), value, *([] if stderr is None else [stderr])]
    for row in np.concatenate(columns, axis=1):
        print(",".join(f"{v:.6g}" for v in row))


def light_grid(step: float) -> list[list[float]]:
    """Angles in degrees above the surface, `step` apart: the normal once, then all azimuths of each polar angle below 90."""
    azimuths = np.arange(0.0, 360.0, step)
    return [[0.0, 0.0], *([float(theta), float(phi)] for theta in np.arange(step, 90.0, step) for phi in azimuths)]


def shader(options) -> None:
    """The generated OSL text."""
    from ...reference_py.lobes.methods import DEFAULT_METHOD, make_lobe_set
    from ..material.backend import OSL
    from ..material.limits import require_shader
    from ..shader.osl.generate import generate

    stack = load_stack(options.stack)
    require_shader(stack, OSL)
    lobe_set = make_lobe_set(stack, options.tier or DEFAULT_METHOD, progress=tenths(say(options.command)))
    sys.stdout.write(generate(lobe_set).text)


def load_stack(name_or_path: str):
    """A stack for a command; keys that it has and we do not know are named on stderr."""
    stack = preset_files.load(name_or_path)
    for message in stack.unknown_keys():
        print(f"lamina: {name_or_path}: {message}", file=sys.stderr)
    return stack


def view_angles(theta: Sequence[float]) -> list[float]:
    """Checked view angles in degrees. Raises LaminaError outside 0 to below 90."""
    for angle in theta:
        if not 0.0 <= angle < 90.0:
            raise LaminaError(f"--theta {angle:g}: a view angle is in degrees from the normal; choose 0 to below 90")
    return list(theta)


def directions(angles_deg: Sequence[list[float]]) -> np.ndarray:
    """Unit directions (n, 3) of pairs of polar angle and azimuth in degrees."""
    angles = np.radians(angles_deg)
    return spherical(angles[:, 0], angles[:, 1])


def _numbers(text: str) -> list[float]:
    try:
        theta, phi = (float(part) for part in text.split(","))
        if not (0.0 <= theta <= 180.0 and np.isfinite(phi)):
            raise ValueError
    except ValueError:
        raise LaminaError(f"direction {text!r}: give THETA,PHI in degrees, theta from 0 to 180, such as 30,90") from None
    return [theta, phi]


def model_of(options):
    """The model, and what somebody needs to get its numbers again; options that are not named are this version's defaults."""
    from ...reference_py.registry import make_model

    pairs = {"surface": options.surface} if options.surface else {}
    for text in options.option:
        key, separator, value = text.partition("=")
        if not separator:
            raise LaminaError(f"--option {text!r}: give NAME=VALUE")
        if key in pairs:
            raise LaminaError(f"--option {text!r}: {key} is given already, as {pairs[key]!r}")
        pairs[key] = value
    stack = load_stack(options.stack)
    return make_model(options.model, stack, **pairs), {"stack": stack.to_dict(), "options": pairs, "version": version()}
