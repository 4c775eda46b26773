# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack and what a model says of it in one picture, and as it shows itself in a notebook."""

from collections.abc import Sequence

from ..errors import LaminaError
from ..material.stack import Stack
from ..models.model import Model
from ..registry import make_model
from . import curves, side_view, svg

# The model of notebooks: the truth at the resolution of fits, as a cell waits for it.
_QUICK = ("adding", {"draft": 1})


def picture(stack: Stack, model: Model, views_deg: Sequence[float] = curves.VIEWS_DEG) -> str:
    """SVG: the layers, albedo by angle, f in the plane of incidence, and lobes."""
    values = curves.plane(model, views_deg)
    height = max(curves.HEIGHT, side_view.height_of(stack))
    parts = [
        svg.moved(0.0, 0.0, side_view.drawing(stack)),
        svg.moved(side_view.WIDTH, 0.0, curves.albedo(model)),
        svg.moved(0.0, height, curves.lobes(values, views_deg)),
        svg.moved(side_view.WIDTH, height, curves.polar(values, views_deg)),
    ]
    return svg.document(side_view.WIDTH + curves.WIDTH, height + curves.HEIGHT, parts)


def notebook(stack: Stack) -> str:
    """SVG for a notebook's cell: the layers, and lobes of the truth; of a stack that `adding` refuses, why there are none."""
    height = max(curves.HEIGHT, side_view.height_of(stack))
    parts = [svg.moved(0.0, 0.0, side_view.drawing(stack))]
    try:
        model = make_model(_QUICK[0], stack, **_QUICK[1])
    except LaminaError as error:
        return svg.document(side_view.WIDTH + curves.WIDTH, height + 20.0, [*parts, svg.text(4.0, height + 10.0, f"no lobes: {error}")])
    return svg.document(side_view.WIDTH + curves.WIDTH, height, [*parts, svg.moved(side_view.WIDTH, 0.0, curves.polar(curves.plane(model)))])
