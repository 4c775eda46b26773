# SPDX-License-Identifier: GPL-3.0-or-later
"""What absorption in three RGB channels gets wrong against absorption per wavelength, for the varnish of figure 5.

The RGB tint is the colour that white light has after one crossing of unit thickness, so it is right there by definition.
"""

import numpy as np

from ...reference_py.fit.drawing import new_figure, style
from ...reference_py.optics.colour import reflectance_to_rgb
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model
from ..colorimetry import delta_e_2000
from .data import FigureData, Statement
from .seen_colors import band_means, band_names
from .show import show_sphere
from .varnish import THICKNESS, WAVELENGTH_NM, spectral_varnish, varnished_sphere


def compute(size: int = 128) -> FigureData:
    """CIEDE2000 between both series, and how well Bouguer's law holds in either."""
    spectral = [varnished_sphere(thickness, size) for thickness in THICKNESS]
    rgb = [varnished_sphere(thickness, size, False)[0] for thickness in THICKNESS]
    theta = spectral[0][1].theta_deg
    rows = []
    for thickness, (reference, picture), broad in zip(THICKNESS, spectral, rgb):
        error = delta_e_2000(reference, broad)
        rows.append((thickness, *band_means(error, theta), float(np.mean(error[picture.on_sphere]))))
    per_wavelength, per_channel = _bouguer_errors()
    statements = (
        Statement(
            "I = I0 exp(-alpha l), where alpha is the wavelength dependent absorption coefficient",
            "section 3.2.1, eq. 5",
            "doubling the thickness squares the transmittance: largest relative error per wavelength below 1e-9",
            per_wavelength < 1e-9,
            {"per wavelength": per_wavelength, "green channel of the same light": per_channel},
        ),
    )
    arrays = {"spectral": np.array([xyz for xyz, _ in spectral]), "rgb": np.array(rgb), "theta_deg": theta}
    columns = ("thickness", *(f"deltaE2000_{name}" for name in band_names()), "deltaE2000_sphere")
    return FigureData("spectral", "Absorption per RGB channel against absorption per wavelength", statements, columns, rows, arrays)


def _bouguer_errors() -> tuple[float, float]:
    """Largest relative errors of f(2 d) f(0) = f(d)^2, base component, per wavelength and in the green they integrate to."""
    wo, wi = spherical(np.radians([0.0, 30.0, 60.0]), 0.0), spherical(np.radians([20.0, 50.0, 40.0]), 2.0)
    values = [make_model("weidlich_wilkie", spectral_varnish(d)).components(wo, wi)[-1] for d in (0.0, 1.6, 3.2)]
    colours = [reflectance_to_rgb(value, WAVELENGTH_NM)[..., 1] for value in values]
    return tuple(float(np.max(np.abs(two * none / one**2 - 1.0))) for none, one, two in (values, colours))


def draw(data: FigureData):
    """Both series and the error over thickness."""
    figure = new_figure(11.0, 5.6, data.title)
    above, below = figure.subfigures(2, 1, height_ratios=(1.3, 1.0))
    axes = above.subplots(2, len(THICKNESS))
    for line, kind in zip(axes, ("spectral", "rgb")):
        for axis, xyz, thickness in zip(line, data.arrays[kind], THICKNESS):
            show_sphere(axis, xyz, data.arrays["theta_deg"], f"{'RGB' if kind == 'rgb' else kind}, {thickness:g}")
    axis = below.subplots()
    table = np.array(data.rows, float)
    for column, name in enumerate((*band_names(), "whole sphere"), 1):
        axis.plot(
            table[:, 0],
            table[:, column],
            marker="o",
            markersize=3,
            label=name.replace("deg", "°"),
            **({"color": "black", "linewidth": 2} if column == 5 else {}),
        )
    axis.set_xscale("symlog", linthresh=0.4)
    axis.set_xticks(THICKNESS, [f"{t:g}" for t in THICKNESS])
    style(axis, "error of RGB absorption by view angle", "thickness", "mean CIEDE2000")
    return figure
