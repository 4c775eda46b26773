# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of `osl/` with their @PLACEHOLDERS@ filled: how shader texts are assembled."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from ....reference_py.material.schema import COLOR, FLOAT, Parameter
from ....reference_py.material.stack import Element

PARTS = Path(__file__).resolve().parents[3] / "osl"
# Below this alpha a lobe takes Cycles' anisotropic path (osl/narrow.h); above it the isotropic one is within 1e-4.
NARROW_ALPHA = 0.06


def fill(name: str, **values) -> str:
    """A part's text with its placeholders replaced."""
    text = _part(name)
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


@cache
def _part(name: str) -> str:
    """A part's text without its licence line, which the assembled shader states once; of functions without the comments too.

    Those are for who reads `osl/`: texts are long as it is.
    """
    lines = (PARTS / name).read_text(encoding="utf-8").splitlines(keepends=True)
    left_out = "//" if name.endswith(".h") else "// SPDX-License-Identifier"
    return "".join(line for line in lines if not line.lstrip().startswith(left_out))


def narrow() -> str:
    return fill("narrow.h", NARROW_ALPHA=f"{NARROW_ALPHA:g}")


def declaration(osl_name: str, parameter: Parameter) -> str:
    """A shader parameter with its default."""
    if parameter.type == FLOAT:
        return f"    float {osl_name} = {parameter.default:.9g},"
    osl_type = "color" if parameter.type == COLOR else "vector"
    return f"    {osl_type} {osl_name} = {osl_type}({numbers(parameter.default)}),"


def numbers(values: Iterable[float]) -> str:
    return listed(f"{v:.9g}" for v in values)


def listed(items: Iterable[str]) -> str:
    return ", ".join(items)


def beckmann(element: Element) -> str:
    return "1" if element["distribution"] == "beckmann" else "0"


def right_nested(names: list[str]) -> str:
    """A sum of closures; Cycles drops terms of long left-nested sums."""
    head, *tail = names
    return f"{head} + ({right_nested(tail)})" if len(tail) > 1 else " + ".join(names)
