# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart pareto`: error against cost of every way to render a layered material in Cycles, by surface type."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ..colorimetry import colour_science
from ..pareto.draw import draw
from ..pareto.quality import Quality
from ..pareto.surface_types import SURFACES, label, load_surface
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

COLUMNS = (
    "surface", "method", "label", "closures", "cost", "cost_low", "cost_high", "scene_cost", "albedo", "shape", "shape_mean",
    "delta_e", "delta_e_render", "over_slab", "memory_mb", "shader_bytes", "compile_s", "bake_s",
)  # fmt: skip
FULL = Quality()
_SHOWN = ("surface", "method", "closures", "cost", "scene_cost", "albedo", "shape", "delta_e", "over_slab", "memory_mb", "shader_bytes", "compile_s")


def chart(folder: Path, report: Report, surface: Sequence[str] = tuple(SURFACES), rounds: int = Quality.rounds, quality: Quality = FULL) -> None:
    """Write pareto.csv and .png and print the table. Raises LaminaError on an unknown surface, without Blender or colour-science."""
    table = folder / "pareto.csv"
    require_writable(table)
    colour_science()
    stacks = {name: load_surface(name) for name in surface}
    quality = replace(quality, rounds=rounds)
    rows = []
    with blender(lambda text: None):
        from ..pareto.columns import measure

        for i, (name, stack) in enumerate(stacks.items()):
            share = f"{100 * i // len(stacks):3} % {name}"
            results, _ = measure(name, stack, quality, lambda text: report(f"{share}: {text}"))
            rows += [dict(zip(COLUMNS, _cells(name, result))) for result in results]
    heading = ("lamina chart pareto", f"{quality.rounds} rounds", "columns as in docs/accuracy.md")
    write_table(table, heading, COLUMNS, [[row[c] for c in COLUMNS] for row in rows], report)
    print_table(_SHOWN, [[row[c] for c in _SHOWN] for row in rows])
    if plot := pyplot(report):
        save_picture(draw(plot, rows, label), folder / "pareto.png", report)


def _cells(name: str, result) -> list[str]:
    method, errors, cost = result.method, result.errors, result.cost

    def cell(value, digits: str) -> str:
        return "" if value is None else format(value, digits)

    return [
        name, method.name, method.label, cell(method.closures, "d"), *(f"{v:.3f}" for v in (cost.ratio, cost.low, cost.high)),
        cell(result.scene and result.scene.ratio, ".3f"), *(f"{v:.5f}" for v in (errors.albedo, errors.shape, errors.shape_mean)),
        f"{result.delta_e:.3f}", f"{result.delta_e_render:.3f}", cell(result.over_slab, ".1f"), cell(result.memory_mb, ".2f"), cell(result.shader_bytes, "d"),
        cell(result.compile_seconds, ".3f"), cell(method.bake_seconds, ".1f"),
    ]  # fmt: skip
