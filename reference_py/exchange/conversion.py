# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as slots of a model that other programs render, and back: places, base color and report together."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import LaminaError
from ..material.stack import Stack
from .matching import ColorMap, color_key, color_map, compared, mean, recolored, rendered_by, solve, truth
from .report import APPROXIMATED, LOST, Loss, Match, Report, shown
from .slots import BASE, MOST_REFLECTANCE, Slots, from_stack, to_stack

# A mean albedo that is further off than this could not be reached.
_REACHED = 5e-4


@dataclass(frozen=True)
class Converted:
    """`owners`: the index of the layer, or -1 for the base, that each slot ("base", "gloss", "coat") is in the stack.

    `values` are the model's parameters by name. `colors` maps base colors of what is converted to those of the result,
    for textures; None unless asked for, or where what is the base has no color or is an opaque layer.
    """

    stack: Stack
    values: dict
    slots: Slots
    owners: dict[str, int]
    report: Report
    colors: ColorMap | None = None


def stack_to_slots(stack: Stack, model: str, name: str, room=frozenset(), textured: bool = False) -> tuple[Slots, dict, Report, ColorMap | None]:
    """Slots that `model` renders as bright as the stack is; owners, report and color map as in Converted."""
    placed = from_stack(stack, name, room)
    original, rendered = truth(stack), rendered_by(model, placed.slots)
    wanted = original()
    color, found = solve(rendered, mean(wanted), placed.slots.color)
    match = compared(wanted, found, _has_film(placed.slots))
    losses = [*placed.losses, *_unmatched("base color", color, match)]
    colors = color_map(original, rendered) if textured and placed.owners[BASE] < 0 and color_key(stack.base) in stack.base else None
    return placed.slots.with_color(color), placed.owners, Report(tuple(losses), match), colors


def slots_to_stack(slots: Slots, model: str, name: str, source: str, losses: list[Loss], textured: bool = False) -> Converted:
    """The stack that is as bright as `model` renders the slots. `values` is left empty."""
    stack, owners = to_stack(slots, name, source, losses)
    rendered, exact = rendered_by(model, slots), truth(stack)
    wanted = rendered(slots.color)
    most = MOST_REFLECTANCE if slots.is_metal else 1.0
    color, found = solve(exact, mean(wanted), stack.base[color_key(stack.base)], most)
    match = compared(wanted, found, _has_film(slots))
    losses = [*losses, *_unmatched("base color", color, match)]
    stack = replace(stack, base=recolored(stack.base, color))
    colors = color_map(rendered, exact, most) if textured else None
    return Converted(stack, {}, slots, owners, Report(tuple(losses), match), colors)


def _has_film(slots: Slots) -> bool:
    surfaces = (slots.features, *(s.features for s in (slots.gloss, slots.coat) if s))
    return any(features.get("film_thickness") for features in surfaces)


def _unmatched(parameter: str, color: np.ndarray, match: Match) -> list[Loss]:
    if np.max(np.abs(match.mean_error)) <= _REACHED:
        return []
    return [
        Loss(parameter, color, APPROXIMATED, f"no color in range is as bright or dark as it should be; the mean albedo is off by {shown(match.mean_error)}")
    ]


def lost_if(losses: list[Loss], parameter: str, value, default, how: str) -> None:
    """Add a loss where a value is not its default."""
    if np.any(np.abs(np.asarray(value, float) - np.asarray(default, float)) > 1e-6):
        losses.append(Loss(parameter, value, LOST, how))


def require_finite(values: dict, name: str) -> None:
    """Raise LaminaError for a value that is no number."""
    for parameter, value in values.items():
        if not np.all(np.isfinite(value)):
            raise LaminaError(f"{name}: {parameter} is {shown(value)}; choose a finite number")
