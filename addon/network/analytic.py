# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader body of the tier `analytic`: every value comes in through a parameter, tables are array parameters."""

from functools import cache

import numpy as np

from ...reference_py.network.analytic import base, calibration, tables
from ...reference_py.network.analytic.network import ALBEDO_NODES, MIN_COS_O
from ...reference_py.optics.material import TINT_FLOOR
from ...reference_py.stack import Stack
from .inputs import ShaderInput, layer_owner
from .parts import beckmann, declaration, fill, listed, narrow, numbers, right_nested

_BLOCKS = ("thin", "dense", "diffuse", "gain", "closure")


def analytic_text(stack: Stack, inputs: tuple[ShaderInput, ...]) -> str:
    """The text of the shader, its name still @SHADER@."""
    count = len(stack.layers)
    kinds = _kinds(stack)
    table = _table(kinds)
    # OSL has no empty arrays: an uncoated base carries one unused surface
    surfaces = range(count)
    return fill(
        "analytic.osl",
        TITLE=_title(stack),
        FUNCTIONS=_functions(stack, kinds),
        PARAMETERS="\n".join(declaration(i.osl_name, i.parameter) for i in inputs),
        TABLE_SIZE=table.count(",") + 1,
        TABLE=table,
        MEDIA=count + 1,
        INDICES="".join(f", {layer_owner(i)}Ior" for i in surfaces),
        SURFACES=max(count, 1),
        ALPHAS=listed(f"{layer_owner(i)}Roughness * {layer_owner(i)}Roughness" for i in surfaces) or "0.0",
        KINDS=listed(str(kinds.index(layer["distribution"])) for layer in stack.layers) or "0",
        BECKMANNS=listed(beckmann(layer) for layer in stack.layers) or "0",
        TAUS=listed(f"optical_depth({layer_owner(i)}Tint, {layer_owner(i)}Thickness)" for i in surfaces) or "color(0.0)",
        MIN_COS_O=f"{MIN_COS_O:g}",
        TANGENT=fill("tangent.osl") if kinds else "",
        LAYERS=fill("analytic_layers.osl", COUNT=count) if count else "",
        LOBES="".join(_lobes(stack, kinds)),
        SUM=right_nested(["lobe_top"] * (count > 0) + ["lobe_inner"] * (count > 1) + ["lobe_base"]),
    )


def _title(stack: Stack) -> str:
    parts = [f"{layer.kind} ({layer['distribution']})" for layer in stack.layers]
    parts.append(stack.base.kind + (f" ({stack.base['distribution']})" if "distribution" in stack.base else ""))
    return f"Lamina shader, tier analytic, from the top: {', '.join(parts)}."


def _kinds(stack: Stack) -> tuple[str, ...]:
    """The distributions in use, each once: a shader carries tables of no others."""
    return tuple(sorted({e["distribution"] for e in (*stack.layers, stack.base) if "distribution" in e}))


@cache
def _table(kinds: tuple[str, ...]) -> str:
    values = [f"{v:g}" for v in (*tables.RHO, *tables.ALPHA)]
    for kind in kinds:
        values += [f"{v:.6g}" for name in _BLOCKS for v in np.round(tables.tables()[kind][name].ravel(), 4)]
    return ",".join(value.removeprefix("0") if value.startswith("0.") else value for value in values)


def _functions(stack: Stack, kinds: tuple[str, ...]) -> str:
    """The parts that this structure calls, each once, callees first."""
    texts = []
    if kinds:
        texts += [narrow(), _constants(kinds), fill("fresnel_dielectric.h"), fill("analytic_tables.h"), _beam(), fill("analytic_lobe.h")]
    if stack.layers:
        texts.append(fill("medium.h", TINT_FLOOR=f"{TINT_FLOOR:g}"))
    if stack.base.kind == "oren_nayar" and stack.layers:
        texts.append(fill("oren_nayar_albedo.h"))
    if stack.base.kind == "conductor":
        texts += [fill("masking.h"), fill("fresnel_conductor.h"), _metal()]
        if "reflectance" in stack.base:
            texts.append(fill("artist_index.h"))
    return "\n".join(texts)


def _constants(kinds: tuple[str, ...]) -> str:
    """Sizes of the tables and the tier's calibration as preprocessor constants."""
    sizes = {name: tables.tables()[kinds[0]][name].size for name in _BLOCKS}
    starts = np.cumsum([0, *sizes.values()])
    constants: dict[str, float] = {
        "RHO_KNOTS": len(tables.RHO), "ALPHA_KNOTS": len(tables.ALPHA), "T_KNOTS": len(tables.T), "V_KNOTS": len(tables.V),
        "CLOSURE_CELLS": tables.CLOSURE_CELLS, "TABLES": len(tables.RHO) + len(tables.ALPHA), "TABLES_OF_KIND": int(starts[-1]),
        **{name.upper(): int(start) for name, start in zip(_BLOCKS, starts)},
    }  # fmt: skip
    for name, value in vars(calibration).items():
        if name.isupper():
            constants |= {f"{name}_{i}": v for i, v in enumerate(value)} if isinstance(value, tuple) else {name: value}
    return "".join(f"#define {name} {value if isinstance(value, int) else format(float(value), '#.9g')}\n" for name, value in constants.items())


def _nodes(name: str, values: dict[str, np.ndarray]) -> str:
    return "\n".join(f"    float {name}_{axis}[{len(v)}] = {{{numbers(v)}}};" for axis, v in values.items())


def _beam() -> str:
    escaping, trapped = (dict(zip("uw", base.gauss(count))) for count in (base.ESCAPING, base.TRAPPED))
    return fill(
        "analytic_beam.h", ESCAPING=base.ESCAPING, TRAPPED=base.TRAPPED,
        ESCAPING_NODES=_nodes("escaping", escaping), TRAPPED_NODES=_nodes("trapped", trapped),
    )  # fmt: skip


def _metal() -> str:
    u, w, x, y = base.lobe_nodes()
    return fill(
        "analytic_metal.h", LOBE_COUNT=len(u), LOBE_NODES=_nodes("lobe", {"u": u, "w": w, "x": x, "y": y}),
        MEAN_COUNT=len(base.MEAN_COSINES), MEAN_NODES=_nodes("mean", {"c": base.MEAN_COSINES, "w": base.MEAN_WEIGHTS}),
    )  # fmt: skip


def _lobes(stack: Stack, kinds: tuple[str, ...]) -> list[str]:
    lobes, count = [], len(stack.layers)
    if count:
        lobes.append(fill("analytic_top.osl", DISTRIBUTION=stack.layers[0]["distribution"]))
    if count > 1:
        lobes.append(fill("analytic_inner.osl", DISTRIBUTION=stack.layers[1]["distribution"]))
    return lobes + [_base_lobe(stack, kinds)]


def _base_lobe(stack: Stack, kinds: tuple[str, ...]) -> str:
    element, count = stack.base, len(stack.layers)
    if element.kind == "lambert":
        return fill("analytic_lambert.osl", LEFT="transmitted * escaped / (1.0 - BaseColor * reflected)" if count else "color(1.0)")
    if element.kind == "oren_nayar":
        u, w = base.gauss(ALBEDO_NODES)
        coated = fill("analytic_oren_nayar_weight.osl", COUNT=count, MEAN_COUNT=len(u), MEAN_NODES=_nodes("albedo", {"u": u, "w": w}))
        return fill("analytic_oren_nayar.osl", WEIGHT=coated if count else "    color weight_base = color(1.0);")
    return fill(
        "analytic_conductor.osl",
        BASE_INDEX=fill("index_artist.osl" if "reflectance" in element else "index_complex.osl"),
        COUNT=count,
        KIND=kinds.index(element["distribution"]),
        BECKMANN=beckmann(element),
        SPREAD_BECKMANN=beckmann(stack.layers[-1] if count else element),
        BEFORE="    float slope_base = 2.0 * n[%d] * cosine(p, n[%d]) * base_alpha;" % (count, count)
        if count
        else "    float variance = 0.0;\n    color reflected = color(0.0);\n    color escaped = color(1.0);",
        ALPHA="lobe_alpha(2.0 * variance + slope_base * slope_base, view_z)" if count else "base_alpha",
        TRANSMITTED="transmitted * " if count else "",
        DISTRIBUTION=element["distribution"],
    )
