# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 3: surface type b with and without absorption, and their difference in hue, chroma, lightness.

The caption leaves open what "with otherwise identical colour" means. Two readings; the picture has the first:

- "same colour": without absorption, paint under a clear varnish has the colour that the tinted varnish gives at a
  perpendicular crossing, in and out. What differs is then the length of the path alone.
- "switched off": paint of that colour in both, once under the tinted and once under the clear varnish.

Nor does the paper name the varnish's colour here, so a sentence counts as true if it is for all of `BANDS`.
"""

from dataclasses import replace

import numpy as np

from ...reference_py.fit.drawing import new_figure
from ...reference_py.registry import make_model
from .data import FigureData, Statement
from .seen_colors import band_means, band_names, hue_difference, lightness_chroma_hue, xyz_of_spectra
from .show import show_map, show_sphere
from .sphere import Picture, render
from .varnish import BANDS, WAVELENGTH_NM, optical_depth, spectral_varnish

THICKNESS = 0.8
READINGS = ("same colour", "switched off")
# The least difference in L*a*b* that is held to be visible (Mahy 1994, Color Res. Appl. 19(2), 105-121).
JUST_NOTICEABLE = 2.3


def compute(size: int = 128) -> FigureData:
    """All spheres, and mean absolute differences by band of view angle."""
    rows, means, pictures = [], {}, {}
    for varnish in BANDS:
        pictures[varnish] = _spheres(varnish, size)
        absorbing, painted, both = pictures[varnish]
        for reading, (first, second) in zip(READINGS, ((absorbing, painted), (both, painted))):
            for name, values in _differences(first[0], second[0]).items():
                theta = first[1].theta_deg
                bands = (*band_means(np.abs(values), theta), np.mean(np.abs(values[np.isfinite(theta)])))
                rows.append((varnish, reading, f"abs_delta_{name}", *bands))
                means[varnish, reading, name] = bands
    statements = tuple(s for reading in READINGS for s in _statements(means, reading))
    absorbing, painted, _ = pictures["yellow"]
    arrays = {"with": absorbing[0], "without": painted[0], "theta_deg": absorbing[1].theta_deg, **_differences(absorbing[0], painted[0])}
    columns = ("varnish", "reading", "mean", *band_names(), "sphere")
    return FigureData("figure3", "Figure 3: tinted glaze with and without absorption", statements, columns, rows, arrays)


def _statements(means, reading: str) -> tuple[Statement, ...]:
    hue, chroma, lightness = ({v: means[v, reading, name] for v in BANDS} for name in "HCL")
    where = f"caption of figure 3, read as {reading}"

    def considerable(name: str, values) -> Statement:
        return Statement(
            f"chroma and lightness change considerably: {name}",
            where,
            f"mean |Delta| over the sphere above {JUST_NOTICEABLE}, just noticeable, and above that of hue",
            all(values[v][-1] > max(JUST_NOTICEABLE, hue[v][-1]) for v in BANDS),
            {v: values[v][-1] for v in BANDS},
        )

    def grazing(name: str, values) -> Statement:
        return Statement(
            f"mainly at grazing angles: {name}",
            where,
            "mean |Delta| larger at 50-70 than at 0-30 degrees; the ratio",
            all(values[v][2] > values[v][0] for v in BANDS),
            {v: values[v][2] / values[v][0] for v in BANDS},
        )

    return (
        Statement(
            "there are practically no hue differences",
            where,
            f"mean |Delta H*| over the sphere below {JUST_NOTICEABLE}, just noticeable",
            all(hue[v][-1] < JUST_NOTICEABLE for v in BANDS),
            {v: hue[v][-1] for v in BANDS},
        ),
        considerable("chroma", chroma),
        considerable("lightness", lightness),
        grazing("chroma", chroma),
        grazing("lightness", lightness),
    )


def _spheres(varnish: str, size: int) -> list[tuple[np.ndarray, Picture]]:
    """XYZ and picture of: tinted varnish over white, clear varnish over paint of its colour, tinted over that paint."""
    tinted, clear = spectral_varnish(THICKNESS, varnish), spectral_varnish(0.0, varnish)
    color = np.array(clear.base["color"]) * np.exp(-2.0 * THICKNESS * optical_depth(varnish))
    paint = clear.base.with_values(color=tuple(color))
    stacks = (tinted, replace(clear, base=paint), replace(tinted, base=paint))
    pictures = [render(make_model("weidlich_wilkie", stack), size) for stack in stacks]
    return [(xyz_of_spectra(picture.radiance, WAVELENGTH_NM), picture) for picture in pictures]


def _differences(first, second) -> dict[str, np.ndarray]:
    l1, c1, _ = lightness_chroma_hue(first)
    l2, c2, _ = lightness_chroma_hue(second)
    return {"H": hue_difference(second, first), "C": c1 - c2, "L": l1 - l2}


def draw(data: FigureData):
    """Both spheres and three difference maps on one scale."""
    figure = new_figure(11.0, 2.6, f"{data.title}: absorbing minus painted in the same colour under clear varnish")
    axes = figure.subplots(1, 5)
    theta = data.arrays["theta_deg"]
    show_sphere(axes[0], data.arrays["with"], theta, "with absorption")
    show_sphere(axes[1], data.arrays["without"], theta, "without, same colour")
    shown = np.isfinite(theta)
    limit = max(np.percentile(np.abs(data.arrays[k][shown]), 99.0) for k in "HCL")
    for axis, key, name in zip(axes[2:], "HCL", ("hue", "chroma", "lightness")):
        show_map(figure, axis, np.where(shown, data.arrays[key], np.nan), f"$\\Delta {key}^*$ ({name})", limit)
    return figure
