# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 8, as spheres: crayon and mug (a), foil and frosted metal (d, f), copper and its patina (g).

The orbs of figure 8b are matte. Read literally, eq. 2 refracts both directions about one half vector, so the rough coat
does not widen the silver's lobe: a sharp reflection stays under the frosting.
"""

import numpy as np

from ...reference_py.fit.drawing import new_figure
from ...reference_py.material import presets
from ...reference_py.registry import make_model
from .data import FigureData, Statement
from .seen_colors import lightness_chroma_hue
from .show import show_sphere
from .spheres import preset_sphere

PAIRS = (("crayon_paint", "glazed_mug"), ("metal_foil", "frosted_metal"), ("clean_copper", "patina_copper"))


def compute(size: int = 128) -> FigureData:
    """The spheres, and the brightness of their highlights."""
    spheres = {name: preset_sphere(name, size) for pair in PAIRS for name in pair}
    rows, means, peak = [], {}, {}
    for name, (xyz, picture) in spheres.items():
        lightness, chroma, hue = (float(v) for v in lightness_chroma_hue(np.mean(xyz[picture.on_sphere], axis=0)))
        means[name], peak[name] = (lightness, chroma, hue), float(np.max(xyz[..., 1]))
        rows.append((name, *means[name], peak[name]))
    up = np.array([[0.0, 0.0, 1.0]])
    crayon, mug = (float(make_model("weidlich_wilkie", presets.load(name)).specular_albedo(up)[0, 0]) for name in PAIRS[0])
    clean, patina = (means[name] for name in PAIRS[2])
    statements = (
        Statement(
            "ceramic glazing has brighter specular reflections than paintwork",
            "section 6.1, type a",
            "mirror reflectance of mug (n 1.6) above that of crayon (n 1.3) at normal incidence",
            mug > crayon,
            {"crayon": crayon, "mug": mug},
        ),
        Statement(
            "matte christmas orbs",
            "section 6.1, type f, against the metal foil of type d",
            "the brightest spot of the frosted metal is less than a third of the foil's",
            peak["frosted_metal"] < peak["metal_foil"] / 3.0,
            {"frosted Y": peak["frosted_metal"], "foil Y": peak["metal_foil"]},
        ),
        Statement(
            "clean copper has a bright colour; the patina is a strongly absorptive layer",
            "section 6.1, type g",
            "L* of the mean light falls by more than 10 and its hue turns towards green by more than 20 degrees",
            clean[0] - patina[0] > 10.0 and patina[2] - clean[2] > 20.0,
            {"L* clean": clean[0], "L* patina": patina[0], "h_ab clean": clean[2], "h_ab patina": patina[2]},
        ),
    )
    arrays = {**{name: xyz for name, (xyz, _) in spheres.items()}, "theta_deg": picture.theta_deg}
    columns = ("preset", "mean_L*", "mean_C*ab", "mean_h_ab_deg", "largest_Y")
    return FigureData("figure8", "Figure 8, as spheres", statements, columns, rows, arrays)


def draw(data: FigureData):
    """Three pairs of spheres."""
    figure = new_figure(11.0, 2.4, data.title)
    names = [name for pair in PAIRS for name in pair]
    for axis, name in zip(figure.subplots(1, 6), names):
        show_sphere(axis, data.arrays[name], data.arrays["theta_deg"], presets.label(name))
    return figure
