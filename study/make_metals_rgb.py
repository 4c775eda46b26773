# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes data/metals_rgb.json: `python -m lamina.study.make_metals_rgb`.

Per metal and channel, the complex index whose Fresnel curve is nearest to the linear Rec.709 integral of the
spectral Fresnel reflectance: least squares over 0 to 85 degrees in steps of 1, weighted by cos(theta) sin(theta).
Integrating the index itself would not do: reflectance is not linear in it.
"""

import json

import numpy as np

from ..reference_py.atomic import write_text
from ..reference_py.optics.colour.artist import artist_index
from ..reference_py.optics.colour.metals import RGB_FILE, metal_index, metal_names
from ..reference_py.optics.colour.spectrum import reflectance_to_rgb, standard_wavelengths
from ..reference_py.optics.fresnel import fresnel_conductor

THETA = np.radians(np.arange(86.0))
COS_THETA = np.cos(THETA)
WEIGHT = COS_THETA * np.sin(THETA)

# A channel of 1 has no finite index; .995 leaves gold's red, the one channel concerned, an index like silver's.
LARGEST_REFLECTANCE = 0.995

ABOUT = (
    "Complex index per linear Rec.709 channel (CIE 1931 2-degree observer, D65), relative to air. f0: integral of the "
    "spectral reflectance at normal incidence. The fit is to the integral limited to 0 ... 0.995; clipped: the largest "
    "amount cut off by that (a colour outside Rec.709). max_error, rms_error: difference of the Fresnel curve of "
    "(eta, k) from the limited integral, the worst channel; largest over 0 to 85 degrees, and root mean square "
    "weighted by cos(theta) sin(theta). Written by lamina.study.make_metals_rgb."
)


def rgb_reflectance(name: str, cos_theta: np.ndarray) -> np.ndarray:
    """Linear Rec.709 reflectance (..., 3) in air of a metal at cosines (...,): the spectral integral, not clipped."""
    wavelength_nm = standard_wavelengths()
    n, k = metal_index(name, wavelength_nm)
    return reflectance_to_rgb(fresnel_conductor(np.asarray(cos_theta)[..., None], n, k), wavelength_nm)


def fit_index(target: np.ndarray) -> tuple[float, float]:
    """(eta, k) whose reflectance at COS_THETA is nearest to target (86,), by Levenberg-Marquardt.

    The unknowns are the logarithms, so both stay positive. Marquardt 1963, J. SIAM 11(2), 431-441.
    """
    root_weight = np.sqrt(WEIGHT)

    def residual(log_index: np.ndarray) -> np.ndarray:
        return root_weight * (fresnel_conductor(COS_THETA, *np.exp(log_index)) - target)

    # start from the index of the right reflectance at normal incidence and a middling edge tint
    x = np.log(artist_index(np.clip(target[0], 0.01, 0.998), 0.8))
    error, damping, step = residual(x), 1e-3, 1e-6
    for _ in range(300):
        jacobian = np.array([residual(x + h) - residual(x - h) for h in step * np.eye(2)]).T / (2.0 * step)
        normal = jacobian.T @ jacobian
        change = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -jacobian.T @ error)
        trial = residual(x + change)
        if trial @ trial < error @ error:
            x, error, damping = x + change, trial, damping * 0.3
            if np.max(np.abs(change)) < 1e-9:
                break
        else:
            damping *= 4.0
            if damping > 1e12:
                break
    eta, k = np.exp(x)
    return float(eta), float(k)


def rgb_entry(name: str) -> dict:
    """The entry of one metal in data/metals_rgb.json."""
    integral = rgb_reflectance(name, COS_THETA)
    target = np.clip(integral, 0.0, LARGEST_REFLECTANCE)
    # six decimals: far below the error of the measurements; the last may change with the numpy version
    eta, k = np.round([fit_index(channel) for channel in target.T], 6).T
    error = fresnel_conductor(COS_THETA[:, None], eta, k) - target
    rms = np.sqrt(np.average(np.square(error), axis=0, weights=WEIGHT))
    return {
        "eta": eta.tolist(),
        "k": k.tolist(),
        "f0": np.round(integral[0], 6).tolist(),
        "clipped": round(float(np.max(np.abs(target - integral))), 6),
        "max_error": round(float(np.max(np.abs(error))), 6),
        "rms_error": round(float(np.max(rms)), 6),
    }


def main() -> None:
    """Fit every metal and write the table."""
    entries = ",\n".join(f'    "{name}": {json.dumps(rgb_entry(name))}' for name in metal_names())
    write_text(RGB_FILE, f'{{\n  "about": {json.dumps(ABOUT)},\n  "metals": {{\n{entries}\n  }}\n}}\n')


if __name__ == "__main__":
    main()
