# SPDX-License-Identifier: GPL-3.0-or-later
"""Icons of layers and bases for the panel, drawn once for each look and kept."""

from collections.abc import Mapping

import bpy
import bpy.utils.previews

from ...reference_py.material.schema import COLOR, CONDUCTOR, COVERAGE, SCHEMA
from ...reference_py.material.stack import Layer
from ...reference_py.optics import colour
from ..material import elements
from ..shader import working_space
from . import swatch

# Looks that are kept; then all are drawn anew.
_LIMIT = 400
_STEPS = 64.0

_icons: bpy.utils.previews.ImagePreviewCollection | None = None


def icon_of(element) -> int:
    """The number of an icon that shows a layer or a base from the side; 0 where its node is gone."""
    node = elements.find_node(element)
    if node is None:
        return 0
    values = {p.name: node.inputs[p.label].default_value for p in elements.kind_of(element).sockets if p.label in node.inputs}
    values |= {p.name: working_space.out_of_working(values[p.name][:3]) for p in elements.kind_of(element).sockets if p.type == COLOR and p.name in values}
    if not element.use_coverage:
        values.pop(COVERAGE.name, None)
    return _icon(_look(element.kind, values, element.given, getattr(element, "distribution", "ggx")))


def icon_of_layer(layer: Layer) -> int:
    """The number of an icon that shows a layer of the model."""
    values = {p.name: p.default for p in SCHEMA.layers[layer.kind].parameters} | dict(layer.values)
    if "metal" in layer:
        values |= dict(zip(("eta", "k"), colour.conductor_rgb(layer["metal"])))
    return _icon(_look(layer.kind, values, "reflectance" if "reflectance" in layer else "", values.get("distribution", "ggx")))


def _icon(look: tuple) -> int:
    if _icons is None:
        return 0
    name = repr(look)
    if name not in _icons:
        if len(_icons) >= _LIMIT:
            _icons.clear()
        picture = swatch.base_picture(*look[1:]) if look[0] == "base" else swatch.layer_picture(*look[1:])
        icon = _icons.new(name)
        icon.icon_size = (swatch.SIZE, swatch.SIZE)
        icon.icon_pixels_float = picture.ravel()
    return _icons[name].icon_id


def shown_color(kind: str, values: Mapping, given: str) -> tuple[float, ...]:
    """The color of a layer or base of these values, linear RGB: what a layer's medium leaves of white, what a base reflects straight up."""
    if "tint" in values:
        return tuple(min(max(c, 0.0), 1.0) ** max(values["thickness"], 0.0) for c in values["tint"])
    if kind == CONDUCTOR.name and "reflectance" not in given:
        return tuple(((n - 1.0) ** 2 + k**2) / ((n + 1.0) ** 2 + k**2) for n, k in zip(values["eta"], values["k"]))
    return tuple(values["reflectance" if kind == CONDUCTOR.name else "color"])[:3]


def _look(kind: str, values: Mapping, given: str, distribution: str) -> tuple:
    """What an icon depends on, in steps that an eye would tell apart."""
    color = tuple(round(_STEPS * float(c)) / _STEPS for c in shown_color(kind, values, given))
    rough = round(_STEPS * values.get("roughness", 0.0)) / _STEPS
    coverage = round(_STEPS * values.get(COVERAGE.name, 1.0)) / _STEPS
    if SCHEMA.is_opaque(kind):
        return ("base", color, rough, distribution, coverage)
    thickness = round(0.25 * _STEPS * min(values["thickness"], 8.0)) / (0.25 * _STEPS)
    return ("layer", color, thickness, rough, distribution, coverage)


def register() -> None:
    global _icons
    _icons = bpy.utils.previews.new()


def unregister() -> None:
    global _icons
    bpy.utils.previews.remove(_icons)
    _icons = None
