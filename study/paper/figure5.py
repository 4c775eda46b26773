# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 5: white matte spheres under a yellow varnish of growing thickness, rendered spectrally."""

import numpy as np

from ...reference_py.fit.drawing import new_figure, style
from .data import FigureData, Statement, is_increasing
from .seen_colors import lightness_chroma_hue, saturation
from .show import show_sphere
from .varnish import THICKNESS, varnished_sphere


def compute(size: int = 128) -> FigureData:
    """The series, and the colour of each sphere's mean light."""
    pictures = [varnished_sphere(thickness, size) for thickness in THICKNESS]
    mean = np.array([np.mean(xyz[picture.on_sphere], axis=0) for xyz, picture in pictures])
    lightness, chroma, hue = lightness_chroma_hue(mean)
    saturated = saturation(mean)
    step = np.diff(hue[1:])
    statements = (
        Statement(
            "the colour decreases",
            "section 3.2.1",
            "L* of the mean light falls with every step of thickness",
            is_increasing(-lightness),
            {f"L* {t:g}": v for t, v in zip(THICKNESS, lightness)},
        ),
        Statement(
            "and the saturation increases",
            "section 3.2.1",
            "s_uv of the mean light rises with every step",
            is_increasing(saturated),
            {f"s_uv {t:g}": v for t, v in zip(THICKNESS, saturated)},
        ),
        Statement(
            "additionally it can change the hue",
            "section 3.2.1",
            "h_ab from the thinnest to the thickest varnish changes by more than 5 degrees",
            abs(hue[-1] - hue[1]) > 5.0,
            {"h_ab 0.4": hue[1], "h_ab 15": hue[-1]},
        ),
        Statement(
            "progressive changes in colour, saturation and hue",
            "caption of figure 5",
            "L*, s_uv and h_ab change in one direction over the whole series of varnished spheres",
            is_increasing(-lightness) and is_increasing(saturated) and bool(np.all(step < 0) or np.all(step > 0)),
            {f"h_ab {t:g}": v for t, v in zip(THICKNESS[1:], hue[1:])},
        ),
    )
    rows = [(t, *values) for t, *values in zip(THICKNESS, lightness, chroma, hue, saturated)]
    arrays = {"spheres": np.array([xyz for xyz, _ in pictures]), "theta_deg": pictures[0][1].theta_deg}
    title = "Figure 5: yellow varnish over matte white, spectral"
    return FigureData("figure5", title, statements, ("thickness", "L*", "C*ab", "h_ab_deg", "s_uv"), rows, arrays)


def draw(data: FigureData):
    """The spheres, and lightness, chroma, saturation and hue over thickness."""
    figure = new_figure(11.0, 4.6, data.title)
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.3))
    for axis, xyz, thickness in zip(above.subplots(1, len(THICKNESS)), data.arrays["spheres"], THICKNESS):
        show_sphere(axis, xyz, data.arrays["theta_deg"], f"thickness {thickness:g}")
    table = np.array(data.rows, float)
    for axis, column, name, first in zip(below.subplots(1, 4), (1, 2, 4, 3), ("L*", "C*ab", "saturation s_uv", "hue h_ab (deg)"), (0, 0, 0, 1)):
        axis.plot(table[first:, 0], table[first:, column], marker="o", markersize=3, color="tab:orange")
        style(axis, f"{name} of the mean light", "thickness", name, legend=False)
    return figure
