# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks: what a tier writes for one stack, and how one or several of them, for the patches of a surface, make a shader."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ....reference_py.material.schema import COLOR
from ..inputs import PRIMARIES, ShaderInput
from .parts import declaration, fill, right_nested

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
    """Texts of a stack's shader: functions, array parameters and statements at the top (of all three, equal ones are
    written once), then statements for the weights, then the closures."""

    functions: tuple[str, ...]
    arrays: tuple[str, ...]
    common: tuple[str, ...]
    body: str
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
    if len(parts) == 1:
        body, terms = _alone(blocks[0])
    else:
        body, terms = _mixed(parts)
    covers = [fill("cover.osl", OWNER=owner) for owner, _ in parts[0][0].covered]
    declared = [declaration(i.osl_name, i.parameter) for i in inputs]
    colors = [i.osl_name for i in inputs if i.parameter.type == COLOR]
    read = [f"    color {name}_rec709 = from_working({name}, {PRIMARY_ARGUMENTS});\n" for name in colors]
    text = fill(
        "shader.osl",
        WORKING=fill("working.h"),
        LIVE=f"{LIVE:.1f}",
        TITLE=title,
        NOTE=note,
        FUNCTIONS="\n".join(_once([text for block in blocks for text in block.functions])),
        PARAMETERS="\n".join([*declared, *_once([array for block in blocks for array in block.arrays])]),
        COMMON="".join(read) + _in_rec709("".join(_once([*covers, *(text for block in blocks for text in block.common)])), colors),
        BODY=_in_rec709(body, colors),
        SUM=right_nested(terms),
    )
    return text, len(terms)


def _in_rec709(text: str, colors: list[str]) -> str:
    """Statements that read the model's colors in place of the sockets'."""
    return re.sub(rf"\b({'|'.join(colors)})\b", r"\1_rec709", text) if colors else text


def _working(weight: str) -> str:
    """A weight in the working space; greys are the same in each."""
    if not weight or re.fullmatch(r"[-\d.e]+|color\(([-\d.e]+), \1, \1\)", weight):
        return weight
    return f"to_working(color({weight}), {PRIMARY_ARGUMENTS})"


def _once(texts: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(texts))


def _alone(block: Block) -> tuple[str, list[str]]:
    lobes = [f"    closure color lobe_{i} = {_product(_working(c.weight), c.closure)};\n" for i, c in enumerate(block.closures)]
    return block.body + "".join(lobes), [f"lobe_{i}" for i in range(len(lobes))]


def _mixed(parts: Sequence[tuple[Share, Block]]) -> tuple[str, list[str]]:
    """Patches of no share are not evaluated; what differs in its weight alone is one closure."""
    shared: dict[str, str] = {}
    declarations, bodies, local = [], [], []
    for number, (share, block) in enumerate(parts):
        sums = []
        for closure in block.closures:
            if closure.is_local:
                name = f"lobe_{len(local)}"
                local.append(name)
                declarations.append(f"    closure color {name} = 0;\n")
                sums.append(f"    {name} = {_product(_working(_product('share', closure.weight)), closure.closure)};\n")
            else:
                name = shared.setdefault(closure.closure, f"weight_{len(shared)}")
                sums.append(f"    {name} += {_product('share', closure.weight)};\n")
        inner = "".join(f"    {line}\n" if line else "\n" for line in (block.body + "".join(sums)).splitlines())
        bodies.append(f"    share = {share.expression};\n    if (share > 0.0) {{\n{inner}    }}\n")
    declarations += [f"    color {name} = color(0.0);\n" for name in shared.values()]
    ends = [f"    closure color shared_{name} = {_working(name)} * {closure};\n" for closure, name in shared.items()]
    text = "".join(["    float share;\n", *declarations, *bodies, *ends])
    return text, [*(f"shared_{name}" for name in shared.values()), *local]


def _product(*factors: str) -> str:
    return " * ".join(factor for factor in factors if factor)
