# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the tier `analytic` as straight lines of OSL, one call per interface and beam; as loops where they are many.

OSL folds what is constant within straight lines, so all that does not depend on the view is free where parameters are.
"""

from collections.abc import Sequence

import numpy as np

from ....reference_py.lobes.analytic import base
from ....reference_py.material.stack import Stack
from .analytic_tables import Tables
from .parts import beckmann, fill, numbers
from .surface import Surface

# Above this many layers there are loops over layers and beams: they do not fold, but eight layers unrolled are 10 MB of
# bytecode that takes seconds to compile, and thirty take minutes.
MOST_UNROLLED = 3


def layers_text(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface], told: Tables) -> str:
    """Values of the layers, and beams of uniform light from below: what does not depend on the view."""
    count = len(stack.layers)
    values = ["float n_0 = 1.0;"]
    for j, (owner, surface) in enumerate(zip(owners, surfaces)):
        values += [
            f"float n_{j + 1} = {owner}Ior;", f"float alpha_{j} = {surface.alpha};",
            f"color tau_{j} = optical_depth({owner}Tint, {owner}Thickness);", f"int real_{j} = n_{j} != n_{j + 1};",
        ]  # fmt: skip
    return fill(
        "analytic_layers.osl",
        VALUES=lines_of(values),
        BEFORE=lines_of(_before(stack, told, "down") + _before(stack, told, "up") + _in_order(stack, told, "down") + _in_order(stack, told, "up")),
        ESCAPING="" if stack.base.kind == "conductor" else _escaping(stack, told) + "\n",
        LEAST=_nested("min", [f"n_{j}" for j in range(count)]),
        N_BASE=f"n_{count}",
        BELOW=_below(stack, told),
    )


def view_text(stack: Stack, told: Tables, view: str, top_alpha: str) -> str:
    """The beam of the view of cosine `view`, which meets a top of alpha `top_alpha`."""
    beam = beam_of(view)
    return fill("analytic_view.osl", BEAM=beam, VIEW=view, CROSSINGS=lines_of(_crossings(stack, told, beam, "down", top_alpha)))


def beam_of(view: str) -> str:
    """The name of the beam of the view of cosine `view`."""
    return view.replace("view_z", "view")


def roughest(count: int) -> str:
    """The alpha of the roughest interface that is there."""
    return _nested("max", [f"real_{j} * alpha_{j}" for j in range(count)])


def lines_of(lines, indent="    ") -> str:
    return "\n".join(indent + line for line in lines)


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


def _before(stack: Stack, told: Tables, way: str) -> list[str]:
    """What a beam met last before each interface: whether anything, its tables, its alpha, its eta from behind.

    Arithmetic, as branches do not fold.
    """
    lines, last = [], None
    for j in _order(stack, way):
        if last is None:
            lines += [f"int met_{way}_{j} = 0;", f"int kind_{way}_{j} = 0;", f"float alpha_{way}_{j} = 0.0;", f"float n_{way}_{j} = 1.0;"]
        else:
            kind, medium = told.start(stack.layers[last]["distribution"]), last if way == "down" else last + 1
            lines += [
                f"int met_{way}_{j} = max(real_{last}, met_{way}_{last});",
                f"int kind_{way}_{j} = real_{last} * {kind} + (1 - real_{last}) * kind_{way}_{last};",
                f"float alpha_{way}_{j} = real_{last} * alpha_{last} + (1 - real_{last}) * alpha_{way}_{last};",
                f"float n_{way}_{j} = real_{last} * n_{medium} + (1 - real_{last}) * n_{way}_{last};",
            ]
        last = j
    return lines


def _crossings(stack: Stack, told: Tables, beam: str, way: str, top_alpha: str = "alpha_0") -> list[str]:
    if _has_loops(stack):
        names = {name: f"{way}_{name}[j]" for name in ("kind", "beckmann", "alpha", "own", "other", "tau")}
        if top_alpha != "alpha_0":
            names["alpha"] = f"(j == 0 ? {top_alpha} : {names['alpha']})"
        here = f"{beam}, {told.name}, " + ", ".join(names.values())
        back = ", ".join(f"{way}_{name}[j]" for name in ("met", "last_kind", "last_alpha")) + f", {way}_last_n[j] / {way}_own[j]"
        return [f"for (int j = 0; j < {len(stack.layers)}; ++j) {{", f"    cross_next({here}, j == 0, {back});", "}"]
    lines = []
    for place, (j, own, other, tau) in enumerate(_passages(stack, way)):
        layer = stack.layers[j]
        alpha = f"alpha_{j}" if j else top_alpha
        here = f"{beam}, {told.arguments(layer['distribution'])}, {beckmann(layer)}, {alpha}, n_{own}, n_{other}, {tau}"
        back = f"met_{way}_{j}, kind_{way}_{j}, alpha_{way}_{j}, n_{way}_{j} / n_{own}"
        lines.append(f"cross_next({here}, 0, {back});" if place else f"cross_first({here});")
    return lines


def _has_loops(stack: Stack) -> bool:
    return len(stack.layers) > MOST_UNROLLED


def _passages(stack: Stack, way: str) -> list[tuple[int, int, int, str]]:
    """Interface, media before and behind it, and the optical depth behind it, in the order of travel."""
    if way == "down":
        return [(j, j, j + 1, f"tau_{j}") for j in _order(stack, way)]
    return [(j, j + 1, j, f"tau_{j - 1}" if j else "color(0.0)") for j in _order(stack, way)]


def _in_order(stack: Stack, told: Tables, way: str) -> list[str]:
    """What loops over the layers read: arrays in the order of travel."""
    if not _has_loops(stack):
        return []
    passages = _passages(stack, way)
    arrays = {
        "int kind": [told.start(stack.layers[j]["distribution"]) for j, *_ in passages],
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


def _escaping(stack: Stack, told: Tables) -> str:
    """What of uniform light from below escapes, by reciprocity; without absorption the rest comes back."""
    count = len(stack.layers)
    u, w = base.gauss(base.ESCAPING)
    body = ["start_beam(beam, sqrt(1.0 - @u@ * @u@), 0.0);", *_crossings(stack, told, "beam", "down")]
    body.append(f"escaped += @w@ / (n_{count} * n_{count}) * beam.transmitted;")
    thickest = _nested("max", [f"largest(tau_{j})" for j in range(count)])
    return lines_of([
        "color escaped = color(0.0);", *for_each({"u": u, "w": 2.0 * w * u}, body, count),
        "color reflected = 1.0 - escaped;", f"float thickest = {thickest};",
    ])  # fmt: skip


def for_each(nodes: dict[str, np.ndarray], body: list[str], count: int) -> list[str]:
    """`body` once per node, its @names@ replaced by the node's values; as a loop where straight lines would be too many."""
    size = len(next(iter(nodes.values())))
    if count > MOST_UNROLLED:
        arrays = [f"float {name}_of[{size}] = {{{numbers(values)}}};" for name, values in nodes.items()]
        looped = [_replaced(line, {name: f"{name}_of[q]" for name in nodes}) for line in body]
        return [*arrays, f"for (int q = 0; q < {size}; ++q) {{", *looped, "}"]
    return [_replaced(line, {name: f"{v[q]:.9g}" for name, v in nodes.items()}) for q in range(size) for line in body]


def _replaced(line: str, values: dict[str, str]) -> str:
    for name, value in values.items():
        line = line.replace(f"@{name}@", value)
    return line


def _below(stack: Stack, told: Tables) -> str:
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
        *_crossings(stack, told, "beam", "up"),
        "back = (beam.first + beam.inner) * left * left;", "out = beam.transmitted * left;",
    ]  # fmt: skip
    lines = ["color left, back, out;", "float p, weight;"]
    if stack.base.kind != "conductor":
        body.append("absorbed += weight * (1.0 - back - out);")
        lines += ["color absorbed = color(0.0);", *for_each(nodes, body, count)]
        lines.append("reflected = max(reflected - max(absorbed, color(0.0)), color(0.0));")
        return lines_of(["if (thickest > 0.0) {", *("    " + line for line in lines), "}"])
    lines += ["Below below;", "below.least = least;", f"below.n_base = {n_base};", "below.critical2 = critical2;"]
    lines += ["color reflected = color(0.0);", "color escaped = color(0.0);"]
    body += ["reflected += weight * back;", "escaped += weight * out;"]
    inside, beyond = base.polynomial_fit(base.ESCAPING), base.polynomial_fit(base.TRAPPED)
    for group, fit, padding in (("escaping", inside, (0, len(v))), ("trapped", beyond, (len(u), 0))):
        for degree, row in enumerate(fit):
            nodes[f"{group}_{degree}"] = np.pad(row, padding)
            for share in ("back", "out"):
                lines.append(f"below.{group}_{share}_{degree} = color(0.0);")
                body.append(f"below.{group}_{share}_{degree} += @{group}_{degree}@ * {share};")
    return lines_of(lines + for_each(nodes, body, count))


def below_text() -> dict[str, str]:
    """Placeholders of the part that evaluates the polynomials of light from below (`analytic_below.h`)."""
    groups = {"escaping": ("u", base.ESCAPING), "trapped": ("v", base.TRAPPED)}
    fields = [f"color {group}_{share}_{d};" for group, (_, size) in groups.items() for share in ("back", "out") for d in range(size)]
    texts = {"FIELDS": lines_of(fields)}
    for group, (variable, size) in groups.items():
        for share in ("back", "out"):
            terms = f"b.{group}_{share}_{size - 1}"
            for degree in reversed(range(size - 1)):
                terms = f"({terms}) * {variable} + b.{group}_{share}_{degree}"
            texts[f"{group}_{share}".upper()] = terms
    return texts
