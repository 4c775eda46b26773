# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks: what a tier writes for one stack, and how one or several of them, for the patches of a surface, make a shader."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ....reference_py.material.schema import COLOR, FLOAT, Parameter
from ..inputs import PRIMARIES, ShaderInput
from .parts import functions

PRIMARY_ARGUMENTS = ", ".join(PRIMARIES)
# What the output "Live" of every shader is. A muted node passes one of its inputs on instead, and none can have this value.
LIVE = -7.0


@dataclass(frozen=True)
class Closure:
    """A weighted closure: expressions of OSL.

    Where `is_local`, `closure` uses what the block's body declares. Otherwise it is the same wherever it is written
    in the shader, and the weights of equal ones are summed. An empty weight is 1.
    """

    weight: str
    closure: str
    is_local: bool = False


@dataclass(frozen=True)
class Block:
    """A stack's part of a shader: the files of `osl/` that it calls, array parameters and statements at the top (of all three,
    equal ones are written once), then statements for the weights, then the closures."""

    functions: tuple[str, ...]
    arrays: tuple[str, ...]
    common: tuple[str, ...]
    body: tuple[str, ...]
    closures: tuple[Closure, ...]


@dataclass(frozen=True)
class Share:
    """Which share of the surface a block has: layers by owner, and whether they are there."""

    covered: tuple[tuple[str, bool], ...]

    @property
    def expression(self) -> str:
        return " * ".join(f"cover_{owner}" if there else f"(1.0 - cover_{owner})" for owner, there in self.covered)


def shader_text(title: str, note: str, parts: Sequence[tuple[Share, Block]], inputs: Sequence[ShaderInput]) -> tuple[str, int]:
    """The text of a shader, its name still @SHADER@, and its number of closures."""
    blocks = [block for _, block in parts]
    body, terms = _alone(blocks[0]) if len(parts) == 1 else _mixed(parts)
    covers = [f"float cover_{owner} = clamp({owner}Coverage, 0.0, 1.0);" for owner in dict.fromkeys(owner for share, _ in parts for owner, _ in share.covered)]
    colors = [i.osl_name for i in inputs if i.parameter.type == COLOR]
    read = [f"color {name}_rec709 = from_working({name}, {PRIMARY_ARGUMENTS});" for name in colors]
    common = _once([*covers, *(text for block in blocks for text in block.common)])
    primaries = [f"    color {name} = color({numbers([float(i == j) for j in range(3)])})," for i, name in enumerate(PRIMARIES)]
    declared = [_declaration(i.osl_name, i.parameter) for i in inputs]
    arrays = [f"    {array}," for array in _once([array for block in blocks for array in block.arrays])]
    lines = [
        "// SPDX-License-Identifier: GPL-3.0-or-later",
        f"// {title}",
        f"// Generated; edit the stack, not this text. {note}",
        functions(["working_space.h", *(name for block in blocks for name in block.functions)]),
        "shader @SHADER@(",
        *primaries,
        *declared,
        *arrays,
        f"    output float Live = {LIVE:.1f},",
        "    output closure color BSDF = 0)",
        "{",
        *(f"    {line}" for line in (*read, *_in_rec709([*common, *body], colors))),
        "    // Nested to the right: Cycles drops terms of long left-nested sums.",
        f"    BSDF = {_right_nested(terms)};",
        "}",
    ]
    return "\n".join(lines) + "\n", len(terms)


def numbers(values: Iterable[float]) -> str:
    return ", ".join([f"{v:.9g}" for v in values])


def _declaration(osl_name: str, parameter: Parameter) -> str:
    """A shader parameter with its default."""
    if parameter.type == FLOAT:
        return f"    float {osl_name} = {parameter.default:.9g},"
    osl_type = "color" if parameter.type == COLOR else "vector"
    return f"    {osl_type} {osl_name} = {osl_type}({numbers(parameter.default)}),"


def _right_nested(names: list[str]) -> str:
    head, *tail = names
    return f"{head} + ({_right_nested(tail)})" if len(tail) > 1 else " + ".join(names)


def _in_rec709(lines: list[str], colors: list[str]) -> list[str]:
    """Statements that read the model's colors in place of the sockets'."""
    return [re.sub(rf"\b({'|'.join(colors)})\b", r"\1_rec709", line) for line in lines] if colors else lines


def _working(weight: str) -> str:
    """A weight in the working space; greys are the same in each."""
    if not weight or re.fullmatch(r"[-\d.e]+|color\(([-\d.e]+), \1, \1\)", weight):
        return weight
    return f"to_working(color({weight}), {PRIMARY_ARGUMENTS})"


def _once(texts: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(texts))


def _alone(block: Block) -> tuple[list[str], list[str]]:
    lobes = [f"closure color lobe_{i} = {_product(_working(c.weight), c.closure)};" for i, c in enumerate(block.closures)]
    return [*block.body, *lobes], [f"lobe_{i}" for i in range(len(lobes))]


def _mixed(parts: Sequence[tuple[Share, Block]]) -> tuple[list[str], list[str]]:
    """Patches of no share are not evaluated; what differs in its weight alone is one closure."""
    shared: dict[str, str] = {}
    declarations, bodies, local = [], [], []
    for share, block in parts:
        sums = []
        for closure in block.closures:
            if closure.is_local:
                name = f"lobe_{len(local)}"
                local.append(name)
                declarations.append(f"closure color {name} = 0;")
                sums.append(f"{name} = {_product(_working(_product('share', closure.weight)), closure.closure)};")
            else:
                name = shared.setdefault(closure.closure, f"weight_{len(shared)}")
                sums.append(f"{name} += {_product('share', closure.weight)};")
        bodies += [f"share = {share.expression};", "if (share > 0.0) {", *(f"    {line}" for line in (*block.body, *sums)), "}"]
    declarations += [f"color {name} = color(0.0);" for name in shared.values()]
    ends = [f"closure color shared_{name} = {_working(name)} * {closure};" for closure, name in shared.items()]
    return ["float share;", *declarations, *bodies, *ends], [*(f"shared_{name}" for name in shared.values()), *local]


def _product(*factors: str) -> str:
    return " * ".join(factor for factor in factors if factor)
