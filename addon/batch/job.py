# SPDX-License-Identifier: GPL-3.0-or-later
"""The job file of `lamina batch` and `lamina farm`, checked against one description of its keys, `KEYS`. Needs no bpy."""

import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.methods import DEFAULT_METHOD, METHODS, method_of
from ...reference_py.material import presets
from ...reference_py.material.json_input import parse_json, read_text
from ...reference_py.material.stack import Stack
from ..material.backend import BACKENDS, DEFAULT_BACKEND

JOB_VERSION = 1
BALL = "ball"
MAX_VALUES = 100_000
MAX_SECONDS = 1_000_000
MAX_FRAME = 999_999  # six digits, as in _RANGE
_RANGE = re.compile(r"(-?\d{1,6})(?:-(-?\d{1,6}))?(?:x(\d{1,6}))?")
_PARAMETER = re.compile(r"layers\[(\d{1,3})\]\.(\w+)|base\.(\w+)")
REQUIRED = object()


@dataclass(frozen=True)
class Look:
    """A stack and the name that it has in this job."""

    name: str
    stack: Stack


@dataclass(frozen=True)
class Sweep:
    """Values that one parameter of every stack takes; `layer` is None for the base's."""

    parameter: str
    layer: int | None
    key: str
    values: tuple


@dataclass(frozen=True)
class Scene:
    """The studio's ball (`blend` is empty), or an object of a .blend file in the job's folder."""

    name: str
    blend: str = ""
    object: str = ""


@dataclass(frozen=True)
class Key:
    """One key of a job file: `check(value, where, folder)` gives its canonical value or raises LaminaError."""

    name: str
    check: Callable
    default: object
    help: str


@dataclass(frozen=True)
class Job:
    """A job as its file means it. `folder` is the file's: what the job names lies there or below."""

    folder: Path
    name: str
    stacks: tuple[Look, ...]
    sweeps: tuple[Sweep, ...]
    qualities: tuple[str, ...]
    backend: str
    scenes: tuple[Scene, ...]
    views: tuple[float, ...]
    frames: tuple[int, ...]
    samples: int | None
    size: tuple[int, int] | None
    seed: int
    time_limit: float | None

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Job":
        """Read a job file. Raises LaminaError naming the key, the value and the choices."""
        return cls.from_json(read_text(path, "job file"), path)

    @classmethod
    def from_json(cls, text: str, path: str | os.PathLike) -> "Job":
        """The job of a text that stands in the file `path`."""
        path = Path(path)
        data = parse_json(text, str(path))
        if not isinstance(data, Mapping):
            raise LaminaError(f"{path}: a job is a JSON object with 'stacks', not {type(data).__name__}")
        for old, new in OLD_KEYS.items():
            if old in data and new not in data:
                data = {new if name == old else name: value for name, value in data.items()}
        names = [key.name for key in KEYS]
        for name in data:
            if name not in names:
                close = get_close_matches(name.lower(), names, 1)
                raise LaminaError(f"{path}: unknown key {_short(name)}; {f'did you mean {close[0]!r}?' if close else 'choose ' + ', '.join(names)}")
        values = {}
        for key in KEYS:
            given = data.get(key.name, key.default)
            if given is REQUIRED:
                raise LaminaError(f"{path}: a job needs {key.name!r}, {key.help}")
            values[key.name] = key.check(given, f"{path}: {key.name}", path.parent)
        del values["lamina_job"]
        values["name"] = values["name"] or path.stem
        return cls(folder=path.parent, **values)


def _short(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _version(value, where: str, _folder: Path) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise LaminaError(f"{where} {_short(value)} is no version; this Lamina reads {JOB_VERSION}")
    if value > JOB_VERSION:
        raise LaminaError(f"{where} {value} is newer than this Lamina, which reads {JOB_VERSION}")
    return value


def _text(value, where: str, _folder: Path) -> str:
    if not isinstance(value, str):
        raise LaminaError(f"{where} must be text, not {_short(value)}")
    return value


def _whole(low: int, high: int):
    def check(value, where: str, _folder: Path):
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise LaminaError(f"{where} is {_short(value)}; choose a whole number from {low} to {high}")
        return value

    return check


def _or_own(check):
    """None leaves it to the scene."""
    return lambda value, where, folder: None if value is None else check(value, where, folder)


def _size(value, where: str, folder: Path) -> tuple[int, int]:
    check = _whole(2, 16_384)
    if isinstance(value, list):
        if len(value) != 2:
            raise LaminaError(f"{where} must be one number or [width, height], not {_short(value)}")
        return check(value[0], f"{where}[0]", folder), check(value[1], f"{where}[1]", folder)
    return (check(value, where, folder),) * 2


def _list_of(check, least: int = 1):
    def check_list(value, where: str, folder: Path) -> tuple:
        if not isinstance(value, list) or len(value) < least:
            raise LaminaError(f"{where} must be a list{' of at least one' if least else ''}, not {_short(value)}")
        if len(value) > MAX_VALUES:
            raise LaminaError(f"{where} has {len(value)} entries; at most {MAX_VALUES}")
        made = tuple(check(v, f"{where}[{i}]", folder) for i, v in enumerate(value))
        seen = set()
        for i, entry in enumerate(made):
            name = entry.name if isinstance(entry, (Look, Scene)) else entry.parameter if isinstance(entry, Sweep) else entry
            if name in seen:
                raise LaminaError(f"{where}[{i}]: {_short(name)} is there already; give each a name of its own")
            seen.add(name)
        return made

    return check_list


def inside(value: str, where: str, folder: Path) -> Path:
    """The file that a job names, which lies in the job's folder or below. Raises LaminaError."""
    try:
        home = folder.resolve()
        path = (home / value).resolve()
        within, there = path.is_relative_to(home), path.is_file()
    except (OSError, ValueError, RuntimeError) as error:
        raise LaminaError(f"{where}: {_short(value)} is no name of a file: {getattr(error, 'strerror', None) or error}") from None
    if not within:
        raise LaminaError(f"{where}: {_short(value)} is outside of the job's folder {home}; put it there, beside the job file")
    if not there:
        raise LaminaError(f"{where}: {_short(value)} is no file in the job's folder {home}")
    return path


def _fields(value: Mapping, where: str, names: tuple[str, ...], optional: tuple[str, ...] = ()) -> None:
    missing, odd = [n for n in names if n not in value], [n for n in value if n not in names + optional]
    if missing:
        raise LaminaError(f"{where}: {', '.join(missing)} is missing; it has the keys {', '.join(names + optional)}")
    if odd:
        raise LaminaError(f"{where}: unknown key {_short(odd[0])}; choose {', '.join(names + optional)}")


def _look(value, where: str, folder: Path) -> Look:
    if isinstance(value, Mapping):
        _fields(value, where, ("name", "stack"))
        name = _text(value["name"], f"{where}: name", folder)
        if isinstance(value["stack"], Mapping):
            return Look(name, _known(Stack.from_dict(value["stack"], where), where))
        return Look(name, _stack(value["stack"], where, folder))
    return Look(Path(_text(value, where, folder)).stem, _stack(value, where, folder))


def _stack(value, where: str, folder: Path) -> Stack:
    text = _text(value, where, folder)
    if text in presets.names():
        return presets.load(text)
    if not text.endswith(".json"):
        raise LaminaError(f"{where}: unknown preset {_short(text)}; choose {', '.join(presets.names())}, or a .json file in the job's folder")
    return _known(Stack.load(inside(text, where, folder)), where)


def _known(stack: Stack, where: str) -> Stack:
    """Nobody reads warnings of a batch: what has no effect is refused."""
    if messages := stack.unknown_keys():
        raise LaminaError(f"{where}: {messages[0]}")
    return stack


def _sweep(value, where: str, folder: Path) -> Sweep:
    if not isinstance(value, Mapping):
        raise LaminaError(f"{where} must be an object with 'parameter' and 'values', not {_short(value)}")
    stepped = "values" not in value
    _fields(value, where, ("parameter", "from", "to", "steps") if stepped else ("parameter", "values"))
    parameter = _text(value["parameter"], f"{where}: parameter", folder)
    match = _PARAMETER.fullmatch(parameter)
    if match is None:
        raise LaminaError(f"{where}: parameter {_short(parameter)}: write it like layers[0].roughness or base.color; layer 0 is the top")
    values = _steps(value, where, folder) if stepped else value["values"]
    if not isinstance(values, list) or not values or len(values) > MAX_VALUES:
        raise LaminaError(f"{where}: values must be a list of 1 to {MAX_VALUES} values, not {_short(values)}")
    layer = None if match[1] is None else int(match[1])
    return Sweep(parameter, layer, match[2] or match[3], tuple(values))


def _steps(value: Mapping, where: str, folder: Path) -> list[float]:
    ends = [value["from"], value["to"]]
    if not all(_is_number(v) for v in ends):
        raise LaminaError(f"{where}: from and to must be numbers, not {_short(ends)}")
    steps = _whole(2, MAX_VALUES)(value["steps"], f"{where}: steps", folder)
    return [round(ends[0] + (ends[1] - ends[0]) * i / (steps - 1), 12) for i in range(steps)]


def _is_number(value) -> bool:
    """Whether it is a number that a float can hold."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300


def _tier(value, where: str, folder: Path) -> str:
    try:
        return method_of(_text(value, where, folder)).name
    except LaminaError as error:
        raise LaminaError(f"{where}: {error}") from None


def _backend(value, where: str, folder: Path) -> str:
    if _text(value, where, folder) not in BACKENDS:
        raise LaminaError(f"{where}: unknown backend {_short(value)}; choose {', '.join(BACKENDS)}")
    return value


def _scene(value, where: str, folder: Path) -> Scene:
    if value == BALL:
        return Scene(BALL)
    if not isinstance(value, Mapping):
        raise LaminaError(f'{where} is {_short(value)}; choose "{BALL}" or {{"blend": FILE, "object": NAME}}')
    _fields(value, where, ("blend", "object"), ("name",))
    blend = _text(value["blend"], f"{where}: blend", folder)
    if not blend.endswith(".blend"):
        raise LaminaError(f"{where}: blend {_short(blend)} must end in .blend")
    inside(blend, where, folder)
    target = _text(value["object"], f"{where}: object", folder)
    return Scene(_text(value.get("name", f"{Path(blend).stem}_{target}"), f"{where}: name", folder), blend, target)


def _view(value, where: str, _folder: Path) -> float:
    if not _is_number(value) or not math.isfinite(value) or abs(value) > 360:
        raise LaminaError(f"{where} is {_short(value)}; choose degrees from -360 to 360 by which the camera goes around the object")
    return float(value)


def _seconds(value, where: str, _folder: Path) -> float:
    if not _is_number(value) or not 0 < value <= MAX_SECONDS:
        raise LaminaError(f"{where} is {_short(value)}; choose seconds, more than 0 and at most {MAX_SECONDS}, or null for no limit")
    return float(value)


def _frames(value, where: str, folder: Path) -> tuple[int, ...]:
    frames: list[int] = []
    for i, entry in enumerate(value if isinstance(value, list) else [value]):
        if isinstance(entry, int) and not isinstance(entry, bool):
            entry = str(entry) if abs(entry) <= MAX_FRAME else ""
        match = _RANGE.fullmatch(entry) if isinstance(entry, str) else None
        if match is None:
            raise LaminaError(
                f"{where}: {_short(value if not isinstance(value, list) else value[i])} is no frame; "
                f'write numbers from -{MAX_FRAME} to {MAX_FRAME} and ranges such as 1, "1-24" or "1-24x2"'
            )
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if step < 1 or last < first:
            raise LaminaError(f"{where}: {_short(entry)} has no frames; write FIRST-LAST or FIRST-LASTxSTEP")
        if len(frames) + (last - first) // step > MAX_VALUES:
            raise LaminaError(f"{where} are more than {MAX_VALUES}")
        frames += range(first, last + 1, step)
    if not frames:
        raise LaminaError(f"{where} must name at least one frame")
    return tuple(dict.fromkeys(frames))


# What keys were called before; such jobs are still read.
OLD_KEYS = {"tiers": "qualities"}

KEYS = (
    Key("lamina_job", _version, JOB_VERSION, "version of this file's form"),
    Key("name", _text, "", "title of the contact sheet"),
    Key("stacks", _list_of(_look), REQUIRED, 'presets, .json files in the job\'s folder, or {"name": TEXT, "stack": {...}}'),
    Key("sweeps", _list_of(_sweep, 0), [], '{"parameter": "layers[0].roughness", "values": [...]}, or with "from", "to" and "steps"; all are combined'),
    Key("qualities", _list_of(_tier), [DEFAULT_METHOD], "how Cycles is told: " + ", ".join(reversed(METHODS))),
    Key("backend", _backend, DEFAULT_BACKEND, ", ".join(BACKENDS)),
    Key("scenes", _list_of(_scene), [BALL], '"ball", or {"blend": FILE, "object": NAME} for an object of a .blend in the job\'s folder'),
    Key("views", _list_of(_view), [0.0], "degrees by which the camera goes around the object"),
    Key("frames", _frames, [1], 'frames: 1, "1-24" or "1-24x2"'),
    Key("samples", _or_own(_whole(1, 1_000_000)), None, "samples per pixel (64 for the ball, else the .blend's own)"),
    Key("size", _or_own(_size), None, "pixels: width, or [width, height] (256 for the ball, else the .blend's own)"),
    Key("seed", _whole(0, 2_000_000_000), 0, "of the noise; frame n has seed + n"),
    Key("time_limit", _or_own(_seconds), None, "seconds that one picture may take, its bake included; what takes longer is ended and has failed"),
)
