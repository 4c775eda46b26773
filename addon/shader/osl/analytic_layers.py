# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the tier `analytic` as straight lines of OSL, one call per interface and beam; as loops where they are many, or stay for a moment.

OSL folds what is constant within straight lines, so all that does not depend on the view is free where parameters are.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ....reference_py.lobes.analytic import base, interface_tables
from ....reference_py.material.schema import ANISOTROPY
from ....reference_py.material.stack import Stack
from .block import numbers
from .osl_files import TABLE_BLOCKS, table_starts
from .surface import Surface, beckmann, is_metal

# Above this many layers there are loops over layers and beams: they do not fold, but eight layers unrolled are 10 MB of
# bytecode that takes seconds to compile, and thirty take minutes. What stands in for a bake loops too: it is compiled within a click.
MOST_UNROLLED = 3


def has_loops(stack: Stack, stands_in: bool) -> bool:
    """Whether a stack's shader has loops over its layers and beams in place of straight lines."""
    return stands_in or len(stack.layers) > MOST_UNROLLED


@dataclass(frozen=True)
class Tables:
    """Tables of energies of the `distributions` of a stack as one array parameter, each once: it stays at its default, takes no time
    and makes no socket."""

    distributions: tuple[str, ...]
    anisotropic: bool

    @classmethod
    def of(cls, stack: Stack) -> "Tables":
        elements = (*stack.layers, stack.base)
        distributions = sorted({e["distribution"] for e in elements if "distribution" in e})
        return cls(tuple(distributions), any(e.has(ANISOTROPY) for e in elements))

    @property
    def name(self) -> str:
        """The parameter's: patches of a surface may need tables of different distributions."""
        return "Table" + "".join(name.title() for name in self.distributions) + ("Anisotropic" if self.anisotropic else "")

    def start(self, distribution: str) -> int:
        """Where the tables of a distribution start."""
        return self.distributions.index(distribution) * table_starts()[-1 if self.anisotropic else -2]

    def arguments(self, distribution: str) -> str:
        """What functions are given for a distribution: `table` and `kind`."""
        return f"{self.name}, {self.start(distribution)}"

    @property
    def arrays(self) -> tuple[str, ...]:
        """The declaration of the parameter, if there is one."""
        return (_declaration(self),) if self.distributions else ()


@cache
def _declaration(of: Tables) -> str:
    blocks = list(TABLE_BLOCKS)[: None if of.anisotropic else -1]
    values = np.concatenate([interface_tables.tables()[distribution][block].ravel() for distribution in of.distributions for block in blocks])
    entries = np.rint(values / interface_tables.UNIT).astype(int).tolist()
    return f"float {of.name}[{values.size}] = {{{','.join(map(str, entries))}}}"


def layers_lines(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface], energies: Tables, loops: bool) -> list[str]:
    """Values of the layers from vacuum down, and beams of uniform light from below: what does not depend on the view."""
    count = len(stack.layers)
    lines = ["float n_0 = 1.0;"]
    for j, (owner, surface) in enumerate(zip(owners, surfaces)):
        lines += [
            f"float n_{j + 1} = {owner}Ior;", f"float alpha_{j} = {surface.alpha};",
            f"color tau_{j} = optical_depth({owner}Tint, {owner}Thickness);", f"int real_{j} = n_{j} != n_{j + 1};",
        ]  # fmt: skip
    for way in ("down", "up"):
        lines += _before(stack, energies, way)
    for way in ("down", "up"):
        lines += _in_order(stack, energies, way) if loops and count > 1 else []
    lines.append("Beam beam;")
    if not is_metal(stack):
        lines += _escaping(stack, energies, loops)
    lines += [
        f"float least = min(1.0, {_nested('min', [f'n_{j}' for j in range(count)])});",
        f"float critical2 = max(1.0 - (least / n_{count}) * (least / n_{count}), 0.0);",
    ]
    return lines + _below(stack, energies, loops)


def view_lines(stack: Stack, energies: Tables, loops: bool, view: str, top_alpha: str) -> list[str]:
    """The beam of the view of cosine `view`, which meets a top of alpha `top_alpha`, down to the base."""
    beam = beam_of(view)
    return [f"Beam {beam};", f"start_beam({beam}, sqrt(1.0 - {view} * {view}), 0.0);", *_crossings(stack, energies, loops, beam, "down", top_alpha)]


def beam_of(view: str) -> str:
    """The name of the beam of the view of cosine `view`."""
    return view.replace("view_z", "view")


def roughest(count: int) -> str:
    """The alpha of the roughest interface that is there."""
    return _nested("max", [f"real_{j} * alpha_{j}" for j in range(count)])


def _nested(function: str, terms: list[str]) -> str:
    """min or max of many; halved, as compilers take exponentially long over deeply nested calls."""
    if len(terms) == 1:
        return terms[0]
    middle = len(terms) // 2
    return f"{function}({_nested(function, terms[:middle])}, {_nested(function, terms[middle:])})"


def _order(stack: Stack, way: str) -> list[int]:
    """The layers in the order in which a beam meets them, "down" or "up"."""
    down = list(range(len(stack.layers)))
    return down if way == "down" else down[::-1]


def _before(stack: Stack, energies: Tables, way: str) -> list[str]:
    """What a beam met last before each interface: whether anything, its tables, its alpha, its eta from behind.

    Arithmetic, as branches do not fold.
    """
    lines, last = [], None
    for j in _order(stack, way):
        if last is None:
            lines += [f"int met_{way}_{j} = 0;", f"int kind_{way}_{j} = 0;", f"float alpha_{way}_{j} = 0.0;", f"float n_{way}_{j} = 1.0;"]
        else:
            kind, medium = energies.start(stack.layers[last]["distribution"]), last if way == "down" else last + 1
            lines += [
                f"int met_{way}_{j} = max(real_{last}, met_{way}_{last});",
                f"int kind_{way}_{j} = real_{last} * {kind} + (1 - real_{last}) * kind_{way}_{last};",
                f"float alpha_{way}_{j} = real_{last} * alpha_{last} + (1 - real_{last}) * alpha_{way}_{last};",
                f"float n_{way}_{j} = real_{last} * n_{medium} + (1 - real_{last}) * n_{way}_{last};",
            ]
        last = j
    return lines


def _crossings(stack: Stack, energies: Tables, loops: bool, beam: str, way: str, top_alpha: str = "alpha_0") -> list[str]:
    if loops and len(stack.layers) > 1:  # a lone layer has none before it, which thrice the code would look for
        names = {name: f"{way}_{name}[j]" for name in ("kind", "beckmann", "alpha", "own", "other", "tau")}
        if top_alpha != "alpha_0":
            names["alpha"] = f"(j == 0 ? {top_alpha} : {names['alpha']})"
        here = f"{beam}, {energies.name}, " + ", ".join(names.values())
        back = ", ".join(f"{way}_{name}[j]" for name in ("met", "last_kind", "last_alpha")) + f", {way}_last_n[j] / {way}_own[j]"
        return [f"for (int j = 0; j < {len(stack.layers)}; ++j) {{", f"    cross_next({here}, j == 0, {back});", "}"]
    lines = []
    for place, (j, own, other, tau) in enumerate(_passages(stack, way)):
        layer = stack.layers[j]
        alpha = f"alpha_{j}" if j else top_alpha
        here = f"{beam}, {energies.arguments(layer['distribution'])}, {beckmann(layer)}, {alpha}, n_{own}, n_{other}, {tau}"
        back = f"met_{way}_{j}, kind_{way}_{j}, alpha_{way}_{j}, n_{way}_{j} / n_{own}"
        lines.append(f"cross_next({here}, 0, {back});" if place else f"cross_first({here});")
    return lines


def _passages(stack: Stack, way: str) -> list[tuple[int, int, int, str]]:
    """Interface, media before and behind it, and the optical depth behind it, in the order of travel."""
    if way == "down":
        return [(j, j, j + 1, f"tau_{j}") for j in _order(stack, way)]
    return [(j, j + 1, j, f"tau_{j - 1}" if j else "color(0.0)") for j in _order(stack, way)]


def _in_order(stack: Stack, energies: Tables, way: str) -> list[str]:
    """What loops over the layers read: arrays in the order of travel."""
    passages = _passages(stack, way)
    arrays = {
        "int kind": [energies.start(stack.layers[j]["distribution"]) for j, *_ in passages],
        "int beckmann": [beckmann(stack.layers[j]) for j, *_ in passages],
        "float alpha": [f"alpha_{j}" for j, *_ in passages],
        "float own": [f"n_{own}" for _, own, *_ in passages],
        "float other": [f"n_{other}" for *_, other, _ in passages],
        "color tau": [tau for *_, tau in passages],
        "int met": [f"met_{way}_{j}" for j, *_ in passages],
        "int last_kind": [f"kind_{way}_{j}" for j, *_ in passages],
        "float last_alpha": [f"alpha_{way}_{j}" for j, *_ in passages],
        "float last_n": [f"n_{way}_{j}" for j, *_ in passages],
    }
    result = []
    for key, values in arrays.items():
        kind, name = key.split()
        result.append(f"{kind} {way}_{name}[{len(values)}] = {{{', '.join(map(str, values))}}};")
    return result


def _escaping(stack: Stack, energies: Tables, loops: bool) -> list[str]:
    """What of uniform light from below escapes, by reciprocity; without absorption the rest comes back."""
    count = len(stack.layers)
    u, w = base.gauss(base.ESCAPING)
    body = ["start_beam(beam, sqrt(1.0 - @u@ * @u@), 0.0);", *_crossings(stack, energies, loops, "beam", "down")]
    body.append(f"escaped += @w@ / (n_{count} * n_{count}) * beam.transmitted;")
    thickest = _nested("max", [f"largest(tau_{j})" for j in range(count)])
    return [
        "color escaped = color(0.0);", *for_each({"u": u, "w": 2.0 * w * u}, body, loops),
        "color reflected = 1.0 - escaped;", f"float thickest = {thickest};",
    ]  # fmt: skip


def for_each(nodes: dict[str, np.ndarray], body: list[str], loops: bool) -> list[str]:
    """`body` once per node, its @names@ replaced by the node's values; as a loop if so asked."""
    size = len(next(iter(nodes.values())))
    if loops:
        arrays = [f"float {name}_of[{size}] = {{{numbers(values)}}};" for name, values in nodes.items()]
        looped = [_replaced(line, {name: f"{name}_of[q]" for name in nodes}) for line in body]
        return [*arrays, f"for (int q = 0; q < {size}; ++q) {{", *looped, "}"]
    return [_replaced(line, {name: f"{v[q]:.9g}" for name, v in nodes.items()}) for q in range(size) for line in body]


def _replaced(line: str, values: dict[str, str]) -> str:
    for name, value in values.items():
        line = line.replace(f"@{name}@", value)
    return line


def _below(stack: Stack, energies: Tables, loops: bool) -> list[str]:
    """Beams from the base at the nodes of uniform light: what is absorbed and, for a metal, the shares in `below`."""
    count, n_base = len(stack.layers), f"n_{len(stack.layers)}"
    (u, w), (v, x) = base.gauss(base.ESCAPING), base.gauss(base.TRAPPED)
    # p / n and weight of a node: of light that may escape and, with the share `critical2`, of trapped light
    nodes = {
        "a": np.concatenate([1.0 - u * u, 0.0 * v]), "b": np.concatenate([0.0 * u, v * v]), "t": np.concatenate([0.0 * u, 1.0 + 0.0 * v]),
        "w": np.concatenate([2.0 * w * u, 2.0 * x * v]),
    }  # fmt: skip
    body = [
        f"p = sqrt((1.0 - @t@) * least * least * @a@ + @t@ * {n_base} * {n_base} * (1.0 - critical2 * @b@));",
        "weight = @w@ * (@t@ * critical2 + (1.0 - @t@) * (1.0 - critical2));",
        f"left = attenuation(tau_{count - 1}, p, 0.0, {n_base});", "start_beam(beam, p, 0.0);",
        *_crossings(stack, energies, loops, "beam", "up"),
        "back = (beam.first + beam.inner) * left * left;", "out = beam.transmitted * left;",
    ]  # fmt: skip
    lines = ["color left, back, out;", "float p, weight;"]
    if not is_metal(stack):
        body.append("absorbed += weight * (1.0 - back - out);")
        lines += ["color absorbed = color(0.0);", *for_each(nodes, body, loops)]
        lines.append("reflected = max(reflected - max(absorbed, color(0.0)), color(0.0));")
        return ["if (thickest > 0.0) {", *("    " + line for line in lines), "}"]
    lines += ["Below below;", f"start_below(below, least, {n_base}, critical2);"]
    lines += ["color reflected = color(0.0);", "color escaped = color(0.0);"]
    body += ["reflected += weight * back;", "escaped += weight * out;"]
    inside, beyond = base.polynomial_fit(base.ESCAPING), base.polynomial_fit(base.TRAPPED)
    coefficients = {f"e{i}": np.pad(row, (0, len(v))) for i, row in enumerate(inside)} | {f"t{i}": np.pad(row, (len(u), 0)) for i, row in enumerate(beyond)}
    body.append(f"add_node(below, back, out, {', '.join(f'@{name}@' for name in coefficients)});")
    return lines + for_each(nodes | coefficients, body, loops)
