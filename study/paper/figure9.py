# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07, figure 9: blue paint at incident angles of 0, 35 and 65 degrees, in the plane of incidence, at 550 nm.

The measurement (Cornell) is not at hand: the fit of Lafortune et al. 1997 stands in for it, its green channel for
550 nm. The base's reflectance at 550 nm is that of the smoothest spectrum of the preset's blue, which is the diffuse
color of the same fit, so the level of the diffuse part is no test.
"""

from dataclasses import replace

import numpy as np

from ...reference_py.fit.drawing import new_figure, style
from ...reference_py.fit.fit_picture import INCIDENT_DEG
from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ...reference_py.models.weidlich_wilkie import WeidlichWilkie
from ...reference_py.optics.colour import standard_wavelengths
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.spectral import smoothest_reflectance, spectral_stack
from ...reference_py.registry import make_model
from .data import FigureData, Statement

VIEW_DEG = np.arange(-88.0, 88.5, 1.0)
"""Positive on the side of the mirror direction."""
WAVELENGTH_NM = 550.0
GREEN = 1
PRINTED = {"distribution": "blinn", "masking": "v_cavity", "oren_nayar": "qualitative_1994"}


def blue_paint(lower_ior: float = 1.3) -> Stack:
    """The preset `blue_wall_paint` at 550 nm alone, with an absolute index for the lower layer."""
    stack = presets.load("blue_wall_paint")
    wavelength_nm = standard_wavelengths()
    blue = smoothest_reflectance(stack.base["color"], wavelength_nm)
    stack = spectral_stack(stack, [WAVELENGTH_NM], color=[np.interp(WAVELENGTH_NM, wavelength_nm, blue)])
    return replace(stack, layers=(stack.layers[0], stack.layers[1].with_values(ior=lower_ior)))


def directions(incident_deg: float, view_deg: np.ndarray = VIEW_DEG) -> tuple[np.ndarray, np.ndarray]:
    """wo (n, 3) and wi (n, 3) in one plane."""
    wo = spherical(np.radians(view_deg), 0.0)
    return wo, np.broadcast_to(spherical(np.radians(incident_deg), np.pi), wo.shape)


def compute(size: int = 128) -> FigureData:
    """f in 1/sr over view angles for the fit and for readings of the model, and the distances between them.

    There are no pixels: `size` has no effect.
    """
    models = {
        "n 1.3 and 1.3 (absolute)": WeidlichWilkie(blue_paint()),
        "n 1.3 and 1.69 (relative 1.3)": WeidlichWilkie(blue_paint(1.69)),
        "absolute; Blinn, V cavities, Oren-Nayar 1994": WeidlichWilkie(blue_paint(), **PRINTED),
    }
    fit = make_model("lafortune", presets.load("blue_wall_paint"))
    curves = {"Lafortune 1997": [fit.f(*directions(a))[:, GREEN] for a in INCIDENT_DEG]}
    curves.update({name: [model.f(*directions(a))[:, 0] for a in INCIDENT_DEG] for name, model in models.items()})
    rows = []
    for name, values in curves.items():
        for angle, f, reference in zip(INCIDENT_DEG, values, curves["Lafortune 1997"]):
            inner = np.abs(VIEW_DEG) <= 80.0
            error = float(np.sqrt(np.mean(np.square(f[inner] / reference[inner] - 1.0))))
            peak = int(np.argmax(np.where(VIEW_DEG > 0.0, f, 0.0)))
            rows.append((name, angle, error, float(VIEW_DEG[peak]), float(f[peak]), float(np.interp(-angle, VIEW_DEG, f))))
    columns = ("curve", "incident_deg", "rms_relative_difference_to_80deg", "forward_peak_deg", "forward_peak_f", "f_towards_light")
    arrays = {name: np.array(values) for name, values in curves.items()}
    title = "Figure 9: blue paint at 550 nm; the green channel of Lafortune's fit stands in for the measurement"
    return FigureData("figure9", title, _statements(models), columns, rows, arrays)


def _statements(models) -> tuple[Statement, ...]:
    absolute, relative = models["n 1.3 and 1.3 (absolute)"], models["n 1.3 and 1.69 (relative 1.3)"]
    wo, wi = directions(65.0)
    top, lower, base = (part[:, 0] for part in relative.components(wo, wi))
    forward = np.flatnonzero(VIEW_DEG > 0.0)
    peak = forward[np.argmax(top[forward])]
    total = top + lower + base
    lower_35 = relative.components(*directions(35.0))[1][:, 0]
    base_35 = absolute.components(*directions(35.0, np.array([-35.0, 35.0])))[-1][:, 0]
    clear = replace(absolute.stack, layers=tuple(layer.with_values(tint=(1.0,)) for layer in absolute.stack.layers))
    ends = directions(0.0, np.array([0.0, 80.0, 88.0]))
    kept = absolute.components(*ends)[-1][:, 0] / np.maximum(WeidlichWilkie(clear).components(*ends)[-1][:, 0], 1e-300)
    reflects = float(np.max(absolute.components(wo, wi)[1]))
    return (
        Statement(
            "[The topmost] layer is responsible for the rather strong off-specular reflection",
            "section 6.2",
            "at 65 degrees its lobe peaks beyond the mirror direction and is more than half of all there",
            bool(VIEW_DEG[peak] > 65.0 and top[peak] > 0.5 * total[peak]),
            {"peak deg": float(VIEW_DEG[peak]), "share": float(top[peak] / total[peak])},
        ),
        Statement(
            "this second layer does not produce a strong off-specular reflection",
            "section 6.2; index read as relative",
            "at 65 degrees its largest value is below a tenth of the top layer's",
            bool(np.max(lower) < 0.1 * np.max(top)),
            {"lower": float(np.max(lower)), "top": float(np.max(top)), "lower at 35 deg": float(np.max(lower_35))},
        ),
        Statement(
            "The underlying layer is another Torrance-Sparrow layer with a refractive index of 1.3",
            "section 6.2; index read as absolute, like that of the layer above",
            "the lower interface reflects anything at all",
            reflects > 0.0,
            {"largest f": reflects},
        ),
        Statement(
            "To reproduce the retro-reflective properties we used an Oren-Nayar surface",
            "section 6.2",
            "the base's part is larger towards the light than towards the mirror direction at 35 degrees",
            bool(base_35[0] > base_35[1]),
            {"towards light": base_35[0], "mirror": base_35[1]},
        ),
        Statement(
            "the clear varnish turns successively opaque at very shallow grazing angles",
            "section 6.2",
            "what absorption (tint .97 is ours) leaves of the base's part under perpendicular light falls from 0 over 80 to 88 degrees, to below a half",
            bool(kept[0] > kept[1] > kept[2] and kept[2] < 0.5),
            {"0 deg": kept[0], "80 deg": kept[1], "88 deg": kept[2]},
        ),
    )


def draw(data: FigureData):
    """One panel per incident angle."""
    figure = new_figure(11.0, 3.8, data.title)
    styles = {"color": "black", "linestyle": "--"}, {"color": "tab:blue"}, {"color": "tab:green"}, {"color": "tab:gray", "linewidth": 1}
    panels = figure.subplots(1, 3)
    for i, (axis, angle) in enumerate(zip(panels, INCIDENT_DEG)):
        for (name, values), look in zip(data.arrays.items(), styles):
            axis.plot(VIEW_DEG, values[i], label=name, **look)
        axis.axvline(-angle, color="tab:orange", linewidth=0.8, linestyle=":")
        axis.set(ylim=(0.0, (0.2, 0.2, 0.8)[i]))
        style(axis, f"incident at {angle:g}° (dotted: towards the light)", "view angle (degrees)", "f (1/sr)", legend=i == 0)
    return figure
