# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour spaces of files to linear Rec.709: a curve, then a matrix.

A space is CURVE_PRIMARIES, such as srgb_rec709 or lin_ap1, as MaterialX 1.39 and the Color Interop Forum name them; the
older names and those of the common OpenColorIO configurations are `ALIASES`. Between whites lies Bradford's adaptation.
Sources of the numbers: ITU-R BT.709-6 and BT.2020-2, SMPTE EG 432-1 (P3 with D65), Adobe RGB (1998) version 2005-05,
SMPTE ST 2065-1 (AP0), ACES S-2014-004 (AP1), IEC 61966-2-1 (the sRGB curve), Lam 1985 (Bradford).
"""

from functools import cache

import numpy as np

_D65, _ACES_WHITE = (0.3127, 0.3290), (0.32168, 0.33767)
# x, y of red, green, blue and white
_CHROMATICITIES = {
    "rec709": ((0.640, 0.330), (0.300, 0.600), (0.150, 0.060), _D65),
    "rec2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), _D65),
    "p3d65": ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060), _D65),
    "adobergb": ((0.640, 0.330), (0.210, 0.710), (0.150, 0.060), _D65),
    "ap0": ((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), _ACES_WHITE),
    "ap1": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), _ACES_WHITE),
}
_GAMMAS = {"lin": 1.0, "g18": 1.8, "g22": 2.2, "g24": 2.4, "adobe": 563.0 / 256.0}
_SRGB = "srgb"
ALIASES = {
    "srgb_texture": "srgb_rec709", "srgb_tx": "srgb_rec709", "srgb": "srgb_rec709", "srgb - texture": "srgb_rec709",
    "srgb encoded rec.709 (srgb)": "srgb_rec709", "utility - srgb - texture": "srgb_rec709", "srgb_displayp3": "srgb_p3d65", "lin_displayp3": "lin_p3d65",
    "rec709_display": "g24_rec709", "gamma18": "g18_rec709", "gamma22": "g22_rec709", "gamma24": "g24_rec709",
    "adobergb": "adobe_adobergb", "g22_adobergb": "adobe_adobergb", "acescg": "lin_ap1", "aces - acescg": "lin_ap1", "aces2065-1": "lin_ap0",
    "lin_srgb": "lin_rec709", "linear": "lin_rec709", "lin_rec709_srgb": "lin_rec709", "linear rec.709": "lin_rec709",
    "linear rec.709 (srgb)": "lin_rec709", "utility - linear - srgb": "lin_rec709", "utility - linear - rec.709": "lin_rec709",
    "utility - linear - rec.2020": "lin_rec2020", "linear rec.2020": "lin_rec2020", "linear p3-d65": "lin_p3d65", "aces2065_1": "lin_ap0",
}  # fmt: skip
RAW = frozenset({"", "none", "raw", "data", "non-color", "utility - raw", "unknown"})
"""Names that say that numbers are no colors, or not of which space: they stay as they are."""
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
# How the Color Interop Forum ends names of scene-referred spaces; those of displays have the same curves here.
_ENDINGS = ("_scene", "_display", "_tx")


def known_spaces() -> tuple[str, ...]:
    """The names to choose from: what is most used first."""
    return ("lin_rec709", "srgb_texture", "acescg", "g22_rec709", "g18_rec709", "rec709_display", "lin_rec2020", "lin_p3d65", "adobergb", "g22_ap1", "lin_ap0")


def canonical(name: str) -> str:
    """CURVE_PRIMARIES of a space that `is_known`; empty for one whose numbers stay as they are."""
    return "" if name.strip().lower() in RAW else "_".join(_parts(name))


def is_known(name: str) -> bool:
    """Whether `to_linear_rec709` has the space."""
    return name.strip().lower() in RAW or _parts(name) is not None


def to_linear_rec709(color: np.ndarray, name: str) -> np.ndarray:
    """Linear Rec.709 (..., 3) of colors (..., 3) of a space that `is_known`. Not limited: negative where outside the gamut.

    Curves are odd functions, so that negative values keep their sign.
    """
    color = np.asarray(color, float)
    if name.strip().lower() in RAW:
        return color
    curve, primaries = _parts(name)
    linear = np.sign(color) * _decoded(np.abs(color), curve)
    return linear if primaries == "rec709" else linear @ _matrix(primaries).T


def srgb_encoded(linear: np.ndarray) -> np.ndarray:
    """The sRGB curve of linear values (...) from 0 up."""
    linear = np.asarray(linear, float)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)


def _parts(name: str) -> tuple[str, str] | None:
    """Curve and primaries of a name; None for an unknown one."""
    key = name.strip().lower()
    for _ in range(2):
        curve, _, primaries = ALIASES.get(key, key).partition("_")
        if (curve in _GAMMAS or curve == _SRGB) and primaries in _CHROMATICITIES:
            return curve, primaries
        key = next((key.removesuffix(ending) for ending in _ENDINGS if key.endswith(ending)), key)
    return None


def _decoded(values: np.ndarray, curve: str) -> np.ndarray:
    if curve == _SRGB:
        return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return values ** _GAMMAS[curve]


@cache
def _matrix(primaries: str) -> np.ndarray:
    """(3, 3) from linear RGB of these primaries to linear Rec.709."""
    source, target = _CHROMATICITIES[primaries], _CHROMATICITIES["rec709"]
    return np.linalg.inv(_to_xyz(target)) @ adaptation(_xyz(source[3]), _xyz(target[3])) @ _to_xyz(source)


def adaptation(white: np.ndarray, new_white: np.ndarray) -> np.ndarray:
    """(3, 3) from XYZ under one white to XYZ under another, each (3,), by Bradford's cones (Lam 1985)."""
    return np.linalg.inv(_BRADFORD) @ np.diag((_BRADFORD @ new_white) / (_BRADFORD @ white)) @ _BRADFORD


def _to_xyz(chromaticities) -> np.ndarray:
    columns = np.array([_xyz(c) for c in chromaticities[:3]]).T
    return columns * np.linalg.solve(columns, _xyz(chromaticities[3]))


def _xyz(xy) -> np.ndarray:
    x, y = xy
    return np.array([x / y, 1.0, (1.0 - x - y) / y])
