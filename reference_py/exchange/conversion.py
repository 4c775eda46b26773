# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as slots of a model that other programs render, and back: places, base color and report together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.schema import THIN_FILM
from ..material.stack import Stack
from .appearance import Appearance
from .matching import TOLERANCE, Albedos, ColorMap, color_key, color_map, compared, mean, solve, solve_near, truth, with_color
from .report import APPROXIMATED, LOST, Loss, Report, shown
from .slots import BASE, MOST_REFLECTANCE, Body, Slots, from_stack, to_stack

# A mean albedo that is further off than this could not be reached.
_REACHED = 5e-4
# A mean albedo that is black to every eye.
_SEEN = 2e-3


@dataclass(frozen=True)
class Converted:
    """`owners`: the index of the layer, or -1 for the base, that each slot ("base", "gloss", "coat") is in the stack.

    `values` are the model's parameters by name; `slots` are None of a graph of layers, which needs none. `colors` maps base
    colors of what is converted to those of the result, for textures; None unless asked for, or where what is the base has no
    color or is an opaque layer.
    """

    stack: Stack
    values: dict
    slots: Slots | None
    owners: dict[str, int]
    report: Report
    colors: ColorMap | None = None


def stack_to_slots(
    stack: Stack,
    name: str,
    rendered: Callable[[Slots], Albedos],
    room=frozenset(),
    textured: bool = False,
    filmed: Callable[[Slots], Albedos] | None = None,
) -> tuple[Slots, dict, Report, ColorMap | None]:
    """Slots that a model called `name` renders as bright as the stack is; owners, report and color map as in Converted.

    `rendered` knows no film. A film without a place in the slots goes into the base color; one that has a place is left out on both sides, unless
    `filmed` renders it.
    """
    placed = from_stack(stack, name, room)
    everywhere = frozenset(range(-1, len(stack.layers)))
    original, shown_as = truth(stack, everywhere - placed.films), rendered(placed.slots)
    wanted = original()
    color, found = solve(shown_as, mean(wanted), placed.slots.color)
    if placed.films and filmed is not None:
        wanted = truth(stack, everywhere)()
        color, found = solve_near(filmed(placed.slots), wanted)
    match = compared(wanted, found, without_film=bool(placed.films) and filmed is None)
    losses = [*placed.losses, *unmatched("base color", color, match.mean_error)]
    colors = color_map(original, shown_as) if textured and placed.owners[BASE] < 0 and color_key(stack.base) in stack.base else None
    return placed.slots.with_color(color), placed.owners, Report(tuple(losses), match), colors


def slots_to_stack(slots: Slots, original: Albedos, look: Appearance, name: str, source: str, losses: list[Loss], textured: bool = False) -> Converted:
    """The stack that is as bright as what its file says. `values` is left empty.

    `original` gives the albedo by the file's base color, for textures; `look` is that of its own color, with what no
    stack can have. Raises LaminaError where nothing that is seen would be left.
    """
    stack, owners = to_stack(slots, name, source, losses)
    most = MOST_REFLECTANCE if slots.is_metal else 1.0
    stack, color, report = matched(stack, truth, stack.base[color_key(stack.base)], most, look, name, losses)
    colors = color_map(original, truth(stack), most) if textured else None
    return Converted(with_color(stack, color), {}, slots, owners, report, colors)


def with_body(slots: Slots, free_path: float, g: float, textured: bool, names: Sequence[str], values: dict, losses: list[Loss]) -> Slots:
    """Slots whose diffuse base is a medium without end, of a mean free path in thicknesses; what becomes of the inputs `names` goes to the losses.

    `textured`: whether an image has the color, which only a diffuse base follows.
    """
    features = slots.gloss.features if slots.gloss else {}
    if textured or features or slots.sigma_deg:
        if textured:
            why = Sentence("which follows a texture of the color")
        else:
            why = Sentence("under {features}", features=" and ".join(features)) if features else Sentence("under a rough diffuse base")
        how = Sentence("as a diffuse base of the color, {why}", why=why)
        losses += [Loss(name, values[name], APPROXIMATED, how) for name in names]
        return slots
    body = Body.of(free_path, g)
    told_as = Sentence(
        "a medium without end of the color, of density {density:.4g} and forwardness {g:.3g}; it spreads no light sideways", density=body.density, g=body.g
    )
    losses += [Loss(name, values[name], APPROXIMATED, told_as) for name in names]
    return replace(slots, body=body)


def matched(
    stack: Stack, exact: Callable[[Stack], Albedos], start, most: float, look: Appearance, name: str, losses: list[Loss], tolerance: float = TOLERANCE
) -> tuple[Stack, np.ndarray, Report]:
    """The stack, the base color (3,), from `start` on and up to `most`, that makes it as bright as what its file says, and the report.

    `exact` gives a stack's albedos. Where no color is bright enough below a tinted medium, that is made lighter. Raises
    LaminaError where nothing that is seen would be left.
    """
    has_film = any(e.has(THIN_FILM) and e["film_thickness"] for e in (*stack.layers, stack.base))
    if np.max(mean(look.seen)) < _SEEN and look.lost and not has_film:
        raise LaminaError(
            "{name}: nothing that is seen would be left: all light is of {lost}, which no stack has", name=name or "material", lost=", ".join(look.lost)
        )
    wanted = mean(look.solid)
    color, found = solve(exact(stack), wanted, start, most, tolerance)
    tinted = next((i for i, e in enumerate(stack.layers) if "tint" in e and min(e["tint"]) < 1.0 and e["thickness"] > 0.0), None)
    if tinted is not None and np.max(wanted - mean(found)) > _REACHED:
        given = stack.layers[tinted]["tint"]

        def lightened(tint) -> Stack:
            layer = stack.layers[tinted].with_values(tint=tuple(float(c) for c in tint))
            return replace(stack, layers=(*stack.layers[:tinted], layer, *stack.layers[tinted + 1 :]))

        tint, found = solve(lambda tint: exact(lightened(tint))(color), wanted, np.array(given), 1.0, tolerance)
        stack = lightened(tint)
        how = Sentence("lighter, {tint}, as light crosses a layer aslant and more than once, and no base below is bright enough", tint=shown(tint))
        losses = [*losses, Loss("tint", given, APPROXIMATED, how)]
    losses = [*losses, *unmatched("base color", color, mean(found) - wanted)]
    return stack, color, Report(tuple(losses), compared(look.seen, found, has_film, look.all_lost))


def unmatched(parameter: str, color: np.ndarray, off: np.ndarray) -> list[Loss]:
    """What to say of a mean albedo that is off by (3,); nothing where it was reached."""
    if np.max(np.abs(off)) <= _REACHED:
        return []
    return [
        Loss(
            parameter, color, APPROXIMATED, Sentence("no color in range is as bright or dark as it should be; the mean albedo is off by {off}", off=shown(off))
        )
    ]


def told(losses: list[Loss], values: dict, defaults: dict) -> list[Loss]:
    """The losses of inputs that are not at their defaults: the others say nothing about a material."""
    return [loss for loss in losses if loss.parameter not in defaults or isinstance(loss.value, str) or not is_default(loss.parameter, values, defaults)]


def is_default(parameter: str, values: dict, defaults: dict) -> bool:
    """Whether a value is its default."""
    return bool(np.all(np.abs(np.asarray(values[parameter], float) - np.asarray(defaults[parameter], float)) <= 1e-6))


def lost_if(losses: list[Loss], parameter: str, value, default, how: Sentence) -> None:
    """Add a loss where a value is not its default."""
    if np.any(np.abs(np.asarray(value, float) - np.asarray(default, float)) > 1e-6):
        losses.append(Loss(parameter, value, LOST, how))


def require_finite(values: dict, name: str) -> None:
    """Raise LaminaError for a value that is no number."""
    for parameter, value in values.items():
        if not np.all(np.isfinite(value)):
            raise LaminaError("{name}: {parameter} is {value}; choose a finite number", name=name, parameter=parameter, value=shown(value))
