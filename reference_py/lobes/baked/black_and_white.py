# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse bases of any color: the lobes of a stack over black and over white at once, and what of a base's light each of them has.

Light from the base leaves a rough or a tinted coat as no Lambert lobe does, so that all fitted lobes have part of it. What they have over
any color lies between what they have over black and over white.
"""

from dataclasses import replace

import numpy as np

from ...material.stack import Stack
from ...optics.optical_stack import OpticalStack
from ..diffuse_ramp import RAMP_COSINES, ramp_of
from ..live_grid import MIN_ENERGY
from ..samples import view_of
from ..truth import truth_of
from ..view_table import BASE_COLOR, KNOTS, BaseColorTable, DiffuseTable, TableLobes, interpolate, is_glossy, knot_cosines

# Beside white, the color at which the energy of a rough diffuse base is right.
_SOME_COLOR = 0.3


def over(stack: Stack, grey: float) -> Stack:
    """The stack over a base of this grey."""
    return BASE_COLOR.with_value(stack, (grey,) * len(stack.base["color"]))


class BlackAndWhite:
    """The truths of a stack over a black base and over a white one, as one of twice as many channels."""

    def __init__(self, stack: Stack):
        self.black, self.white = (truth_of(over(stack, grey)) for grey in (0.0, 1.0))

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """(..., 6)."""
        return np.concatenate([truth.f(wo, wi) for truth in (self.black, self.white)], axis=-1)

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """(..., 6)."""
        return np.concatenate([truth.albedo(wo) for truth in (self.black, self.white)], axis=-1)

    def specular_albedo(self, cos_theta: np.ndarray) -> np.ndarray:
        """(..., 6)."""
        return np.concatenate([truth.specular_albedo(cos_theta) for truth in (self.black, self.white)], axis=-1)


def base_of(truth, stack: Stack) -> BaseColorTable:
    """All that a diffuse base of any color adds to layers whose truth over a black base is known; the color is that of `stack`."""
    return BaseColorTable(np.zeros((KNOTS, 3)), *light_of(truth), np.array(stack.base["color"]))


def light_of(truth) -> tuple[np.ndarray, np.ndarray]:
    """`through` and `back` (KNOTS, c) of a `BaseColorTable` for the layers of a stack over a black base, whose truth is known.

    Light that meets a Lambert base has lost its direction: three numbers per view say all. A rough one keeps some, and they
    are those that are right at two colors.
    """
    here = truth.stack
    layers = truth.layer_energies()
    back, escapes = layers.diffuse_below
    if OpticalStack.of(here).base.sigma_deg == 0.0:
        return layers.above(knot_cosines())[1] * escapes, np.broadcast_to(back, (KNOTS, len(back)))
    views = np.stack([view_of(c) for c in knot_cosines()])
    some, all_ = (truth_of(over(here, grey)).albedo(views) - truth.albedo(views) for grey in (_SOME_COLOR, 1.0))
    # of through c / (1 - back c)
    ratio = all_ * _SOME_COLOR / np.maximum(some, MIN_ENERGY)
    back = np.clip((ratio - 1.0) / (ratio - _SOME_COLOR), 0.0, 0.999)
    return all_ * (1.0 - back), back


def followed(tables: TableLobes, base: BaseColorTable) -> TableLobes:
    """The lobes of six channels over `BlackAndWhite` as those of three over any color; what is the same over both stays a table of its own."""
    result = []
    for table in tables.tables:
        black, white = table.weight[:, :3], table.weight[:, 3:]
        has_ramp = isinstance(table, DiffuseTable) and table.ramp is not None
        if np.array_equal(black, white):
            result.append(replace(table, weight=black, **({"ramp": None} if has_ramp else {})))
            continue
        through = (white - black) * (1.0 - base.back)
        shape = {"distribution": table.distribution, "shape": table.shape} if is_glossy(table) else {}
        ramp = ramp_of(interpolate(through, RAMP_COSINES)) if has_ramp else None
        result.append(replace(base, own=black, through=through, ramp=ramp, **shape))
    return TableLobes(tuple(result))
