# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 6: the surface types a to h under the same illumination."""

import numpy as np

from ...reference_py.fit.drawing import new_figure
from ...reference_py.material import presets
from .data import FigureData, Statement, is_increasing
from .seen_colors import band_means, band_names, lightness_chroma_hue, saturation
from .show import show_sphere
from .spheres import BaseOnly, preset_sphere, stack_sphere

TYPES = {
    "a": "glazed_mug",
    "b": "tinted_glaze",
    "c": "frosted_paint",
    "d": "metal_foil",
    "e": "metallic_car_paint",
    "f": "frosted_metal",
    "g": "patina_copper",
    "h": "blue_wall_paint",
}


def compute(size: int = 128) -> FigureData:
    """The spheres, their saturation by band of view angle, and that of the light from below the varnish of a and b."""
    rows, spheres = [], []
    for letter, name in TYPES.items():
        xyz, picture = preset_sphere(name, size)
        spheres.append(xyz)
        theta = picture.theta_deg
        lightness, chroma, _ = lightness_chroma_hue(xyz)
        for quantity, values in (("L*", lightness), ("C*ab", chroma), ("s_uv", saturation(xyz))):
            rows.append((letter, name, "all light", quantity, *band_means(values, theta)))
    through = {letter: _saturation_through_varnish(TYPES[letter], size, theta) for letter in "ab"}
    for letter, bands in through.items():
        rows.append((letter, TYPES[letter], "through the varnish", "s_uv", *bands))
    total = {row[0]: np.array(row[4:]) for row in rows if row[2:4] == ("all light", "s_uv")}
    spread_a, spread_b = (float(np.ptp(through[letter]) / np.mean(through[letter])) for letter in "ab")
    statements = (
        Statement(
            "the colour usually increases in saturation towards grazing angles",
            "section 6.1, type b",
            "s_uv of the light through the varnish rises from band to band",
            is_increasing(through["b"]),
            dict(zip(band_names(), through["b"])),
        ),
        Statement(
            "the colour usually increases in saturation towards grazing angles",
            "section 6.1, type b",
            "s_uv of all light, with the white reflection of the surroundings, rises from band to band",
            is_increasing(total["b"]),
            dict(zip(band_names(), total["b"])),
        ),
        Statement(
            "in case a the colour largely stays the same everywhere on the object regardless of curvature",
            "section 6.1, type b",
            "spread of s_uv over the bands, through the varnish, below 5 % and below that of b",
            spread_a < min(0.05, spread_b),
            {"spread a": spread_a, "spread b": spread_b},
        ),
    )
    arrays = {"spheres": np.array(spheres), "theta_deg": theta}
    columns = ("type", "preset", "light", "mean", *band_names())
    return FigureData("figure6", "Figure 6: surface types a to h", statements, columns, rows, arrays)


def _saturation_through_varnish(name: str, size: int, theta_deg) -> np.ndarray:
    stack = presets.load(name)
    xyz, _ = stack_sphere(stack, size, BaseOnly(stack))
    lit = np.where(xyz[..., 1] > 0.0, theta_deg, np.nan)  # the model sends nothing from below at the very rim
    return band_means(saturation(xyz), lit)


def draw(data: FigureData):
    """Eight spheres."""
    figure = new_figure(8.0, 4.6, data.title)
    for axis, xyz, (letter, name) in zip(figure.subplots(2, 4).flat, data.arrays["spheres"], TYPES.items()):
        show_sphere(axis, xyz, data.arrays["theta_deg"], f"{letter}) {presets.label(name)}")
    return figure
