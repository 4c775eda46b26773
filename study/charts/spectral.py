# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart spectral`: copper under an amber glaze, wavelength by wavelength: the truth, bakes of it, and what three channels make of its color.

A bake takes three wavelengths for its three channels, as every channel is a grey problem of its own.
"""

from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import ciede2000, lab_of_linear, reflectance_to_rgb, rgb_weights, srgb_encoded
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.spectral import SpectralStack, spectral_stack
from ...reference_py.registry import make_model
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture
from .tint_spectrum import ALBEDO_OPTIONS, DEPTHS, WAVELENGTH_NM

THICKNESS, VIEWS_DEG = (0.0, 1.0, 2.0, 5.0), (0.0, 75.0)
# The glaze that is baked, and every so many wavelengths.
_BAKED_THICKNESS, _BAKED_EVERY = 5.0, 5
_AMBER = np.exp(-DEPTHS["amber"])
COLUMNS = ("thickness", "view_deg", "spectral", "rgb", "tint_spectrum", "delta_e_rgb", "delta_e_tint_spectrum")
HEADING = (
    "lamina chart spectral -o figures",
    "copper of roughness .3 under a smooth amber glaze of index 1.5: color of its albedo by adding at 41 wavelengths, in three channels with the glaze's",
    "tint in RGB, and with its tint_spectrum; CIEDE2000 from the first",
)


def glazed(thickness: float, **tint) -> Stack:
    """Copper under a smooth glaze."""
    layers = [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0, "thickness": thickness, **tint}]
    return Stack.from_dict({"layers": layers, "base": {"kind": "conductor", "metal": "copper", "roughness": 0.3}})


def spectral(thickness: float) -> SpectralStack:
    """The same at all wavelengths."""
    return spectral_stack(glazed(thickness), WAVELENGTH_NM, tints={0: _AMBER})


def colors(thickness: float) -> np.ndarray:
    """Linear Rec.709 (3, views, 3) of the albedo: spectral, with a tint in RGB, with a `tint_spectrum`."""
    views = spherical(np.radians(VIEWS_DEG), 0.0)
    in_rgb = np.clip(reflectance_to_rgb(_AMBER, WAVELENGTH_NM), 0.0, 1.0).tolist()
    given = {"wavelengths_nm": WAVELENGTH_NM.tolist(), "transmittance": _AMBER.tolist()}
    truth = make_model("adding", spectral(thickness), **ALBEDO_OPTIONS).albedo(views) @ rgb_weights(WAVELENGTH_NM)
    return np.stack(
        [truth, *(make_model("adding", glazed(thickness, **tint), **ALBEDO_OPTIONS).albedo(views) for tint in ({"tint": in_rgb}, {"tint_spectrum": given}))]
    )


def baked(thickness: float, chosen: np.ndarray) -> np.ndarray:
    """Albedo (views, n) of bakes of the chosen wavelengths, a multiple of three."""
    stack, views = spectral(thickness), spherical(np.radians(VIEWS_DEG), 0.0)
    return np.concatenate([make_model("closure_model", three_channels(stack, part), method="baked").albedo(views) for part in chosen.reshape(-1, 3)], axis=-1)


def three_channels(stack: SpectralStack, chosen: np.ndarray) -> Stack:
    """Three of a stack's wavelengths as the channels of one for shaders."""
    (glaze,), base = stack.layers, stack.base
    of_base = {name: tuple(np.array(base[name])[chosen]) for name in ("eta", "k")}
    return Stack((glaze.with_values(tint=tuple(np.array(glaze["tint"])[chosen])),), base.with_values(**of_base))


def rows() -> list[list[str]]:
    """One row for each thickness and view."""
    found = []
    for thickness in THICKNESS:
        for view, *three in zip(VIEWS_DEG, *colors(thickness)):
            off = (ciede2000(lab_of_linear(three[0]), lab_of_linear(color)) for color in three[1:])
            found.append([f"{thickness:g}", f"{view:g}", *(" ".join(f"{v:.4f}" for v in color) for color in three), *(f"{v:.2f}" for v in off)])
    return found


def chart(folder: Path, report: Report) -> None:
    """Write spectral.csv and spectral.png."""
    for suffix in (".csv", ".png"):
        require_writable(folder / f"spectral{suffix}")
    found = rows()
    print_table(COLUMNS, found)
    write_table(folder / "spectral.csv", HEADING, COLUMNS, found, report)
    plt = pyplot(report)
    if plt is None:
        return
    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.2), width_ratios=(1.0, 1.0, 0.7), layout="constrained")
    chosen = np.arange(2, len(WAVELENGTH_NM), _BAKED_EVERY)[: 3 * (len(WAVELENGTH_NM) // (3 * _BAKED_EVERY))]
    points = baked(_BAKED_THICKNESS, chosen)
    views = spherical(np.radians(VIEWS_DEG), 0.0)
    for axis, view, own in zip(axes, range(len(VIEWS_DEG)), points):
        for thickness in THICKNESS:
            (line,) = axis.plot(
                WAVELENGTH_NM, make_model("adding", spectral(thickness), **ALBEDO_OPTIONS).albedo(views)[view], label=f"thickness {thickness:g}"
            )
            if thickness == _BAKED_THICKNESS:
                axis.plot(WAVELENGTH_NM[chosen], own, "o", color=line.get_color(), fillstyle="none", label="baked, three wavelengths each")
        axis.set(
            title=f"copper under amber, seen at {VIEWS_DEG[view]:g} degrees", xlabel="wavelength in nm", ylabel="albedo", ylim=(0.0, 1.0), xlim=(370.0, 790.0)
        )
    axes[0].legend(loc="upper left", fontsize="small")
    _swatches(axes[2])
    save_picture(figure, folder / "spectral.png", report)


def _swatches(axis) -> None:
    """The colors at the normal: a row for each thickness."""
    picture = np.stack([srgb_encoded(np.clip(colors(thickness)[:, 0], 0.0, 1.0)) for thickness in THICKNESS])
    axis.imshow(picture, aspect="auto")
    axis.set_xticks(range(3), ("spectral", "tint\nin RGB", "tint_\nspectrum"))
    axis.set_yticks(range(len(THICKNESS)), [f"thickness {t:g}" for t in THICKNESS])
    axis.set_title("its color along the normal")
