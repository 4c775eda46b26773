# SPDX-License-Identifier: GPL-3.0-or-later
"""Command that converts a stack to Principled or OpenPBR, and a MaterialX file to a stack."""

import json
from pathlib import Path

from ...reference_py.atomic import require_writable, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.materialx import SUFFIX, load_mtlx, save_mtlx
from ...reference_py.exchange.openpbr import to_openpbr
from ...reference_py.exchange.principled import to_principled
from ...reference_py.exchange.report import shown
from ..session import say
from .numbers import load_stack

PRINCIPLED, OPENPBR = "principled", "openpbr"
_SUFFIXES = {PRINCIPLED: ".json", OPENPBR: SUFFIX}


def convert(options) -> None:
    """Values or a file, and the report on stdout."""
    if options.output:
        require_writable(options.output)
    if Path(options.source).suffix.lower() == SUFFIX:
        _import(options)
        return
    if not options.to:
        raise LaminaError(f"convert {options.source}: give --to {PRINCIPLED} or --to {OPENPBR}; only a {SUFFIX} file needs none")
    _require_suffix(options.output, _SUFFIXES[options.to])
    stack = load_stack(options.source)
    converted = (to_principled if options.to == PRINCIPLED else to_openpbr)(stack)
    for name, value in converted.values.items():
        print(f"{name:30} {shown(value)}")
    _print(converted.report)
    if options.output:
        if options.to == OPENPBR:
            save_mtlx(converted.values, stack.name, options.output)
        else:
            write_text(options.output, json.dumps({"values": converted.values, "report": converted.report.lines()}, indent=2) + "\n")
        say("convert")(f"wrote {options.output}")


def _import(options) -> None:
    if options.to:
        raise LaminaError(f"--to {options.to}: a {SUFFIX} file becomes a stack; leave out --to")
    if not options.output:
        raise LaminaError(f"{options.source}: give -o STACK.json, the stack file to write")
    _require_suffix(options.output, ".json")
    material = _chosen(load_mtlx(options.source), options)
    converted = material.to_stack(without=frozenset(material.images))
    _print(converted.report)
    converted.stack.save(options.output)
    say("convert")(f"wrote {options.output}")


def _chosen(materials: list, options):
    """The material that --material names, or the first."""
    names = [material.name for material in materials]
    if options.material and options.material not in names:
        raise LaminaError(f"--material {options.material}: {options.source} has {', '.join(names)[:300]}")
    chosen = materials[names.index(options.material) if options.material else 0]
    if len(materials) > 1:
        say("convert")(f"{chosen.name}, one of {len(materials)} materials; --material takes another: {', '.join(n for n in names if n != chosen.name)[:300]}")
    return chosen


def _print(report) -> None:
    print(*report.lines(), sep="\n")


def _require_suffix(path: str | None, suffix: str) -> None:
    if path and Path(path).suffix.lower() != suffix:
        raise LaminaError(f"-o {path}: unknown ending {Path(path).suffix!r}; choose a name that ends in {suffix}")
