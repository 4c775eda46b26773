# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack from the side: a band for each layer, in the color that its medium leaves, its upper edge as rough as it is."""

import numpy as np

from ..material.schema import COVERAGE, DIELECTRIC, SCATTERING
from ..material.stack import Base, Layer, Stack
from ..optics.bases import conductor_index
from ..optics.colour import srgb_encoded
from ..optics.fresnel import fresnel_conductor
from . import svg

WIDTH = 340.0
_BAND, _LEFT, _HEAD = 34.0, 120.0, 24.0


def height_of(stack: Stack) -> float:
    """Pixels that `drawing` takes."""
    return _HEAD + _BAND * (len(stack.layers) + 1) + 6.0


def drawing(stack: Stack) -> list[str]:
    """The parts of the picture, `WIDTH` wide; layers from the top, the base last."""
    parts = [svg.text(4.0, 15.0, svg.fitted(stack.name or "a stack without a name", WIDTH))]
    for i, element in enumerate((*stack.layers, stack.base)):
        y = _HEAD + i * _BAND
        parts.append(svg.rect(4.0, y, _LEFT - 12.0, _BAND, hex_color(shown_color(element))))
        if "roughness" in element:
            parts.append(svg.line(_edge(y, element["roughness"]), svg.INK, 1.2))
        parts.append(svg.text(_LEFT, y + 0.5 * _BAND, svg.fitted(_kind(element), WIDTH - _LEFT)))
        parts.append(svg.text(_LEFT, y + 0.5 * _BAND + 12.0, svg.fitted(_values(element), WIDTH - _LEFT), color="#777"))
    return parts


def shown_color(element: Layer | Base) -> np.ndarray:
    """Linear RGB (3,) of what a layer's medium leaves of light that crosses it, or of what is opaque reflects in air."""
    if "tint" in element:
        return _three(np.power(element["tint"], element["thickness"]))
    if "color" in element:
        return _three(element["color"])
    return _three(fresnel_conductor(np.ones(1), *conductor_index(element)))


def hex_color(linear: np.ndarray) -> str:
    """#rrggbb of linear RGB (3,)."""
    return "#" + "".join(f"{round(255.0 * v):02x}" for v in srgb_encoded(np.clip(linear, 0.0, 1.0)))


def _three(values) -> np.ndarray:
    """Three channels of any number: the mean of spectra."""
    values = np.asarray(values, float)
    return values if len(values) == 3 else np.full(3, values.mean())


def _edge(y: float, roughness: float) -> np.ndarray:
    x = np.linspace(4.0, _LEFT - 8.0, 45)
    zigzag = np.where(np.arange(45) % 2, 1.0, -1.0) * np.sin(np.arange(45) * 12.9898)
    return np.stack([x, y + 7.0 * roughness * zigzag], axis=-1)


def _kind(element: Layer | Base) -> str:
    name = element.unknown.get("name")
    clear = "cloudy layer" if element.has(SCATTERING) else "clear layer"
    kind = clear if element.kind == DIELECTRIC.name else element.kind.replace("_", "-")
    covered = f", on {element['coverage']:.0%}" if element.has(COVERAGE) else ""
    return (f"{name}: {kind}" if isinstance(name, str) else kind) + covered


def _values(element: Layer | Base) -> str:
    shown = {name: element[name] for name in ("metal", "ior", "roughness", "thickness", "sigma_deg", "density") if name in element}
    return ", ".join(f"{name} {value:.3g}" if isinstance(value, float) else str(value) for name, value in shown.items())
