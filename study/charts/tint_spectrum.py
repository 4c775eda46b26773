# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart tint_spectrum`: how far three channels are from the spectrum of a glaze, with its tint in RGB and as a `tint_spectrum`."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ...reference_py.optics.colour import reflectance_to_rgb, rgb_weights
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.spectral import gaussian_band, spectral_stack
from ...reference_py.registry import make_model
from ..tables import Report, write_table
from .output import print_table

WAVELENGTH_NM = np.arange(380.0, 781.0, 10.0)
THICKNESS = (1.0, 2.0, 5.0)
VIEWS_DEG = (0.0, 45.0, 75.0)
# Optical depths of unit thickness: two published laws (Bricaud, Morel and Prieur 1981; Jacques 1998), and a narrow band of ours.
DEPTHS = {
    "amber": 0.2 * np.exp(-0.014 * (WAVELENGTH_NM - 440.0)),
    "melanin": 0.1 * (WAVELENGTH_NM / 500.0) ** -3.33,
    "narrow yellow": gaussian_band(WAVELENGTH_NM, 440.0, 40.0, 0.3),
}
BASES = {
    "white": {"kind": "lambert", "color": [1.0, 1.0, 1.0]},
    "grey": {"kind": "lambert", "color": [0.5, 0.5, 0.5]},
    "silver": {"kind": "conductor", "metal": "silver", "roughness": 0.3},
}
_HEADING = (
    "lamina chart tint_spectrum",
    "albedo of a smooth glaze of index 1.5 against adding at 41 wavelengths: largest relative error of views 0 45 75 degrees; "
    "outside: how far the truth leaves 0 to 1 in red or blue, as colors outside Rec.709 do",
)
COLUMNS = ("glaze", "base", "thickness", *(f"{how}_{channel}" for how in ("rgb", "spectrum") for channel in ("red", "green", "blue")), "outside")
ALBEDO_OPTIONS = {"nodes": 16}


def chart(folder: Path, report: Report) -> None:
    """Write tint_spectrum.csv and print it."""
    table = folder / "tint_spectrum.csv"
    require_writable(table)
    measured = list(rows(report))
    print_table(COLUMNS, measured)
    write_table(table, _HEADING, COLUMNS, measured, report)


def rows(report: Report) -> Iterator[list[str]]:
    """One row for each glaze, base and thickness."""
    for glaze, depth in DEPTHS.items():
        report(glaze)
        for base in BASES:
            for thickness in THICKNESS:
                errors, outside = compare(np.exp(-depth), base, thickness)
                yield [glaze, base, f"{thickness:g}", *(f"{v:.4f}" for v in errors.ravel()), f"{outside:.3f}"]


def compare(transmittance: np.ndarray, base: str, thickness: float) -> tuple[np.ndarray, float]:
    """Largest error (2, 3) by channel of a tint in RGB and of a spectrum, relative; and how far the truth is outside of 0 to 1."""
    views = spherical(np.radians(VIEWS_DEG), 0.0)
    given = {"wavelengths_nm": WAVELENGTH_NM.tolist(), "transmittance": transmittance.tolist()}
    in_rgb = np.clip(reflectance_to_rgb(transmittance, WAVELENGTH_NM), 0.0, 1.0).tolist()
    rgb, spectral = (
        Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0, "thickness": thickness, **tint}], "base": BASES[base]})
        for tint in ({"tint": in_rgb}, {"tint_spectrum": given})
    )
    truth = make_model("adding", spectral_stack(spectral, WAVELENGTH_NM), **ALBEDO_OPTIONS).albedo(views) @ rgb_weights(WAVELENGTH_NM)
    errors = [np.abs(make_model("adding", s, **ALBEDO_OPTIONS).albedo(views) - truth) / np.abs(truth) for s in (rgb, spectral)]
    return np.max(errors, axis=1), float(max(np.max(truth) - 1.0, -np.min(truth), 0.0))
