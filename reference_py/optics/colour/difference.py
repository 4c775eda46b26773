# SPDX-License-Identifier: GPL-3.0-or-later
"""How different two colours look: CIEDE2000 (CIE 142-2001; formulas as in Sharma, Wu and Dalal 2005)."""

import numpy as np

from .spectrum import xyz_to_rgb

_K = 25.0**7


def lab_of_linear(rgb: np.ndarray) -> np.ndarray:
    """CIE 1976 L*a*b* (..., 3) of linear Rec.709 (..., 3), its white as white."""
    to_xyz = np.linalg.inv(xyz_to_rgb(np.eye(3)))
    t = (np.asarray(rgb, float) @ to_xyz) / (np.ones(3) @ to_xyz)
    f = np.where(t > (6.0 / 29.0) ** 3, np.cbrt(t), t * (29.0 / 6.0) ** 2 / 3.0 + 4.0 / 29.0)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def ciede2000(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """CIEDE2000 (...) of two L*a*b* (..., 3)."""
    (l1, a1, b1), (l2, a2, b2) = (np.moveaxis(np.asarray(lab, float), -1, 0) for lab in (first, second))
    mean_c7 = (0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))) ** 7
    stretch = 1.5 - 0.5 * np.sqrt(mean_c7 / (mean_c7 + _K))
    c1, c2 = np.hypot(a1 * stretch, b1), np.hypot(a2 * stretch, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1 * stretch)) % 360.0, np.degrees(np.arctan2(b2, a2 * stretch)) % 360.0
    grey = c1 * c2 == 0.0
    turn = np.where(grey, 0.0, (h2 - h1 + 180.0) % 360.0 - 180.0)
    # opposite hues: the formulas' own choice of the half turn
    turn = np.where(~grey & (h2 - h1 == 180.0), 180.0, turn)
    mean_h = np.where(grey, h1 + h2, np.where(np.abs(h1 - h2) <= 180.0, 0.5 * (h1 + h2), 0.5 * (h1 + h2 + np.where(h1 + h2 < 360.0, 360.0, -360.0))))
    mean_l, mean_c = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    d_h = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(0.5 * turn))
    t = (
        1.0
        - 0.17 * np.cos(np.radians(mean_h - 30.0))
        + 0.24 * np.cos(np.radians(2.0 * mean_h))
        + 0.32 * np.cos(np.radians(3.0 * mean_h + 6.0))
        - 0.20 * np.cos(np.radians(4.0 * mean_h - 63.0))
    )
    s_l = 1.0 + 0.015 * (mean_l - 50.0) ** 2 / np.sqrt(20.0 + (mean_l - 50.0) ** 2)
    s_c, s_h = 1.0 + 0.045 * mean_c, 1.0 + 0.015 * mean_c * t
    rotation = -2.0 * np.sqrt(mean_c**7 / (mean_c**7 + _K)) * np.sin(np.radians(60.0 * np.exp(-(((mean_h - 275.0) / 25.0) ** 2))))
    l_term, c_term, h_term = (l2 - l1) / s_l, (c2 - c1) / s_c, d_h / s_h
    return np.sqrt(np.maximum(l_term**2 + c_term**2 + h_term**2 + rotation * c_term * h_term, 0.0))
