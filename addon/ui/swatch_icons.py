# SPDX-License-Identifier: GPL-3.0-or-later
"""Icons of layers and bases for the panel, drawn once for each look and kept."""

import bpy
import bpy.utils.previews

from ...reference_py.material.schema import COLOR, CONDUCTOR, COVERAGE, SCHEMA
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
    if node is None or _icons is None:
        return 0
    look = _look(element, node)
    name = repr(look)
    if name not in _icons:
        if len(_icons) >= _LIMIT:
            _icons.clear()
        picture = swatch.base_picture(*look[1:]) if look[0] == "base" else swatch.layer_picture(*look[1:])
        icon = _icons.new(name)
        icon.icon_size = (swatch.SIZE, swatch.SIZE)
        icon.icon_pixels_float = picture.ravel()
    return _icons[name].icon_id


def shown_color(element, node: bpy.types.Node) -> tuple[float, float, float]:
    """The color of an element, linear RGB: what a layer's medium leaves of white, what a base reflects straight up."""
    value = {p.name: node.inputs[p.label].default_value for p in elements.kind_of(element).sockets if p.label in node.inputs}
    value |= {p.name: working_space.out_of_working(value[p.name][:3]) for p in elements.kind_of(element).sockets if p.type == COLOR and p.name in value}
    if "tint" in value:
        return tuple(min(max(c, 0.0), 1.0) ** max(value["thickness"], 0.0) for c in value["tint"])
    if element.kind == CONDUCTOR.name and "reflectance" not in element.given:
        return tuple(((n - 1.0) ** 2 + k**2) / ((n + 1.0) ** 2 + k**2) for n, k in zip(value["eta"], value["k"]))
    return tuple(value["reflectance" if element.kind == CONDUCTOR.name else "color"])[:3]


def _look(element, node) -> tuple:
    """What an icon depends on, in steps that an eye would tell apart."""
    color = tuple(round(_STEPS * float(c)) / _STEPS for c in shown_color(element, node))
    roughness = node.inputs.get("Roughness")
    rough = round(_STEPS * roughness.default_value) / _STEPS if roughness is not None else 0.0
    distribution = getattr(element, "distribution", "ggx")
    coverage = round(_STEPS * node.inputs[COVERAGE.parameters[0].label].default_value) / _STEPS if element.use_coverage else 1.0
    if SCHEMA.is_opaque(element.kind):
        return ("base", color, rough, distribution, coverage)
    thickness = round(0.25 * _STEPS * min(node.inputs["Thickness"].default_value, 8.0)) / (0.25 * _STEPS)
    return ("layer", color, thickness, rough, distribution, coverage)


def register() -> None:
    global _icons
    _icons = bpy.utils.previews.new()


def unregister() -> None:
    global _icons
    bpy.utils.previews.remove(_icons)
    _icons = None
