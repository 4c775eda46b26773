# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart cost_factors`: what each thing that a shader can do costs in Cycles, over a plain Glossy node in the same run."""

from pathlib import Path

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

COLUMNS = ("scene", "factor", "cost", "cost_low", "cost_high")
ROUNDS = 7
_DIFFUSE = "0.3 * diffuse(N)"
_WEIGHTS = 64


def _ggx(weight: str = "0.3", alpha_x: float = 0.3, alpha_y: float = 0.3, normal: str = "N", distribution: str = "ggx") -> str:
    return f'{weight} * microfacet("{distribution}", {normal}, U, {alpha_x}, {alpha_y}, 0, 0)'


def _schlick(distribution: str) -> str:
    return f'generalized_schlick_bsdf(N, U, color(0.5), color(0), 0.3, 0.3, color(0.04), color(1), 5, "{distribution}")'


def _dielectric(distribution: str) -> str:
    return f'dielectric_bsdf(N, U, color(0.5), color(0), 0.3, 0.3, 1.5, "{distribution}")'


def _lobes(count: int) -> str:
    return " + ".join(_ggx("0.2", 0.2 + 0.1 * i, 0.2 + 0.1 * i) for i in range(count))


def _table(count: int) -> tuple[str, str]:
    """OSL that reads `count` weights from a table by the view, and the sum of as many lobes with them."""
    values = ", ".join("0.2" for _ in range(_WEIGHTS * count))
    reads = "; ".join(
        f"float w{i} = mix(T[{i * _WEIGHTS} + k], T[{i * _WEIGHTS} + k + 1], x - k)" for i in range(count)
    )  # fmt: skip
    before = f"float x = {_WEIGHTS - 1} * clamp(abs(dot(N, I)), 0, 0.9999); int k = (int) x; float T[{_WEIGHTS * count}] = {{{values}}}; {reads};"
    return before, " + ".join(_ggx(f"w{i}", 0.2 + 0.1 * i, 0.2 + 0.1 * i) for i in range(count))


def _layered(count: int) -> str:
    text = _DIFFUSE
    for _ in range(count):
        text = f'layer(dielectric_bsdf(N, U, color(1), color(0), 0.3, 0.3, 1.5, "multi_ggx"), {text})'
    return text


_TILTED = "normalize(N + 0.1 * U)"
# what is timed: statements before, and the closure
FILLING: dict[str, tuple[str, str]] = {
    "diffuse": ("", _DIFFUSE),
    "ggx": ("", _ggx()),
    "ggx, two widths": ("", _ggx(alpha_y=0.15)),
    "ggx, two widths, tilted": ("", _ggx(alpha_y=0.15, normal=_TILTED)),
    "beckmann": ("", _ggx(distribution="beckmann")),
    "beckmann, two widths": ("", _ggx(alpha_y=0.15, distribution="beckmann")),
    "dielectric_bsdf, ggx": ("", _dielectric("ggx")),
    "dielectric_bsdf, multi_ggx": ("", _dielectric("multi_ggx")),
    "generalized_schlick, ggx": ("", _schlick("ggx")),
    "generalized_schlick, multi_ggx": ("", _schlick("multi_ggx")),
    "diffuse + 1 ggx": ("", f"{_DIFFUSE} + {_lobes(1)}"),
    "diffuse + 2 ggx": ("", f"{_DIFFUSE} + {_lobes(2)}"),
    "diffuse + 3 ggx": ("", f"{_DIFFUSE} + {_lobes(3)}"),
    "diffuse + 3 ggx, weights of tables": (_table(3)[0], f"{_DIFFUSE} + {_table(3)[1]}"),
    "layer(), 1 coat": ("", _layered(1)),
    "layer(), 3 coats": ("", _layered(3)),
}
# the same in a corner, where most rays come from other surfaces
CORNER: dict[str, tuple[str, str]] = {
    "diffuse + 1 ggx": FILLING["diffuse + 1 ggx"],
    "diffuse + 3 ggx": FILLING["diffuse + 3 ggx"],
    "diffuse + 3 ggx, but 1 after a diffuse bounce": (
        f'closure color C; if (raytype("diffuse")) C = {_DIFFUSE} + {_lobes(1)}; else C = {_DIFFUSE} + {_lobes(3)};',
        "C",
    ),
    "diffuse + 3 ggx, but 1 after any bounce": (
        f'closure color C; if (raytype("camera")) C = {_DIFFUSE} + {_lobes(3)}; else C = {_DIFFUSE} + {_lobes(1)};',
        "C",
    ),
}


def chart(folder: Path, report: Report) -> None:
    """Write cost_factors.csv and .png and print the table. Raises LaminaError without Blender."""
    table = folder / "cost_factors.csv"
    require_writable(table)
    with blender(lambda text: None):
        rows = _measure(report)
    write_table(table, ("lamina chart cost_factors", f"{ROUNDS} rounds"), COLUMNS, rows, report)
    print_table(COLUMNS, rows)
    if plot := pyplot(report):
        save_picture(_draw(plot, rows), folder / "cost_factors.png", report)


def _measure(report: Report) -> list[tuple[str, ...]]:
    import numpy as np

    from ..pareto.bench import ball, corner, sun_stage, with_material
    from ..pareto.compared_materials import glossy_material, script_material
    from ..pareto.methods import GLOSSY
    from ..pareto.timing import filling_costs

    rows = []
    for scene, factors, meshes, width in (("frame-filling ball", FILLING, [ball()], 1.4), ("ball in a corner", CORNER, corner(), 2.0)):
        materials = {GLOSSY: glossy_material(np.full(3, 0.8), 0.3)}
        for i, (name, (before, closure)) in enumerate(factors.items()):
            shader = f"factor_{len(meshes)}_{i}"
            text = f"shader {shader}(output closure color BSDF = 0) {{ vector U = normalize(cross(N, vector(0.3, 0.5, 0.8))); {before} BSDF = {closure}; }}"
            materials[name] = script_material(shader, text)
        samples = {name: [with_material(mesh, material) for mesh in meshes] for name, material in materials.items()}
        with sun_stage(128) as stage:
            stage.scene.camera.data.ortho_scale = width
            costs = filling_costs(stage, samples, ROUNDS, 16, lambda text: report(f"{scene}: {text}"))
        rows += [(scene, name, *(f"{v:.3f}" for v in (costs[name].ratio, costs[name].low, costs[name].high))) for name in factors]
    return rows


def _draw(plot, rows):
    names = [f"{name}\n({scene})" if scene != rows[0][0] else name for scene, name, *_ in rows]
    cost, low, high = ([float(row[i]) for row in rows] for i in (2, 3, 4))
    figure, axis = plot.subplots(figsize=(8, 0.34 * len(rows) + 1.2), layout="constrained")
    axis.barh(names, cost, color="#3b6ea8")
    axis.errorbar(cost, range(len(rows)), xerr=[[c - l for c, l in zip(cost, low)], [h - c for c, h in zip(cost, high)]], fmt="none", ecolor="black", lw=0.8)
    axis.axvline(1.0, color="black", lw=0.8)
    axis.invert_yaxis()
    axis.tick_params(axis="y", labelsize=8)
    axis.set_xlabel("CPU time over a plain Glossy node (bars: least and most of the rounds)")
    return figure
