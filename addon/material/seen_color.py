# SPDX-License-Identifier: GPL-3.0-or-later
"""The color that a clear layer gives to what is below it, as a property of the node of its values: read from tint and thickness, written to the tint.

White light goes in and out along the normal, so it crosses the layer twice: tint ** (2 thickness), after Beer, Lambert and Bouguer.
"""

import bpy
from bpy.props import FloatVectorProperty

from ..blender.translation import CONTEXT
from ..shader import working_space
from . import elements, live_values

NAME = "lamina_seen"
_TINT, _THICKNESS = "Tint", "Thickness"


def has_seen_color(element) -> bool:
    """Whether a layer has a tint and a thickness."""
    return {"tint", "thickness"} <= {p.name for p in elements.kind_of(element).sockets}


def is_settable(element) -> bool:
    """Whether a tint gives every color as seen: nothing else gives tint or thickness, and there is a thickness."""
    node = elements.find_node(element)
    return node is not None and not {"tint", "thickness"} & set(live_values.what_moves(element)) and node.inputs[_THICKNESS].default_value > 0.0


def _seen(node) -> tuple[float, ...]:
    tint, thickness = node.inputs.get(_TINT), node.inputs.get(_THICKNESS)
    if tint is None or thickness is None:
        return (1.0, 1.0, 1.0)
    return _raised(tint.default_value, 2.0 * max(thickness.default_value, 0.0))


def _see(node, value) -> None:
    thickness = node.inputs[_THICKNESS].default_value
    if thickness > 0.0:
        node.inputs[_TINT].default_value = (*_raised(value, 0.5 / thickness), 1.0)


def _raised(color, exponent: float) -> tuple[float, ...]:
    """A power of a color of the working space, taken in the model's."""
    inside = [min(max(c, 0.0), 1.0) ** exponent for c in working_space.out_of_working(color[:3])]
    return tuple(working_space.into_working(inside))


def register() -> None:
    bpy.types.ShaderNodeGroup.lamina_seen = FloatVectorProperty(
        name="Color as Seen",
        description="What the layer leaves of white light that goes in and comes out again; setting it sets the tint",
        subtype="COLOR",
        size=3,
        min=0.0,
        max=1.0,
        get=_seen,
        set=_see,
        translation_context=CONTEXT,
        options=set(),
    )


def unregister() -> None:
    del bpy.types.ShaderNodeGroup.lamina_seen
