# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of MaterialX that compute numbers of numbers, by their definitions in its standard library (1.38 and 1.39).

The one exception is `UsdTransform2d`: its scale multiplies uv, as USD has it. Each takes `inputs(name, default)`, which gives an
input's numbers, and gives as many as it has.
"""

import colorsys
from collections.abc import Callable

import numpy as np

from ..optics.colour import artist_index

ZERO, ONE = np.zeros(1), np.ones(1)
# Of ACEScg, as the library has it for every space.
_LUMINANCE = np.array([0.2722287, 0.6740818, 0.0536895])


def _mix(inputs) -> np.ndarray:
    bg, fg, share = inputs("bg", ZERO), inputs("fg", ZERO), inputs("mix", ZERO)
    return bg + share * (fg - bg)


def _divided(inputs) -> np.ndarray:
    below = inputs("in2", ONE)
    return inputs("in1", ZERO) / np.where(below == 0.0, 1.0, below)


def _extract(inputs) -> np.ndarray:
    values, index = inputs("in", ZERO), int(inputs("index", ZERO)[0])
    return values[min(max(index, 0), len(values) - 1)][None]


def _widths(roughness: np.ndarray, inputs) -> np.ndarray:
    """alpha along and across, their product roughness^4."""
    alpha, aspect = roughness[0] ** 2, (1.0 - min(max(float(inputs("anisotropy", ZERO)[0]), 0.0), 0.98)) ** 0.5
    return np.array([min(alpha / aspect, 1.0), alpha * aspect])


def _open_widths(inputs) -> np.ndarray:
    """alpha along and across, the mean of their squares roughness^4."""
    ratio = 1.0 - inputs("anisotropy", ZERO)[0]
    along = inputs("roughness", ZERO)[0] ** 2 * (2.0 / (1.0 + ratio**2)) ** 0.5
    return np.array([along, ratio * along])


def _dual(inputs) -> np.ndarray:
    both = inputs("roughness", np.zeros(2))[:2]
    return np.square(np.where(both < 0.0, both[0], both))


def _artistic(inputs) -> np.ndarray:
    """Index and extinction, one after the other."""
    reflectance = np.clip(inputs("reflectivity", np.array([0.944, 0.776, 0.373])), 0.0, 0.999)
    return np.concatenate(artist_index(reflectance, np.clip(inputs("edge_color", np.array([0.998, 0.981, 0.751])), 0.0, 1.0)))


def _if(holds: Callable, first: np.ndarray = ONE) -> Callable:
    """The first of two where two values are so, else the second; `first` where the file has no value1."""
    return lambda i: i("in1", ZERO) if holds(i("value1", first)[0], i("value2", ZERO)[0]) else i("in2", ZERO)


def _remapped(inputs, clamped: bool) -> np.ndarray:
    """A range to another one; of `range` also a gamma in between, and clamped where it says so."""
    low, high, out_low, out_high = inputs("inlow", ZERO), inputs("inhigh", ONE), inputs("outlow", ZERO), inputs("outhigh", ONE)
    share = (inputs("in", ZERO) - low) / np.where(high == low, 1.0, high - low)
    if clamped and np.any((gamma := inputs("gamma", ONE)) != 1.0):
        share = np.sign(share) * np.abs(share) ** (1.0 / np.where(gamma == 0.0, 1.0, gamma))
    result = out_low + share * (out_high - out_low)
    return np.clip(result, out_low, out_high) if clamped and inputs("doclamp", ZERO)[0] else result


def _contrast(inputs) -> np.ndarray:
    pivot = inputs("pivot", np.full(1, 0.5))
    return (inputs("in", ZERO) - pivot) * inputs("amount", ONE) + pivot


def _smooth(inputs) -> np.ndarray:
    low, high = inputs("low", ZERO), inputs("high", ONE)
    share = np.clip((inputs("in", ZERO) - low) / np.where(high == low, 1.0, high - low), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _grey(inputs, color: np.ndarray | None = None) -> np.ndarray:
    color = inputs("in", np.zeros(3)) if color is None else color
    return np.full(3, inputs("lumacoeffs", _LUMINANCE)[:3] @ np.broadcast_to(color[:3], 3))


def _saturated(inputs) -> np.ndarray:
    color = inputs("in", np.zeros(3))[:3]
    return _grey(inputs, color) + inputs("amount", ONE) * (color - _grey(inputs, color))


def _hsv_adjusted(inputs) -> np.ndarray:
    hue, saturation, value = colorsys.rgb_to_hsv(*inputs("in", np.zeros(3))[:3])
    turn, more, brighter = np.broadcast_to(inputs("amount", np.array([0.0, 1.0, 1.0])), 3)
    return np.array(colorsys.hsv_to_rgb((hue + turn) % 1.0, saturation * more, value * brighter))


def _corrected(inputs) -> np.ndarray:
    """colorcorrect: its steps in their order."""
    color = inputs("in", np.zeros(3))[:3]
    if (hue := inputs("hue", ZERO)[0]) != 0.0:
        color = _hsv_adjusted({"amount": np.array([hue, 1.0, 1.0]), "in": color}.get)
    color = _grey(inputs, color) + inputs("saturation", ONE) * (color - _grey(inputs, color))
    if np.any((gamma := inputs("gamma", ONE)) != 1.0):
        color = np.sign(color) * np.abs(color) ** (1.0 / np.where(gamma == 0.0, 1.0, gamma))
    color = color * (1.0 - inputs("lift", ZERO)) + inputs("lift", ZERO)
    color = color * inputs("gain", ONE)
    pivot = inputs("contrastpivot", np.full(1, 0.5))
    color = (color - pivot) * inputs("contrast", ONE) + pivot
    return color * 2.0 ** inputs("exposure", ZERO)


def _switched(inputs) -> np.ndarray:
    which = int(np.floor(inputs("which", ZERO)[0]))
    return inputs(f"in{min(max(which, 0), 9) + 1}", ZERO)


def _turned(uv: np.ndarray, degrees: float) -> np.ndarray:
    """Clockwise, as MaterialX turns."""
    s, c = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    return np.array([c * uv[0] + s * uv[1], -s * uv[0] + c * uv[1]])


def placed(uv: np.ndarray, pivot, scale, degrees: float, shift, is_shifted_first: bool) -> np.ndarray:
    """uv (2,) as `place2d` has it."""
    uv, scale = uv - pivot, np.where(np.asarray(scale) == 0.0, 1.0, scale)
    return (_turned(uv - shift, degrees) / scale if is_shifted_first else _turned(uv / scale, degrees) - shift) + pivot


def _place2d(inputs) -> np.ndarray:
    scale, shift, order = inputs("scale", np.ones(2)), inputs("offset", np.zeros(2)), inputs("operationorder", ZERO)[0]
    return placed(inputs("texcoord", np.zeros(2)), inputs("pivot", np.zeros(2)), scale, float(inputs("rotate", ZERO)[0]), shift, order >= 1)


def _usd_transform(inputs) -> np.ndarray:
    return _turned(inputs("in", np.zeros(2)) * inputs("scale", np.ones(2)), -float(inputs("rotation", ZERO)[0])) + inputs("translation", np.zeros(2))


FUNCTIONS: dict[str, Callable] = {
    "add": lambda i: i("in1", ZERO) + i("in2", ZERO), "subtract": lambda i: i("in1", ZERO) - i("in2", ZERO),
    "multiply": lambda i: i("in1", ZERO) * i("in2", ONE), "divide": _divided, "mix": _mix,
    "power": lambda i: np.maximum(i("in1", ZERO), 0.0) ** i("in2", ONE),
    "safepower": lambda i: np.sign(i("in1", ZERO)) * np.abs(i("in1", ZERO)) ** i("in2", ONE),
    "min": lambda i: np.minimum(i("in1", ZERO), i("in2", ZERO)), "max": lambda i: np.maximum(i("in1", ZERO), i("in2", ZERO)),
    "clamp": lambda i: np.clip(i("in", ZERO), i("low", ZERO), i("high", ONE)), "invert": lambda i: i("amount", ONE) - i("in", ZERO),
    "sqrt": lambda i: np.sqrt(np.maximum(i("in", ZERO), 0.0)), "absval": lambda i: np.abs(i("in", ZERO)), "extract": _extract,
    "combine2": lambda i: np.concatenate([i(f"in{n}", ZERO)[:1] for n in (1, 2)]),
    "combine3": lambda i: np.concatenate([i(f"in{n}", ZERO)[:1] for n in (1, 2, 3)]),
    "combine4": lambda i: np.concatenate([i(f"in{n}", ZERO)[:1] for n in (1, 2, 3, 4)]),
    "ifgreater": _if(lambda a, b: a > b), "ifgreatereq": _if(lambda a, b: a >= b), "ifequal": _if(lambda a, b: a == b, ZERO),
    "sign": lambda i: np.sign(i("in", ZERO)), "floor": lambda i: np.floor(i("in", ZERO)), "ceil": lambda i: np.ceil(i("in", ZERO)),
    "round": lambda i: np.round(i("in", ZERO)), "fract": lambda i: i("in", ZERO) % 1.0, "exp": lambda i: np.exp(np.minimum(i("in", ZERO), 80.0)),
    "roughness_anisotropy": lambda i: _widths(i("roughness", ZERO), i), "glossiness_anisotropy": lambda i: _widths(1.0 - i("glossiness", ONE), i),
    "open_pbr_anisotropy": _open_widths, "roughness_dual": _dual, "artistic_ior": _artistic, "luminance": _grey,
    "remap": lambda i: _remapped(i, False), "range": lambda i: _remapped(i, True), "contrast": _contrast, "smoothstep": _smooth,
    "saturate": _saturated, "hsvadjust": _hsv_adjusted, "colorcorrect": _corrected, "switch": _switched,
    "hsvtorgb": lambda i: np.array(colorsys.hsv_to_rgb(*i("in", np.zeros(3))[:3])),
    "rgbtohsv": lambda i: np.array(colorsys.rgb_to_hsv(*i("in", np.zeros(3))[:3])),
    "place2d": _place2d, "rotate2d": lambda i: _turned(i("in", np.zeros(2)), float(i("amount", ZERO)[0])), "UsdTransform2d": _usd_transform,
    "screen": lambda i: _blend(i, lambda fg, bg: 1.0 - (1.0 - fg) * (1.0 - bg)), "plus": lambda i: _blend(i, lambda fg, bg: fg + bg),
    "minus": lambda i: _blend(i, lambda fg, bg: bg - fg), "difference": lambda i: _blend(i, lambda fg, bg: np.abs(bg - fg)),
    "inside": lambda i: i("in", ZERO) * i("mask", ONE), "outside": lambda i: i("in", ZERO) * (1.0 - i("mask", ZERO)),
}  # fmt: skip


def _blend(inputs, blended: Callable) -> np.ndarray:
    fg, bg, share = inputs("fg", ZERO), inputs("bg", ZERO), inputs("mix", ONE)
    return bg + share * (blended(fg, bg) - bg)


# Outputs of nodes that have several, whose numbers come one after the other.
OUTPUTS = {"artistic_ior": ("ior", "extinction")}
