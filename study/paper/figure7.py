# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 7: frosted red paint, metallic car paint, blue wall paint."""

import numpy as np

from ...reference_py.fit.drawing import new_figure
from ...reference_py.material import presets
from .data import FigureData, Statement
from .seen_colors import lightness_chroma_hue
from .show import show_sphere
from .spheres import preset_sphere, stack_sphere, with_top

SHOWN = {"c": "frosted_paint", "e": "metallic_car_paint", "h": "blue_wall_paint"}
# As rough as a varnish without finish: the car paint's .1 degree.
GLOSSY_ROUGHNESS = 0.044378


def compute(size: int = 128) -> FigureData:
    """The spheres, and two variants that the sentences speak of."""
    spheres = {name: preset_sphere(name, size) for name in SHOWN.values()}
    glossy, _ = stack_sphere(with_top(presets.load("frosted_paint"), roughness=GLOSSY_ROUGHNESS), size)
    clear, _ = stack_sphere(with_top(presets.load("metallic_car_paint"), tint=(1.0, 1.0, 1.0)), size)
    frosted_peak, glossy_peak = (float(np.max(xyz[..., 1])) for xyz in (spheres["frosted_paint"][0], glossy))
    on_sphere = spheres["frosted_paint"][1].on_sphere
    chroma, clear_chroma = (_mean_chroma(xyz, on_sphere) for xyz in (spheres["metallic_car_paint"][0], clear))
    statements = (
        Statement(
            "a gloss-reducing finish",
            "section 6.1, type c",
            "the brightest spot of the frosted sphere is less than half that of the same varnish with .1 degree",
            frosted_peak < 0.5 * glossy_peak,
            {"frosted Y": frosted_peak, "glossy Y": glossy_peak},
        ),
        Statement(
            "The colour of the paint is only due to absorption in the tinted varnish",
            "section 6.1, type e",
            "mean C* with a clear varnish is below a tenth of that with the tinted one",
            clear_chroma < 0.1 * chroma,
            {"C* tinted": chroma, "C* clear": clear_chroma},
        ),
    )
    rows = []
    for name, (xyz, picture) in spheres.items():
        mean = np.mean(xyz[picture.on_sphere], axis=0)
        rows.append((name, *(float(v) for v in lightness_chroma_hue(mean)), float(np.max(xyz[..., 1]))))
    arrays = {**{name: xyz for name, (xyz, _) in spheres.items()}, "theta_deg": picture.theta_deg}
    title = "Figure 7: frosted paint, metallic car paint, blue wall paint"
    return FigureData("figure7", title, statements, ("preset", "mean_L*", "mean_C*ab", "mean_h_ab_deg", "largest_Y"), rows, arrays)


def _mean_chroma(xyz, on_sphere) -> float:
    return float(np.mean(lightness_chroma_hue(xyz[on_sphere])[1]))


def draw(data: FigureData):
    """Three spheres."""
    figure = new_figure(7.5, 2.9, data.title)
    for axis, (letter, name) in zip(figure.subplots(1, 3), SHOWN.items()):
        show_sphere(axis, data.arrays[name], data.arrays["theta_deg"], f"{letter}) {presets.label(name)}")
    return figure
