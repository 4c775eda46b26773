# SPDX-License-Identifier: GPL-3.0-or-later
"""Ready layers: one JSON file each, named by its file, with the source of its numbers.

A file is a stack without a base: "layers" from the top, all of which are put on a stack at once, and the "group" that it is
offered in.
"""

from collections.abc import Mapping
from pathlib import Path

from ...errors import LaminaError
from ..json_input import parse_json, read_text
from ..schema import LAMBERT
from ..stack import Layer, Stack

FOLDER = Path(__file__).parent
GROUPS = ("coats", "glazes", "metals", "dirt", "wear")


def names() -> list[str]:
    """Names of all ready layers, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load(name: str) -> tuple[str, str, tuple[Layer, ...]]:
    """Label, source and layers, from the top, of a ready layer. Raises LaminaError; an unknown name lists the choices."""
    if name not in names():
        raise LaminaError(f"unknown ready layer {name!r}; choose {', '.join(names())}")
    data = _read(name)
    return data["name"], data["source"], layers_of(data, str(_path(name)))


def group_of(name: str) -> str:
    """Which of GROUPS a ready layer is offered in. Raises LaminaError where its file says another."""
    group = _read(name).get("group")
    if group not in GROUPS:
        raise LaminaError(f"{_path(name)}: unknown group {group!r}; choose {', '.join(GROUPS)}")
    return group


def _path(name: str) -> Path:
    return FOLDER / f"{name}.json"


def _read(name: str) -> Mapping:
    return parse_json(read_text(_path(name), "layer file"), str(_path(name)))


def layers_of(data: Mapping, where: str) -> tuple[Layer, ...]:
    """The layers of a dictionary, validated. Raises LaminaError naming `where`, the key, the value and the choices."""
    version = {"schema_version": data["schema_version"]} if "schema_version" in data else {}
    return Stack.from_dict({**version, "layers": data.get("layers", []), "base": {"kind": LAMBERT.name}}, where).layers
