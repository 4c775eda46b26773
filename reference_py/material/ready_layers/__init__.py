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


def label_and_source(name: str) -> tuple[str, str]:
    """What a menu shows of a ready layer, without a look at its layers. Raises LaminaError as `load`."""
    data, _ = _read(name)
    return data["name"], data["source"]


def load(name: str) -> tuple[str, str, tuple[Layer, ...]]:
    """Label, source and layers, from the top, of a ready layer. Raises LaminaError; an unknown name lists the choices."""
    data, where = _read(name)
    return data["name"], data["source"], layers_of(data, where)


def group_of(name: str) -> str:
    """Which of GROUPS a ready layer is offered in. Raises LaminaError as `load`, and where its file says another."""
    data, where = _read(name)
    if data.get("group") not in GROUPS:
        raise LaminaError("{where}: unknown group {group!r}; choose {choices}", where=where, group=data.get("group"), choices=", ".join(GROUPS))
    return data["group"]


def _read(name: str) -> tuple[dict, str]:
    """What a ready layer's file says, and its path."""
    where = FOLDER / f"{name}.json"
    if not name.isidentifier() or not where.is_file():
        raise LaminaError("unknown ready layer {name!r}; choose {choices}", name=name, choices=", ".join(names()))
    return parse_json(read_text(where, "layer file"), str(where)), str(where)


def layers_of(data: Mapping, where: str) -> tuple[Layer, ...]:
    """The layers of a dictionary, validated. Raises LaminaError naming `where`, the key, the value and the choices."""
    version = {"schema_version": data["schema_version"]} if "schema_version" in data else {}
    return Stack.from_dict({**version, "layers": data.get("layers", []), "base": {"kind": LAMBERT.name}}, where).layers
