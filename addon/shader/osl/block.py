# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks: what a tier writes for one stack, and how one or several of them, for the patches of a surface, make a shader."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ....reference_py.lobes.analytic.interface_tables import UNIT, tables
from ....reference_py.lobes.lobe import DARK
from ....reference_py.lobes.pools import Pool
from ....reference_py.material.schema import COLOR, FLOAT, NORMAL, ROTATION, VECTOR, Parameter
from ....reference_py.optics.microfacet import DISTRIBUTIONS
from ..inputs import PRIMARIES, TANGENT_INPUT, ShaderInput
from .osl_files import functions
from .view_frame import FRAME_FUNCTIONS, Frame

PRIMARY_ARGUMENTS = ", ".join(PRIMARIES)
# Directions, and turns: more than a full one shows as what is over.
_WITHOUT_BOUNDS = (ROTATION, *NORMAL.parameters, TANGENT_INPUT.parameter)
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
    shape: tuple[str, ...] = ()
    """Of a closure that may share a pool: of a microfacet lobe its alphas along and across the plane of incidence and its slope
    towards the view, of Oren-Nayar the slope deviation in degrees."""


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
    """Which share of the surface a block has: the layers that decide, by owner, and whether they are there."""

    covered: tuple[tuple[str, bool], ...]
    pools: Mapping[int, Pool] = field(default_factory=dict)
    """The pools of its block's closures that share one, by their numbers."""

    @property
    def expression(self) -> str:
        return " * ".join(f"cover_{owner}" if there else f"(1.0 - cover_{owner})" for owner, there in self.covered)


def shader_text(title: str, note: str, parts: Sequence[tuple[Share, Block]], inputs: Sequence[ShaderInput]) -> tuple[str, int]:
    """The text of a shader, its name still @SHADER@, and its number of closures."""
    blocks = [block for _, block in parts]
    body, terms = _alone(blocks[0]) if len(parts) == 1 else _mixed(parts)
    pools = [pool for share, _ in parts for pool in share.pools.values()]
    covers = [f"float cover_{owner} = {owner}Coverage;" for owner in dict.fromkeys(owner for share, _ in parts for owner, _ in share.covered)]
    bounded = [i for i in inputs if i.parameter not in _WITHOUT_BOUNDS]
    read = [_bounded(i.osl_name, i.parameter) for i in bounded]
    common = _once([*covers, *(text for block in blocks for text in block.common), *((*Frame().view, *Frame().glossy) if pools else ())])
    primaries = [f"    color {name} = color({numbers([float(i == j) for j in range(3)])})," for i, name in enumerate(PRIMARIES)]
    declared = [_declaration(i.osl_name, i.parameter) for i in inputs]
    arrays = [
        f"    {array},"
        for array in _once(
            [*(array for block in blocks for array in block.arrays), *map(_pool_energies, sorted({kind for kind, _ in pools} & set(DISTRIBUTIONS)))]
        )
    ]
    lines = [
        "// SPDX-License-Identifier: GPL-3.0-or-later",
        f"// {title}",
        f"// Generated; edit the stack, not this text. {note}",
        functions(
            [
                "working_space.h",
                *(name for block in blocks for name in block.functions),
                *((*FRAME_FUNCTIONS, "oren_nayar.h", "oren_nayar_albedo.h", "analytic_tables.h") if pools else ()),
            ]
        ),
        "shader @SHADER@(",
        *primaries,
        *declared,
        *arrays,
        f"    output float Live = {LIVE:.1f},",
        "    output closure color BSDF = 0)",
        "{",
        *(f"    {line}" for line in (*read, *_of_model([*common, *body], [i.osl_name for i in bounded]))),
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


def _bounded(name: str, parameter: Parameter) -> str:
    """A statement that reads a socket as the model takes it: within its range, which drivers and textures exceed, and a color in Rec.709."""
    low, high = f"{parameter.minimum:.9g}", f"{parameter.maximum:.9g}"
    if parameter.type == FLOAT:
        return f"float {name}_model = clamp({name}, {low}, {high});"
    if parameter.type == VECTOR:
        return f"vector {name}_model = clamp({name}, vector({low}), vector({high}));"
    return f"color {name}_model = clamp(from_working({name}, {PRIMARY_ARGUMENTS}), color({low}), color({high}));"


def _of_model(lines: list[str], names: list[str]) -> list[str]:
    """Statements that read the model's values in place of the sockets'."""
    return [re.sub(rf"\b({'|'.join(names)})\b", r"\1_model", line) for line in lines] if names else lines


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
    pools: dict[Pool, str] = {}
    declarations, bodies, local = [], [], []
    for share, block in parts:
        sums = []
        for number, closure in enumerate(block.closures):
            if number in share.pools:
                sums += _into_pool(pools.setdefault(share.pools[number], f"pool_{len(pools)}"), share.pools[number], closure)
            elif closure.is_local:
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
    for pool, name in pools.items():
        declarations += [f"color {name} = color(0.0);", f"color {name}_shape = color(0.0);", f"float {name}_energy = 0.0;"]
        ends += _of_pool(name, pool)
    terms = [*(f"shared_{name}" for name in shared.values()), *local, *(f"lobe_{name}" for name in pools.values())]
    return ["float share;", *(["color part;"] if pools else []), *declarations, *bodies, *ends], terms


def _into_pool(name: str, pool: Pool, closure: Closure) -> list[str]:
    """Statements that add a closure to its pool."""
    shape = f"color({', '.join((*closure.shape, '0.0', '0.0')[:3])})"
    return [
        f"part = {_product('share', closure.weight)};",
        f"{name} += part * {_unit(pool, *closure.shape[:2])};",
        f"{name}_energy += (part[0] + part[1] + part[2]) / 3.0;",
        f"{name}_shape += (part[0] + part[1] + part[2]) / 3.0 * {shape};",
    ]


def _of_pool(name: str, pool: Pool) -> list[str]:
    """Statements that declare the closure of a pool."""
    (kind, which), shape = pool, f"{name}_shape"
    lines = [f"{shape} /= max({name}_energy, 1e-20);"]
    if kind in DISTRIBUTIONS:
        sides = f"{shape}[0]", f"{shape}[1]"
        closure = f'microfacet("{kind}", normalize(bent_normal + {shape}[2] * side), along, {shape}[0], break_isotropy({shape}[1]), 1.0, 0)'
    else:
        sides = (f"{shape}[0]",)
        closure = f"oren_nayar_diffuse_bsdf(N, {_grey(which)}, oren_nayar_sigma({shape}[0]))"
    lines.append(f"{name} /= {_unit(pool, *sides)};")
    return [*lines, f"closure color lobe_{name} = {_working(name)} * {closure};"]


def _unit(pool: Pool, *shape: str) -> str:
    """The energy of a closure of weight 1, of these alphas or this slope deviation; of Oren-Nayar's dark color that over the color."""
    kind, which = pool
    if kind in DISTRIBUTIONS:
        return f"max(closure_energy(Pool{kind.title()}, -CLOSURE, view_z, sqrt({shape[0]} * {shape[1]})), 1e-3)"
    return f"(oren_nayar_albedo(view_z, {_grey(which)}, oren_nayar_sigma({shape[0]})) * {1.0 if which else 1.0 / DARK:g})"


@cache
def _pool_energies(distribution: str) -> str:
    """The array parameter of the energies of a distribution's closures."""
    entries = np.rint(tables()[distribution]["closure"].ravel() / UNIT).astype(int).tolist()
    return f"float Pool{distribution.title()}[{len(entries)}] = {{{','.join(map(str, entries))}}}"


def _grey(which: int) -> str:
    return f"color({1.0 if which else DARK:g})"


def _product(*factors: str) -> str:
    return " * ".join(factor for factor in factors if factor)
