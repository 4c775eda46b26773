# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants in a Python file: read from it and written into it, all else in the file as it was."""

import ast
from collections.abc import Mapping
from pathlib import Path

from ..reference_py.atomic import write_text
from ..reference_py.errors import LaminaError

# Significant digits of what is written; the fits determine fewer.
DIGITS = 4

Value = float | tuple[float, ...]


def rounded(value: Value) -> Value:
    """The value as a file has it."""
    return tuple(map(rounded, value)) if isinstance(value, tuple) else float(f"{value:.{DIGITS}g}")


def read_constants(path: Path) -> dict[str, Value]:
    """Values of the upper-case names that a file gives plain numbers or tuples of them, in its order; of a dictionary of numbers as "NAME.key"."""
    return {name: ast.literal_eval(node) for name, node in _places(path.read_text(encoding="utf-8")).items()}


def write_constants(path: Path, values: Mapping[str, Value]) -> None:
    """Replace the values of some constants, rounded; the file is written whole or not at all. Raises LaminaError for names that it lacks."""
    text = path.read_text(encoding="utf-8")
    places = _places(text)
    if missing := [name for name in values if name not in places]:
        raise LaminaError(f"{path.name} has no constant {', '.join(missing)}; it has {', '.join(places)}")
    lines = text.splitlines(keepends=True)
    # from the end, so that what is still to be replaced stays where it was; columns count bytes
    for name, node in sorted(places.items(), key=lambda item: (item[1].lineno, item[1].col_offset), reverse=True):
        if name in values:
            line = lines[node.lineno - 1].encode()
            lines[node.lineno - 1] = (line[: node.col_offset] + repr(rounded(values[name])).encode() + line[node.end_col_offset :]).decode()
    write_text(path, "".join(lines))


def _places(text: str) -> dict[str, ast.expr]:
    """Where each constant's value stands."""
    found: dict[str, ast.expr] = {}
    for statement in ast.parse(text).body:
        if not isinstance(statement, ast.Assign):
            continue
        target, value = statement.targets[0], statement.value
        pairs = zip(target.elts, value.elts) if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) else [(target, value)]
        for name, node in pairs:
            if isinstance(name, ast.Name) and name.id.isupper():
                parts = {f"{name.id}.{key.value}": part for key, part in zip(node.keys, node.values)} if isinstance(node, ast.Dict) else {name.id: node}
                found |= {key: part for key, part in parts.items() if _is_numbers(part)}
    return found


def _is_numbers(node: ast.expr) -> bool:
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return False
    return all(type(v) in (int, float) for v in (value if isinstance(value, tuple) else (value,)))
