# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart viewport`: presets as EEVEE shows their stock nodes, beside Cycles' pictures of the same nodes and of OSL."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.material import presets
from ..colorimetry import colour_science
from ..tables import Report, write_table
from .output import print_table

SIZE = 96
SAMPLES, EEVEE_SAMPLES = 64, 128
COLUMNS = ("material", "closures", "eevee_delta_e", "eevee_energy", "nodes_delta_e", "nodes_energy")
# Those of the paper, one that is anisotropic and one of pearls: a material takes a minute without a graphics card.
MATERIALS = (*presets.PAPER, "brushed_nickel", "pearl_coating")
_IN_A_ROW = 4


def chart(folder: Path, report: Report, surface: Sequence[str] = MATERIALS) -> None:
    """Write viewport.csv and viewport.png of presets or stacks of the suite.

    Raises LaminaError without OSL, without colour-science, and without a Blender that has EEVEE.
    """
    table, sheet = folder / "viewport.csv", folder / "viewport.png"
    for path in (table, sheet):
        require_writable(path)
    colour_science()
    with blender(lambda text: None):
        heading, rows = _measure(surface, sheet, report)
    report(f"wrote {sheet}")
    write_table(table, heading, COLUMNS, rows, report)
    print_table(COLUMNS, rows)


def _measure(names: Sequence[str], sheet: Path, report: Report) -> tuple[tuple[str, ...], list[list[str]]]:
    from ...addon.blender.images import write_png
    from ...addon.material.backend import require_osl
    from ...addon.rendering.sheet import Tile, compose
    from ..pareto.ball_picture import Surroundings, ball_normals, difference, encoded, shown
    from ..pareto.bench import ball, with_material
    from ..viewport.compared import lit_stage, samples
    from ..viewport.eevee_pictures import blender_version, eevee_pictures

    require_osl()
    heading = ("lamina chart viewport", f"EEVEE of Blender {blender_version()}, {EEVEE_SAMPLES} samples",
               f"Cycles, {SAMPLES} samples", "against Cycles with OSL")  # fmt: skip
    surroundings = Surroundings()
    inside = np.isfinite(ball_normals(SIZE)[..., :1])
    made = samples(names, report)
    item = with_material(ball(), made[0].nodes)
    rows, pictures = [], []
    with lit_stage(SIZE, surroundings, item) as stage:
        by_eevee = eevee_pictures(stage.scene, item, [s.nodes for s in made], EEVEE_SAMPLES, report)
        for sample, eevee in zip(made, by_eevee):
            report(f"Cycles, {sample.label}")
            osl = _render(stage, item, sample.osl)
            nodes = osl if sample.closures is None else _render(stage, item, sample.nodes)
            eevee, nodes, osl = (np.where(inside, picture, np.nan) for picture in (eevee, nodes, osl))
            cells = [f"{value:.4f}" for picture in (eevee, nodes) for value in (difference(picture, osl, surroundings), _energy(picture, osl))]
            rows.append([sample.label, "" if sample.closures is None else str(sample.closures), *cells])
            pictures.append(encoded(shown(np.nan_to_num(np.concatenate([eevee, nodes, osl], axis=1)) * surroundings.exposure)))
    tiles = [Tile(row[0], made[0].nodes, f"CIEDE2000 of EEVEE: {float(row[2]):.1f}") for row in rows]
    write_png(sheet, compose(pictures, tiles, _IN_A_ROW, "EEVEE, Cycles with stock nodes, Cycles with OSL"))
    return heading, rows


def _render(stage, item, material) -> np.ndarray:
    item.material_slots[0].material = material
    return stage.picture(SAMPLES)


def _energy(picture: np.ndarray, truth: np.ndarray) -> float:
    """Relative error of a picture's mean radiance, of the channel where it is worst."""
    error = np.nanmean(picture, axis=(0, 1)) / np.nanmean(truth, axis=(0, 1)) - 1.0
    return float(error[np.argmax(np.abs(error))])
