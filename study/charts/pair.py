# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart pair`: the same car paint by Cycles' layer(), by Lamina, and as explicit geometry, beside the truth."""

from pathlib import Path

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.material import presets
from ...reference_py.models.adding.adding_model import Adding
from ..colorimetry import colour_science
from ..tables import Report
from .output import print_table

SURFACE, SIZE = "metallic_car_paint", 160
SAMPLES, SLAB_SAMPLES = 144, 256


def chart(folder: Path, report: Report) -> None:
    """Write pair.png and print each picture's mean CIEDE2000 against the truth's. Raises LaminaError without Blender or colour-science."""
    path = folder / "pair.png"
    require_writable(path)
    colour_science()
    with blender(lambda text: None):
        errors = _render(path, report)
    report(f"wrote {path}")
    print_table(("picture", "samples", "mean CIEDE2000"), errors)


def _render(path: Path, report: Report) -> list[tuple[str, str, str]]:
    import bpy
    import numpy as np

    from ...addon.blender.images import write_png
    from ...addon.material.material import apply_stack, refresh
    from ...addon.rendering.sheet import Tile, compose
    from ..pareto.ball_picture import Surroundings, ball_picture, difference, encoded, shown
    from ..pareto.bench import ball, studio_stage, with_material
    from ..pareto.columns import widths_of
    from ..pareto.compared_materials import layer_text, script_material
    from ..pareto.explicit_slab import slab_objects
    from ..pareto.reflectance import TruthReflectance

    stack = presets.load(SURFACE)
    report("truth")
    surroundings = Surroundings()
    exact = ball_picture(TruthReflectance(Adding(stack)), widths_of(stack), SIZE, surroundings)
    lamina = bpy.data.materials.new("Lamina")
    apply_stack(lamina, stack)
    refresh(lamina, settle=True)
    surface = ball()
    samples = {
        "Cycles' layer()": ([with_material(surface, script_material("layered", layer_text(stack, "layered")))], SAMPLES),
        "Lamina": ([with_material(surface, lamina)], SAMPLES),
        "Explicit geometry": (slab_objects(stack, ball), SLAB_SAMPLES),
    }
    pictures, tiles, errors = [], [], []
    inside = np.isfinite(exact[..., :1])
    with studio_stage(SIZE, surroundings) as stage:
        for label, (objects, spp) in samples.items():
            report(label)
            stage.show(objects)
            picture = stage.picture(spp)
            error = difference(picture, exact, surroundings)
            errors.append((label, str(spp), f"{error:.2f}"))
            pictures.append(encoded(shown(np.where(inside, picture, 0.0) * surroundings.exposure)))
            tiles.append(Tile(label, lamina, f"CIEDE2000 {error:.1f}"))
    pictures.append(encoded(shown(np.where(inside, exact, 0.0) * surroundings.exposure)))
    tiles.append(Tile("Truth", lamina, "integrated, no render"))
    write_png(path, compose(pictures, tiles, len(tiles), presets.label(SURFACE)))
    return errors
